from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from tolman.scripts.cli.program import execute


def test_the_list_has_every_behavior_strongest_first(capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["plugins"]) == 0
    lines = capsys.readouterr().out.splitlines()
    names = [line.split()[0] for line in lines if line.startswith("  ")]
    assert names.index("obstacle-avoidance") < names.index("wall-following") < names.index("wander")


def test_the_list_as_json_names_origins(capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["plugins", "list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    wander = next(entry for entry in found["behaviors"] if entry["name"] == "wander")
    assert wander["origin"] == "tolman (tolman.behaviors.wander:Wander)"
    assert [entry["name"] for entry in found["mediators"]] == ["blend", "priority", "subsumption"]


def test_a_new_plugin_is_written_listed_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert execute(["plugins", "new", "turn-back", "--folder", str(tmp_path)]) == 0
    assert execute(["plugins", "--plugins", str(tmp_path)]) == 0
    assert "turn-back" in capsys.readouterr().out
    assert execute(["plugins", "check", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["passed"] is True


def test_a_plugin_to_fix_gives_status_1_and_what_to_fix(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    execute(["plugins", "new", "turn-back", "--folder", str(tmp_path)])
    path = tmp_path / "turn_back.py"
    written = path.read_text()
    broken = written.replace("WheelCommand(self.config.speed, self.config.speed)", "WheelCommand(1 / 0, 0.0)")
    assert broken != written
    path.write_text(broken)
    assert execute(["plugins", "check", str(path)]) == 1
    assert "FIX  sane proposals: ZeroDivisionError" in capsys.readouterr().out


def test_a_diagram_is_printed_or_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["plugins", "diagram", "wander"]) == 0
    assert capsys.readouterr().out.startswith("stateDiagram-v2")
    picture = tmp_path / "wander.png"
    assert execute(["plugins", "diagram", "wander", "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert execute(["plugins", "diagram", "wander", "-o", str(picture)]) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", "wandr"], "unknown behavior 'wandr'; did you mean 'wander'?"),
        (["check"], "needs a name"),
        (["chekc", "wander"], "'chekc' is none of list, check, new, diagram"),
        (["check", "nowhere.py"], "nowhere.py"),
        (["new", "Turn"], "cannot name a behavior"),
        (["diagram", "wander", "-o", "picture.txt"], "does not end in .png"),
        (["--plugins", "nowhere"], "no such folder"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = execute(["plugins", *arguments])
    except SystemExit as left:
        status = int(str(left.code))
    assert status == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_plugin_that_prints_spoils_no_json(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    execute(["plugins", "new", "turn-back", "--folder", str(tmp_path)])
    path = tmp_path / "turn_back.py"
    path.write_text(path.read_text() + "\nimport os\nprint('loud')\nos.write(1, b'louder')\n")
    capfd.readouterr()
    assert execute(["plugins", "list", "--json", "--plugins", str(tmp_path)]) == 0
    out, err = capfd.readouterr()
    assert "turn-back" in [each["name"] for each in json.loads(out)["behaviors"]]
    assert "loud" in err


def test_nothing_of_isolated_plugins_is_imported_to_list_or_draw_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    execute(["plugins", "new", "turn-back", "--folder", str(tmp_path)])
    (tmp_path / "exits.py").write_text("import os\nos._exit(0)\n")
    capsys.readouterr()
    assert execute(["plugins", "list", "--isolate", "--plugins", str(tmp_path)]) == 0
    shown = capsys.readouterr()
    assert "turn-back" in shown.out
    assert "exits.py: in its subprocess: the subprocess has ended (exit status 0)" in shown.err
    assert execute(["plugins", "diagram", "turn-back", "--isolate", "--plugins", str(tmp_path)]) == 0
    assert "stateDiagram-v2" in capsys.readouterr().out
    assert not [name for name in sys.modules if name.startswith("tolman_plugin_exits")]


def test_a_plugin_that_exits_while_it_is_checked_gets_no_verdict(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "exits.py"
    path.write_text("import os\nos._exit(0)\n")
    assert execute(["plugins", "check", str(path)]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
