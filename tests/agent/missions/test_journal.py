from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from tolman.agent.errors import MissionError
from tolman.agent.listener import Outcome
from tolman.agent.missions.journal import Journal

WHOLE = """{"tolman-mission": 1, "mission": "m"}
{"path": "1", "step": "GoTo()", "succeeded": true, "value": 5, "reason": ""}
"""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "line 1: damaged"),
        ('{"tolman-mission": 9}\n', "not a mission's journal of version 1"),
        ('{"tolman-mission": 1, "mission": "other"}\n', "the journal of 'other', not of 'm'"),
        ('{"tolman-mission": 1, "mission": "m"}\nrubbish\n', "line 2: damaged"),
        ('{"tolman-mission": 1, "mission": "m"}\n{"path": "1"}\n', "line 2: damaged"),
        ("5\n", "line 1: damaged"),
        ("[" * 100_000 + "\n", "line 1: damaged"),
        ('{"tolman-mission": 1, "mission": "m"}\n' + "[" * 100_000 + "\n", "line 2: damaged"),
        ('{"tolman-mission": 1, "mission": [1]}\n', "the journal of \\[1\\], not of 'm'"),
        (WHOLE.replace("5", '{"$enum": "FollowFrom.NO"}'), "line 2: damaged"),
        (WHOLE.replace("5", '{"$": "Pose", "z": 1}'), "line 2: damaged"),
        (WHOLE.replace("5", '{"$array": [1], "dtype": "O"}'), "line 2: damaged"),
        (WHOLE.replace("GoTo", "\xff"), "not a text file"),
    ],
)
def test_a_damaged_or_foreign_journal_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "journal"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(MissionError, match=said) as caught:
        Journal(path, mission="m", resume=True)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == text.encode("latin-1")


def test_a_device_is_no_journal() -> None:
    with pytest.raises(MissionError, match="/dev/zero: a device"):
        Journal(Path("/dev/zero"), mission="m", resume=True)


def test_a_class_in_a_journal_that_nobody_declares_stays_a_dictionary(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    path.write_text(WHOLE.replace("5", '{"$": "os.system", "command": "ls"}'))
    outcome = Journal(path, mission="m", resume=True).recall("1", "GoTo()")
    assert outcome == Outcome(True, {"$": "os.system", "command": "ls"})


def test_a_full_disk_names_the_journal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = Journal(tmp_path / "journal", mission="m")

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(MissionError, match="journal: cannot be written: No space left on device"):
        journal.record("1", "Nodes()", Outcome(True, [1]))
