import sys
import warnings

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
