from __future__ import annotations

import io
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import pytest
from tolman.scripts.cli.streams import escaped_streams


def test_nothing_that_a_terminal_may_obey_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with escaped_streams():
        print("a\x1b[31m\x07b\n\tc\u202e \udcff")
        print("\x9b2J", file=sys.stderr)
    shown = capsys.readouterr()
    assert shown.out == "a\\x1b[31m\\x07b\n\tc\\u202e \\udcff\n"
    assert shown.err == "\\x9b2J\n"


def test_a_warning_is_one_line_without_source_code() -> None:
    with escaped_streams():
        shown = warnings.formatwarning("a box\nwas left out", UserWarning, "program.py", 3)
    assert shown == "tolman: warning: a box was left out\n"


def test_the_streams_are_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    before = sys.stdout, sys.stderr, warnings.formatwarning
    with escaped_streams():
        assert sys.stdout is not before[0]
        assert sys.stdout.fileno
    assert (sys.stdout, sys.stderr, warnings.formatwarning) == before
    monkeypatch.setattr(sys, "stdout", None)
    with escaped_streams():
        print("to nobody")


class Full(io.StringIO):
    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


def test_messages_that_nobody_takes_end_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Full())
    with escaped_streams():
        print("progress", file=sys.stderr, flush=True)


def test_a_result_that_nobody_takes_is_an_error_that_names_stdout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", Full())
    with escaped_streams(), pytest.raises(OSError, match="No space left on device: 'stdout'"):
        print("result")


def test_what_other_threads_print_spoils_no_result(capsys: pytest.CaptureFixture[str]) -> None:
    with escaped_streams():
        thread = threading.Thread(target=lambda: print("noise"))
        thread.start()
        thread.join()
        print("{}")
    shown = capsys.readouterr()
    assert shown.out == "{}\n"
    assert "noise" in shown.err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirected", "status", "said"),
    [
        (">/dev/full", 1, "tolman: error: stdout: No space left on device\n"),
        (">&-", 0, ""),
        ("2>&- >/dev/null", 0, ""),
        ("2>/dev/full >/dev/null", 0, ""),
        ("<&- >&- 2>&-", 0, ""),
    ],
)
def test_closed_and_full_streams_cost_one_line_at_most(redirected: str, status: int, said: str) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    command = f"{sys.executable} -m tolman.scripts.cli worlds --json {redirected}"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (status, said)
