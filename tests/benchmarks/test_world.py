from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_benchmark_measures_every_part_beside_raw_dart(tmp_path: Path) -> None:
    out = tmp_path / "bench.json"
    command = ["-m", "benchmarks.bench", "--smoke", "--json", str(out)]
    done = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True, check=True)
    figures = json.loads(out.read_text())
    assert {"raw DART, wheels", "raw DART, planar", "tolman, wheels", "tolman, planar"} <= set(
        figures["in turns (s a tick)"]
    )
    parts = figures["by part (s a tick)"]
    for shares in parts.values():
        assert shares["physics"] > 0.0
        assert shares["behaviors"] > 0.0
    assert "whole step / raw DART loop" in done.stdout
    assert [row for row in figures["targets"] if row["name"].startswith("1000 boxes")]


@pytest.mark.slow
def test_a_short_soak_holds_its_memory() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.soak", "1000", "--world", "env1"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "grew by" in done.stdout
