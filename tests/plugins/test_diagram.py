from __future__ import annotations

from pathlib import Path

import pytest
from tolman.behaviors.obstacle_avoidance import ObstacleAvoidance
from tolman.plugins.diagram import draw, mermaid


def test_mermaid_text_has_the_start_and_every_transition() -> None:
    text = mermaid(ObstacleAvoidance)
    assert text.startswith("stateDiagram-v2\n")
    assert "[*] --> CLEAR" in text
    assert "CLEAR --> TURNING_LEFT: obstacle_on_right" in text
    assert "TURNING_RIGHT --> CLEAR: cleared" in text
    assert text.count("-->") == 5


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_drawing_is_the_same_to_the_byte_every_time(suffix: str, tmp_path: Path) -> None:
    paths = [tmp_path / f"{index}.{suffix}" for index in range(2)]
    for path in paths:
        draw(ObstacleAvoidance, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].stat().st_size > 1000
