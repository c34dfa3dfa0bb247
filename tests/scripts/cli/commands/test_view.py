from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from tolman.scripts.cli.program import execute
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["view", str(tmp_path / "gone.mcap")]) == 2
    assert "there is no such recording or map" in capsys.readouterr().err


@pytest.mark.e2e
def test_view_serves_the_page_until_it_is_interrupted(tmp_path: Path) -> None:
    path = tmp_path / "m.tolman"
    map_world(MapRequest(world="env1", output=path, global_only=True, max_nodes=1))
    command = [sys.executable, "-m", "tolman.scripts.cli", "view", str(path), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found
        with urllib.request.urlopen(found[0], timeout=10) as answer:
            assert answer.read().startswith(b"<!doctype html>")
        os.kill(process.pid, signal.SIGINT)
        assert process.wait(20) == 0
