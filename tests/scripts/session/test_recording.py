from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tolman.agent.errors import RecordingError
from tolman.agent.recording.reader import Recording
from tolman.scripts.session.recording import code_in, code_of, permitted

SCRIPT = "def mission():\n    yield\n"


def recording(attached: bytes = b"", code: Any = None, **request: Any) -> Recording:
    return Recording({"request": request, "code": code}, attachments={"mission": attached})


def test_a_mission_that_is_here_as_it_was_recorded_may_run(tmp_path: Path) -> None:
    path = tmp_path / "m.py"
    path.write_text(SCRIPT)
    told = permitted(Path("r"), recording(SCRIPT.encode(), mission=str(path)), trust=False)
    assert told == [f"the mission {path} (here as recorded)"]


@pytest.mark.parametrize("mission", ["m.py", "elsewhere.py", "m.py/", "./m.py/."])
def test_another_one_may_not_unless_it_is_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mission: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.py").write_text("import os")
    strange = recording(SCRIPT.encode(), mission=mission)
    with pytest.raises(RecordingError, match=r"r\.mcap: a replay would run the mission .* --trust"):
        permitted(Path("r.mcap"), strange, trust=False)
    assert permitted(Path("r.mcap"), strange, trust=True)


def test_a_mission_in_yaml_is_data() -> None:
    assert permitted(Path("r"), recording(b"steps: [nodes]", mission="m.yaml"), trust=False) == []


def test_plugins_may_run_where_no_file_of_their_folder_is_another(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("x = 1")
    (tmp_path / "_b.py").write_text("y = 1")
    known = recording(code=code_of([tmp_path]), plugins=[str(tmp_path)])
    assert permitted(Path("r"), known, trust=False) == [f"the plugins in {tmp_path} (here as recorded)"]
    (tmp_path / "_b.py").write_text("y = 2")
    with pytest.raises(RecordingError, match="a replay would run the plugins in"):
        permitted(Path("r"), known, trust=False)


@pytest.mark.parametrize("code", [None, [], 3, {"/nowhere": {}}, {}])
def test_plugins_nobody_knows_may_not_run(tmp_path: Path, code: Any) -> None:
    for folder in ("/nowhere", str(tmp_path), "\0", "/dev/null"):
        assert [each.known for each in code_in(recording(code=code, plugins=[folder]))] == [False]
