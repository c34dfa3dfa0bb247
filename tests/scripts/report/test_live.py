from __future__ import annotations

import base64
import json
import threading
import urllib.request
from pathlib import Path
from typing import Any

import pytest
from tolman.scripts.report.live import live_page
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world

from .browser import CHROMIUM, Browser

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


def read(text: str) -> list[tuple[str, Any]]:
    """Kind and JSON part of each thing that was sent."""
    found = []
    for block in text.strip().split("\n\n"):
        kind, _, data = block.partition("\n")
        packed = base64.b64decode(data.removeprefix("data:").strip())
        size = int.from_bytes(packed[:4], "little")
        found.append((kind.removeprefix("event: "), json.loads(packed[4 : 4 + size]) if packed else None))
    return found


def test_without_a_port_nothing_looks_on() -> None:
    with live_page(None, print) as watch:
        assert watch is None


def test_a_run_is_the_same_with_a_viewer_who_gets_it_all(tmp_path: Path) -> None:
    told: list[str] = []
    got: list[str] = []

    def view() -> None:
        with urllib.request.urlopen(f"{told[0]}events", timeout=60) as answer:
            got.append(answer.read().decode())

    plain, seen = tmp_path / "plain.tolman", tmp_path / "seen.tolman"
    map_world(MapRequest(world="env1", output=plain, max_nodes=2))
    with live_page(0, told.append) as watch:
        viewer = threading.Thread(target=view)
        viewer.start()
        map_world(MapRequest(world="env1", output=seen, max_nodes=2), watch=watch)
    viewer.join(20.0)
    assert plain.read_bytes() == seen.read_bytes()
    parts = read(got[0])
    kinds = [kind for kind, _ in parts]
    assert (kinds[0], kinds[-1]) == ("begin", "end")
    ticks = [part for kind, part in parts if kind == "ticks"]
    ends = [chunk["first"] + chunk["count"] for chunk in ticks]
    assert [chunk["first"] for chunk in ticks] == [0, *ends[:-1]]
    events = [event for chunk in ticks for event in chunk["events"]]
    assert [event[4]["node"] for event in events if event[2] == "NodeCreated"] == [0, 1]
    nodes = [node for kind, part in parts if kind == "map" for node in part["nodes"]]
    assert {node["node"] for node in nodes if node["local"] is not None} == {0, 1}


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (apt-get install chromium)")
@pytest.mark.slow
def test_the_page_follows_a_run_and_stays_when_it_is_over(tmp_path: Path) -> None:
    told: list[str] = []
    with Browser(tmp_path / "profile") as browser:
        with live_page(0, told.append) as watch:
            browser.call("Page.navigate", url=told[0])
            browser.wait("document.body?.dataset.ready === 'yes'")
            map_world(MapRequest(world="env1", max_nodes=2), watch=watch)
        browser.wait("document.getElementById('status').textContent === 'the run is over'")
        browser.settle()
        assert browser.run("tolman.run.nodes.size") == 2
        assert browser.run("tolman.time === tolman.run.end")
        browser.press("ArrowLeft", shift=True)
        assert browser.run("tolman.run.end - tolman.time") == pytest.approx(1.0, abs=0.1)
        assert browser.problems == []
