from __future__ import annotations

import pytest
from tolman.agent.islands.outlines import Outline
from tolman.agent.islands.sweep import Sweep, uncovered

from .rooms import ISLAND, QUARTER, ROOM


def test_lines_of_a_sweep_end_at_walls_and_at_islands() -> None:
    sweep = Sweep.over(ROOM, 0.3)
    assert len(sweep.lines) == 3
    through = sweep.chords([ROOM, ISLAND], 1)
    assert [chord.length for chord in through] == pytest.approx([0.4, 0.4])
    assert [(chord.start.outline, chord.end.outline) for chord in through] == [(0, 1), (1, 0)]
    beside = sweep.chords([ROOM, ISLAND], 0)
    assert [chord.length for chord in beside] == pytest.approx([1.0])
    assert sweep.place(beside[0].u, beside[0].v0) == pytest.approx((0.3, 0.0))
    assert sweep.heading(beside[0].back) == pytest.approx(-QUARTER)


def test_an_island_over_another_hides_nothing() -> None:
    sweep = Sweep.over(ROOM, 0.3)
    again = Outline(tuple((x + 0.02, y + 0.02) for x, y in ISLAND.points))
    lengths = [chord.length for chord in sweep.chords([ROOM, ISLAND, again], 1)]
    assert lengths == pytest.approx([0.4, 0.38])


@pytest.mark.parametrize(
    ("driven", "left"),
    [([], 1.0), ([(0.0, 0.4)], 0.6), ([(0.7, 0.3), (0.9, 1.2)], 0.3), ([(-1.0, 2.0)], 0.0)],
)
def test_what_is_left_of_a_line_is_its_longest_piece(driven: list[tuple[float, float]], left: float) -> None:
    assert uncovered(1.0, 0.0, driven) == pytest.approx(left)
