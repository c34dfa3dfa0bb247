from __future__ import annotations

from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer
from tolman.agent.errors import RecordingError
from tolman.agent.recording.reader import percept_of, read_recording
from tolman.world.robot import Percept


def write_mcap(path: Path, header: str, messages: bytes = b"") -> None:
    """A recording with this header and what a chunk holds, made by hand."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start()
        writer.add_metadata("tolman", {"version": "1", "header": header})
        number = writer.register_channel("/event", "json", writer.register_schema("x", "jsonschema", b"{}"))
        writer.add_message(number, 0, messages, 0)
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("header", ["", "{", "[]", "3", '"x"', "[" * 100_000, "\x00"])
def test_a_broken_header_is_one_line(tmp_path: Path, header: str) -> None:
    path = tmp_path / "run.mcap"
    write_mcap(path, header)
    with pytest.raises(RecordingError, match=r"run\.mcap: its header is ") as caught:
        read_recording(path)
    assert len(str(caught.value)) < 300


def test_what_unpacks_to_many_times_its_size_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    monkeypatch.setattr("tolman.agent.recording.reader.MAX_UNPACKED", 1_000_000)
    write_mcap(path, "{}", b" " * 20_000_000)
    with pytest.raises(RecordingError, match="it unpacks to more than ten times its size"):
        read_recording(path)


PERCEPT = {"tick": 1, "time": 0.0, "infrared": [0, 1.5], "encoders": [0, 0], "readings": {"range": [0.5]}}


def test_a_percept_comes_back_by_its_fields() -> None:
    assert percept_of(PERCEPT) == Percept(1, 0.0, (0, 1.5), (0, 0), readings={"range": (0.5,)})


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("smell", 1, r"percepts with 'smell'; known: .*infrared"),
        ("tick", 1.5, "a percept with 1.5 for tick"),
        ("tick", True, "a percept with True for tick"),
        ("time", [0], "for time"),
        ("infrared", 5, "for infrared"),
        ("infrared", ["a"], "for infrared"),
        ("encoders", [1, 2, 3], "for encoders"),
        ("readings", [1], "for readings"),
        ("readings", {"range": 0.5}, "for readings"),
    ],
)
def test_a_percept_that_is_none_is_refused(field: str, value: object, said: str) -> None:
    with pytest.raises(RecordingError, match=said):
        percept_of({**PERCEPT, field: value})


def test_a_missing_recording_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no such file"):
        read_recording(tmp_path / "none")
