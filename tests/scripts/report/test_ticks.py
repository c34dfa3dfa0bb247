from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
from tolman.agent.recording.reader import RecordedTick
from tolman.plugins.testing import percept
from tolman.scripts.report.packing import Series
from tolman.scripts.report.ticks import Gatherer
from tolman.world.robot import EPUCK, Pose, WheelCommand


def tick(number: int, **values: Any) -> RecordedTick:
    found = RecordedTick(percept(tick=number), command=WheelCommand(100.0, 120.0))
    for name, value in values.items():
        setattr(found, name, value)
    return found


def numbers(series: Series) -> list[float]:
    return list(np.asarray(series.values, dtype=float))


def test_what_is_believed_begins_where_the_robot_truly_began() -> None:
    gatherer = Gatherer(EPUCK)
    gatherer.add(tick(0, truth=Pose(1.0, 2.0, np.pi / 2), pose=Pose()))
    gatherer.add(tick(1, truth=Pose(1.0, 2.1, np.pi / 2), pose=Pose(0.1, 0.0, 0.0)))
    x, y, _ = gatherer.take()["believed"]
    np.testing.assert_allclose(numbers(x), [1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(numbers(y), [2.0, 2.1], atol=1e-9)


def test_a_recording_that_does_not_say_what_was_believed_is_integrated() -> None:
    gatherer = Gatherer(EPUCK)
    for number in range(3):
        gatherer.add(RecordedTick(percept(tick=number, encoders=(100.0 * number, 100.0 * number))))
    x, _, _ = gatherer.take()["believed"]
    np.testing.assert_allclose(numbers(x), [0.0, 0.01288, 0.02576], atol=1e-4)


def test_proposals_become_levels_and_changes_of_reason() -> None:
    gatherer = Gatherer(EPUCK)
    gatherer.add(tick(0, proposals=[["shy", 15, 0.0, 0.0, 1.0, "calm"]], driver="shy"))
    gatherer.add(tick(1, proposals=[["shy", 15, 0.0, 0.0, 0.5, "calm"]], driver="shy"))
    gatherer.add(tick(2, proposals=[], driver=None))
    gatherer.add(tick(3, proposals=[["shy", 15, 0.0, 0.0, 1.0, "afraid"]], driver="shy"))
    chunk = gatherer.take()
    assert chunk["activations"]["shy"].tolist() == [255, 128, 0, 255]
    at, text = chunk["reasons"]["shy"]
    assert numbers(at) == [0, 3]
    assert [chunk["texts"][int(each)] for each in numbers(text)] == ["calm", "afraid"]
    assert [["", *chunk["names"]][each] for each in chunk["driver"]] == ["shy", "shy", "", "shy"]


def test_states_are_kept_where_they_change_until_the_behavior_ends() -> None:
    gatherer = Gatherer(EPUCK)
    gatherer.add(tick(0, states={"shy": "CALM"}))
    gatherer.add(tick(1))
    gatherer.add(tick(2, states={"shy": "TURNING"}))
    gatherer.add(tick(3, states={}))
    chunk = gatherer.take()
    at, text = chunk["states"]["shy"]
    assert numbers(at) == [0, 2, 3]
    assert numbers(text)[2] == -1


def test_distances_are_those_that_the_raw_values_mean() -> None:
    gatherer = Gatherer(EPUCK)
    raw = (4095.0, 120.0, 0.0, 0.0, 0.0, 0.0, 0.0, 67.0)
    gatherer.add(RecordedTick(replace(percept(), infrared=raw)))
    shares = gatherer.take()["infrared"].tolist()
    assert shares[:3] == [0, round(254 * 0.05 / 0.07), 255]
    assert shares[7] == 254


def test_a_second_part_has_only_what_is_new() -> None:
    gatherer = Gatherer(EPUCK)
    gatherer.add(tick(0, driver="shy", proposals=[["shy", 15, 0.0, 0.0, 1.0, "calm"]]))
    gatherer.take()
    gatherer.add(tick(1, driver="bold", proposals=[["bold", 20, 0.0, 0.0, 1.0, "calm"]]))
    chunk = gatherer.take()
    assert (chunk["first"], chunk["count"]) == (1, 1)
    assert chunk["names"] == ["bold"]
    assert chunk["texts"] == []
    assert chunk["driver"].tolist() == [2]


def test_events_are_told_in_words_and_stand_in_a_row() -> None:
    event = {"$": "BehaviorFaulted", "time": 0.1, "behavior": "shy", "state": "CALM", "fault": "oh"}
    gatherer = Gatherer(EPUCK)
    gatherer.add(tick(0, events=[json.dumps(event | {"disabled": False}), '{"$": "ControlChanged"}']))
    first, second = gatherer.take()["events"]
    assert first[:3] == [0, "fault", "BehaviorFaulted"]
    assert "shy STOPPED in state CALM: oh" in first[3]
    assert second[1] == "control"
