"""Scores of runs: what is kept, and how a mapping ended."""

from collections.abc import Callable
from typing import Any

import pytest
from tolman.scripts.experiments.results.scores import SCORES, Runs, closing, kept

Make = Callable[..., Any]


def test_a_variant_keeps_what_gives_up_a_third_of_the_margin_and_no_more(mapping: Make, trip: Make) -> None:
    """Map error in env1: target 1 cm, published 7: 3 cm are allowed."""
    error = next(score for score in SCORES if score.name == "map error (cm)")
    assert error.limit(0) == pytest.approx(3.0)
    assert kept(Runs(maps=[mapping(position_error_m=0.029)]), 0) == []
    assert kept(Runs(maps=[mapping(position_error_m=0.031)]), 0) == ["map error (cm)"]
    assert kept(Runs(maps=[mapping()], corrected=[trip(completed=False)]), 0) == ["runs lost"]


def test_saying_ambiguous_is_neither_right_nor_wrong(mapping: Make) -> None:
    assert closing(mapping(loop_correct=None, reason="ambiguous: four equal corners")) == "ambiguous"
    assert closing(mapping(loop_correct=False)) == "wrong"
    assert closing(mapping(loop_correct=None, reason="max time")) == "missed"
