"""The command line before any command runs: parsing, suggestions, error lines, exit statuses."""

import argparse
import contextlib
import errno
import io
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.scripts.cli import program as cli
from tolman.scripts.cli.options import integer, node, number, one_of, picture, pose
from tolman.scripts.cli.output import ProgressLine, check_input, check_output, stdout_to_stderr
from tolman.scripts.errors import UsageError, did_you_mean, status_of
from tolman.scripts.plain import plain


def outcome(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    try:
        status = cli.execute(arguments)
    except SystemExit as stop:
        status = int(stop.code or 0)
    printed = capsys.readouterr()
    return status, printed.out, printed.err


def test_help_lists_every_command_that_is_there(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = outcome(capsys, "--help")
    assert status == 0
    assert err == ""
    for name in cli.COMMANDS:
        assert f"\n  {name} " in out


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_explains_itself(capsys: pytest.CaptureFixture[str], name: str) -> None:
    status, out, _ = outcome(capsys, name, "--help")
    assert status == 0
    assert f"usage: tolman {name}" in out
    assert cli.load(name).name == name


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "name a command"),
        (["mpa"], "did you mean 'map'?"),
        (["map"], "required: WORLD, -o/--output"),
        (["map", "env1", "-o", "m", "--max-node", "3"], "did you mean '--max-nodes'?"),
        (["map", "env1", "-o", "m", "--side", "rihgt"], "did you mean 'right'?"),
        (["map", "env1", "-o", "m", "--max-nodes", "0"], "0 is not in 1.."),
        (["map", "env1", "-o", "m", "--seed", "-1"], "-1 is not in 0.."),
        (["map", "env1", "-o", "m", "--max-time", "nan"], "nan is not a number > 0"),
        (["map", "env1", "-o", "m", "--noise-scale", "-1"], "-1 is not a number >= 0"),
        (["map", "env1", "-o", "m", "--noise", "lots"], "'lots' is none of none, encoder, thesis"),
        (["map", "env1", "-o", "m", "--start", "1,2"], "is not X,Y,HEADING"),
        (["map", "env1", "-o", "m", "--figure", "m.txt"], "does not end in .png"),
        (["go", "m", "--to", "1", "--lost", "--from", "2"], "not allowed with"),
    ],
)
def test_bad_usage_is_one_line_and_status_2(
    capsys: pytest.CaptureFixture[str], arguments: list[str], expected: str
) -> None:
    status, out, err = outcome(capsys, *arguments)
    assert status == 2
    assert out == ""
    assert err.startswith("tolman: error: ")
    assert err.count("\n") == 1
    assert expected in err


def test_suggestions_are_made_for_near_names_alone() -> None:
    assert did_you_mean("env11", ["env1", "office"]) == "; did you mean 'env1'?"
    assert did_you_mean("zzz", ["env1", "office"]) == ""


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-360, 360))
def test_a_pose_is_read_in_meters_and_degrees(x: float, y: float, degrees: float) -> None:
    read = pose(f"{x!r},{y!r},{degrees!r}")
    assert (read.x, read.y) == (x, y)
    assert math.cos(read.heading) == pytest.approx(math.cos(math.radians(degrees)), abs=1e-9)
    assert math.sin(read.heading) == pytest.approx(math.sin(math.radians(degrees)), abs=1e-9)


@given(st.text())
def test_no_text_breaks_an_argument_type(text: str) -> None:
    for convert in (pose, number(0), integer(0), one_of("a", "b"), picture, node):
        with contextlib.suppress(argparse.ArgumentTypeError):
            convert(text)


def test_coordinates_may_begin_with_a_minus() -> None:
    assert cli.join_values(["--start", "-1,2,3", "-o", "x"]) == ["--start=-1,2,3", "-o", "x"]
    assert cli.join_values(["--seed", "-1"]) == ["--seed", "-1"]


def test_live_may_stand_without_a_port() -> None:
    assert cli.join_values(["--live", "8000", "x"]) == ["--live", "8000", "x"]
    assert cli.join_values(["--live", "env1", "--live"]) == ["--live=0", "env1", "--live=0"]


def test_a_node_is_a_number_or_a_name() -> None:
    assert node("7") == 7
    assert node("kitchen") == "kitchen"


def test_an_existing_output_is_refused_unless_replaced(tmp_path: Path) -> None:
    kept = tmp_path / "m.tolman"
    kept.write_bytes(b"kept")
    with pytest.raises(UsageError, match="exists; --force replaces it"):
        check_output(kept, replace=False)
    assert check_output(kept, replace=True) == kept
    assert kept.read_bytes() == b"kept"


def test_an_output_that_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no folder"):
        check_output(tmp_path / "missing" / "m.tolman", replace=False)
    with pytest.raises(UsageError, match="is a folder"):
        check_output(tmp_path, replace=True)
    with pytest.raises(UsageError, match="cannot write in /proc"):
        check_output(Path("/proc/m.tolman"), replace=False)


def test_checking_an_output_leaves_nothing_behind(tmp_path: Path) -> None:
    check_output(tmp_path / "m.tolman", replace=False)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_input_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"nowhere\.tolman: there is no such map"):
        check_input(tmp_path / "nowhere.tolman", "map")
    with pytest.raises(UsageError, match="a folder, not a file; name a regular file; it should be a map"):
        check_input(tmp_path, "map")


def test_json_has_no_numpy_and_no_nan() -> None:
    value = {"a": np.float64(1.5), "b": float("nan"), "c": np.arange(2), 3: (np.int64(1), None, Path("x"))}
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == {
        "a": 1.5,
        "b": None,
        "c": [0, 1],
        "3": [1, None, "x"],
    }


def test_what_a_library_prints_does_not_reach_stdout(capfd: pytest.CaptureFixture[str]) -> None:
    with stdout_to_stderr():
        print("from Python")
        os.write(1, b"from C\n")
    print("the result")
    printed = capfd.readouterr()
    assert printed.out == "the result\n"
    assert "from Python" in printed.err
    assert "from C" in printed.err


def test_progress_without_a_terminal_is_held_back() -> None:
    stream = io.StringIO()
    line = ProgressLine(stream, interval=1000.0)
    for step in range(100):
        line.show(f"step {step}")
    line.close()
    assert stream.getvalue().count("\n") <= 1


class OurInputError(ValueError):
    __module__ = "tolman.maps.errors"


class OurRunError(RuntimeError):
    __module__ = "tolman.world.errors"


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (UsageError("x"), 2),
        (OurInputError("x"), 2),
        (OurRunError("x"), 1),
        (FileNotFoundError(errno.ENOENT, "x"), 2),
        (OSError(errno.ENOSPC, "No space left on device"), 1),
        (ValueError("a fault of ours"), None),
        (ZeroDivisionError(), None),
    ],
)
def test_errors_have_the_status_of_what_they_are(error: Exception, status: int | None) -> None:
    assert status_of(error) == status


def test_the_command_fixes_the_number_of_threads_before_numpy_is_loaded() -> None:
    program = (
        "import sys, tolman.scripts.cli.program as cli\n"
        "assert 'numpy' not in sys.modules\n"
        "sys.argv = ['tolman', '--version']\n"
        "try: cli.main()\n"
        "except SystemExit: pass\n"
        "import os; print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "7"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == "1"


def test_a_reader_that_goes_away_ends_the_command_quietly() -> None:
    done = subprocess.run(
        f"{sys.executable} -m tolman.scripts.cli --help | true",
        shell=True,
        capture_output=True,
        text=True,
    )
    assert "Traceback" not in done.stderr
