from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from tolman.scripts.report.packing import Series, pack, smallest


def read(data: bytes) -> tuple[Any, bytes]:
    size = int.from_bytes(data[:4], "little")
    return json.loads(data[4 : 4 + size]), data[4 + size :]


def test_an_array_lies_behind_the_text_at_a_multiple_of_eight() -> None:
    data = pack({"a": np.array([1, 2, 3], dtype=np.uint8), "b": np.array([7.5], dtype=np.float32)})
    told, arrays = read(data)
    assert (len(data) - len(arrays)) % 8 == 0
    assert told == {"a": {"$": [0, "B", 3]}, "b": {"$": [8, "f", 1]}}
    assert arrays[:3] == bytes([1, 2, 3])
    assert np.frombuffer(arrays[8:12], dtype="<f4")[0] == 7.5


def test_a_series_is_kept_as_differences_of_the_smallest_type() -> None:
    told, arrays = read(pack(Series([0.001, 0.003, 0.002], 0.001)))
    assert told == {"$": [0, "b", 3], "delta": 1, "step": 0.001}
    assert np.frombuffer(arrays[:3], dtype=np.int8).tolist() == [1, 2, -1]


def test_what_is_not_finite_counts_as_zero() -> None:
    assert Series([1.0, np.nan, np.inf]).differences().tolist() == [1, -1, 0]


def test_a_number_that_is_not_finite_becomes_nothing() -> None:
    assert read(pack({"a": [np.nan, 1.5]}))[0] == {"a": [None, 1.5]}


def test_an_empty_series_can_be_packed() -> None:
    told, _ = read(pack([Series([])]))
    assert told[0]["$"][2] == 0


@pytest.mark.parametrize(("value", "kind"), [(127, np.int8), (128, np.int16), (-40_000, np.int32)])
def test_numbers_take_no_more_room_than_they_need(value: int, kind: type) -> None:
    assert smallest(np.array([value])).dtype == kind


def test_arrays_that_the_page_cannot_read_are_refused() -> None:
    with pytest.raises(ValueError, match="int64"):
        pack(np.array([1, 2]))
