from __future__ import annotations

from pathlib import Path

import pytest
from tolman.agent import Agent
from tolman.agent.errors import RecordingError
from tolman.agent.recording.recorder import Recorder
from tolman.plugins.testing import ScriptedRobot, percept
from tolman.scripts.errors import UsageError
from tolman.scripts.report.packing import pack
from tolman.scripts.report.subject import read_subject

from .conftest import Runs

pytestmark = pytest.mark.slow
"""Whole runs: left out of `make check`."""


def test_a_recorded_mapping_comes_with_the_map_that_it_made(runs: Runs) -> None:
    subject = read_subject(runs.mapping)
    nodes = subject.content["map"]["nodes"]
    assert [node["node"] for node in nodes] == [0, 1]
    assert all(node["pose"] is not None and node["local"] is not None for node in nodes)
    assert str(runs.map) in subject.remarks[0]


def test_a_map_that_is_given_is_taken_without_a_word(runs: Runs) -> None:
    subject = read_subject(runs.mapping, runs.map)
    assert subject.remarks == ()
    assert subject.content["places"].keys() == {0, 1}


def test_a_trip_is_shown_on_the_map_it_drove_by(runs: Runs) -> None:
    content = read_subject(runs.trip).content
    assert [node["node"] for node in content["map"]["nodes"]] == [0, 1]
    assert content["ticks"]["beliefs"]
    assert content["about"]["kind"] == "trip"


def test_the_states_and_settings_of_behaviors_are_in_the_recording(runs: Runs) -> None:
    content = read_subject(runs.mapping).content
    following = next(each for each in content["behaviors"] if each["name"] == "wall-following")
    assert {"FOLLOW", "SEARCH"} <= set(following["states"])
    assert "distance" in following["settings"]
    assert "wall-following" in content["ticks"]["states"]
    assert content["walls"]


def test_a_map_file_is_shown_at_the_true_places_of_its_nodes(runs: Runs) -> None:
    content = read_subject(runs.map).content
    assert content["about"]["placed"] == "true"
    assert content["walls"]
    assert "ticks" not in content


def test_the_same_file_gives_the_same_bytes(runs: Runs) -> None:
    assert pack(read_subject(runs.mapping).content) == pack(read_subject(runs.mapping).content)


def test_a_recording_that_holds_anything_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "odd.mcap"
    agent = Agent(ScriptedRobot([percept()]), [])
    recorder = Recorder(path, agent, {"walls": [["a", 1]], "behaviors": [{"name": 3}], "request": {}})
    recorder.start()
    agent.tick()
    recorder.close()
    with pytest.raises(RecordingError, match=r"odd\.mcap: it holds what no page can show"):
        read_subject(path)


def test_a_recording_of_one_s_own_needs_no_world(tmp_path: Path) -> None:
    path = tmp_path / "own.mcap"
    agent = Agent(ScriptedRobot([percept(tick=tick) for tick in range(3)]), [])
    recorder = Recorder(path, agent, {"behaviors": [{"name": 3}]})
    recorder.start()
    for _ in range(3):
        agent.tick()
    recorder.close()
    content = read_subject(path).content
    assert (content["walls"], content["behaviors"], content["ticks"]["count"]) == ([], [], 3)


def test_a_second_map_beside_a_map_is_refused(runs: Runs) -> None:
    with pytest.raises(UsageError, match="goes with a recording"):
        read_subject(runs.map, runs.map)
