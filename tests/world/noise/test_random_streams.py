from __future__ import annotations

import numpy as np
import pytest
from tolman.world.noise.random_streams import ROWS, Rows, Streams, normal, uniform


@pytest.mark.parametrize(("draw", "single"), [(uniform, "random"), (normal, "standard_normal")])
@pytest.mark.parametrize("rows", [0, 1, ROWS - 1, ROWS, ROWS + 3])
def test_rows_and_state_are_those_of_a_generator_asked_row_by_row(
    draw: object, single: str, rows: int
) -> None:
    plain, ahead = np.random.default_rng(3), Rows(np.random.default_rng(3), draw, 3)  # type: ignore[arg-type]
    for _ in range(rows):
        assert ahead.row() == getattr(plain, single)(3).tolist()
    assert ahead.state == plain.bit_generator.state
    assert ahead.row() == getattr(plain, single)(3).tolist()


def test_a_state_put_back_gives_the_same_rows_again() -> None:
    draws = Rows(np.random.default_rng(4), normal, 8)
    for _ in range(5):
        draws.row()
    state = draws.state
    rows = [draws.row() for _ in range(100)]
    draws.state = state
    assert [draws.row() for _ in range(100)] == rows


def test_every_purpose_has_a_stream_of_its_own() -> None:
    purposes = ("mismatch", "encoder", "slip", "infrared", "camera", "accelerometer", "range", "another")
    robots = [Streams(5, robot) for robot in (0, 1)]
    draws = [float(streams.generator(purpose).random()) for streams in robots for purpose in purposes]
    assert len(set(draws)) == len(draws)


def test_a_stream_does_not_depend_on_who_else_draws() -> None:
    alone, among = Streams(5, 0), Streams(5, 0)
    among.rows("range", normal, 1).row()
    assert alone.rows("infrared", normal, 8).row() == among.rows("infrared", normal, 8).row()


def test_a_state_of_the_streams_put_back_repeats_what_followed() -> None:
    streams = Streams(5, 0)
    rows, generator = streams.rows("encoder", uniform, 2), streams.generator("camera")
    rows.row()
    state = streams.state()
    after = rows.row(), generator.random()
    streams.restore(state)
    assert (rows.row(), generator.random()) == after
