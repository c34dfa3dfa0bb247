from __future__ import annotations

import numpy as np
import pytest
from tolman.world.noise.random_streams import ROWS, Draws, normal, uniform


@pytest.mark.parametrize(("draw", "single"), [(uniform, "random"), (normal, "standard_normal")])
@pytest.mark.parametrize("rows", [0, 1, ROWS - 1, ROWS, ROWS + 3])
def test_rows_and_state_are_those_of_a_generator_asked_row_by_row(
    draw: object, single: str, rows: int
) -> None:
    plain, ahead = np.random.default_rng(3), Draws(np.random.default_rng(3), draw, 3)  # type: ignore[arg-type]
    for _ in range(rows):
        assert ahead.row() == getattr(plain, single)(3).tolist()
    assert ahead.state == plain.bit_generator.state
    assert ahead.row() == getattr(plain, single)(3).tolist()


def test_a_state_put_back_gives_the_same_rows_again() -> None:
    draws = Draws(np.random.default_rng(4), normal, 8)
    for _ in range(5):
        draws.row()
    state = draws.state
    rows = [draws.row() for _ in range(100)]
    draws.state = state
    assert [draws.row() for _ in range(100)] == rows
