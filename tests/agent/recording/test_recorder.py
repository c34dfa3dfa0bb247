from __future__ import annotations

import contextlib
import errno
import io
import os
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent, Behavior, Context, Proposal, Transition
from tolman.agent.errors import RecordingError
from tolman.agent.events import PluginEvent
from tolman.agent.listener import Outcome
from tolman.agent.recording.explain import timeline
from tolman.agent.recording.reader import read_percepts, read_recording
from tolman.agent.recording.recorder import Recorder
from tolman.agent.recording.replay import ReplayEnded, ReplayRobot, ReplayWorld
from tolman.plugins.testing import ScriptedRobot, percept
from tolman.world.robot import STOP, Pose, WheelCommand
from tolman.world.robot import Percept as RobotPercept


class Curious(Behavior):
    """Drives at random, takes an image every fifth tick and says how bright it is."""

    class States(Enum):
        ON = "on"
        OFF = "off"

    name = "curious"
    initial = States.ON
    transitions = (Transition("rest", States.ON, States.OFF),)

    def on_reset(self) -> None:
        self.gain = 1.0

    def on(self, percept: RobotPercept, context: Context) -> Proposal | None:
        if percept.tick % 5 == 0:
            brightness = float(context.look().mean())
            context.publish(PluginEvent(time=context.time, name="seen", data={"brightness": brightness}))
        speed = self.gain * float(context.rng.normal(200.0, 50.0)) + 0.01 * percept.infrared[2]
        return Proposal(WheelCommand(speed, -speed), 0.5, "curious")

    def off(self, percept: RobotPercept, context: Context) -> Proposal | None:
        return None


def record(path: Path, ticks: int = 40, truth: bool = True) -> Recorder:
    rng = np.random.default_rng(5)
    percepts = [percept(right=float(rng.uniform(0.0, 0.07)), tick=tick) for tick in range(ticks)]
    robot = ScriptedRobot(percepts, image=rng.random((16, 16), dtype=np.float32))
    agent = Agent(robot, [Curious()])
    poses = (lambda: Pose(len(robot.commands) * 0.1, 1.0 / 3.0, -0.5)) if truth else None
    recorder = Recorder(path, agent, {"seed": 0, "note": "ä"}, poses, {"map": b"\x00\x01"})
    recorder.start()
    agent.start("curious")
    for _ in range(ticks):
        agent.tick()
    recorder.close()
    recorder.close()
    assert agent.robot is robot
    return recorder


def replayed(path: Path, behavior: Behavior) -> ReplayRobot:
    world = ReplayWorld(read_recording(path))
    agent = Agent(world.robot, [behavior])
    world.robot.watch(agent)
    agent.start("curious")
    with contextlib.suppress(ReplayEnded):
        while True:
            agent.tick()
            world.step()
    return world.robot


def test_everything_comes_back_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path)
    recording = read_recording(path)
    assert recording.header == {"seed": 0, "note": "ä"}
    assert recording.attachments == {"map": b"\x00\x01"}
    assert len(recording.ticks) == 40
    rng = np.random.default_rng(5)
    first = recording.ticks[0]
    assert first.percept.infrared == percept(right=float(rng.uniform(0.0, 0.07))).infrared
    assert first.truth == Pose(0.1, 1.0 / 3.0, -0.5)
    assert first.images[0].shape == (16, 16)
    assert first.driver == "curious"
    assert any("BehaviorStarted" in event for event in first.events)


def test_what_the_agent_believed_and_the_states_of_its_behaviors_are_kept(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap")
    ticks = read_recording(tmp_path / "run.mcap").ticks
    assert ticks[0].states == {"curious": "ON"}
    assert all(tick.states is None for tick in ticks[1:])  # nothing has changed
    assert ticks[0].pose == Pose()
    assert all(tick.pose is not None for tick in ticks)


def test_a_replay_of_the_same_agent_is_identical_to_the_bit(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap")
    robot = replayed(tmp_path / "run.mcap", Curious())
    assert robot.difference is None
    assert robot.ticks == 40


class Ranging(Curious):
    """Slows down by what a further sensor reads, and looks in color."""

    def on(self, percept: RobotPercept, context: Context) -> Proposal | None:
        (ahead,) = percept.readings["range"]
        return Proposal(WheelCommand(100.0 * ahead, 100.0 * ahead), 0.5, "ranging")


def test_readings_of_further_sensors_and_color_images_are_recorded_and_replayed(tmp_path: Path) -> None:
    percepts = [replace(percept(tick=tick), readings={"range": (2.0 - tick / 7,)}) for tick in range(9)]
    picture = np.random.default_rng(1).random((6, 8, 3), dtype=np.float32)
    agent = Agent(ScriptedRobot(percepts, image=picture), [Ranging()])
    recorder = Recorder(tmp_path / "run.mcap", agent, {"seed": 0})
    recorder.start()
    agent.start("curious")
    for _ in range(9):
        agent.tick()
    agent.robot.look(8, 6, color=True)
    recorder.close()
    ticks = read_recording(tmp_path / "run.mcap").ticks
    assert [tick.percept.readings for tick in ticks] == [given.readings for given in percepts]
    assert np.array_equal(ticks[-1].images[0], picture)
    replay = ReplayWorld(read_recording(tmp_path / "run.mcap")).robot
    replay.ticks = 8
    assert np.array_equal(replay.look(8, 6, color=True), picture)
    assert replayed(tmp_path / "run.mcap", Ranging()).ticks == 8  # the image came after the last tick


class Changed(Curious):
    """Is a little different from its thirteenth tick on."""

    how = "command"

    def on(self, percept: RobotPercept, context: Context) -> Proposal | None:
        proposal = super().on(percept, context)
        if percept.tick < 13 or proposal is None:
            return proposal
        if self.how == "command":
            left = np.nextafter(proposal.command.left, np.inf)
            return Proposal(WheelCommand(float(left), proposal.command.right), 0.5, "curious")
        if self.how == "event":
            context.publish(PluginEvent(time=context.time, name="more"))
        if self.how == "look" and percept.tick % 5:
            context.look()
        return None if self.how == "silence" else proposal


@pytest.mark.parametrize(
    ("how", "what"),
    [("command", "proposals"), ("event", "event"), ("look", "proposals"), ("silence", "proposals")],
)
def test_the_first_difference_is_found_where_it_is(tmp_path: Path, how: str, what: str) -> None:
    record(tmp_path / "run.mcap")
    changed = Changed()
    changed.how = how
    difference = replayed(tmp_path / "run.mcap", changed).difference
    assert difference is not None
    assert (difference.tick, difference.what) == (13, what)
    assert "tick 13 (0.416 s)" in difference.text()


def test_recorded_percepts_play_in_a_scripted_robot(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap", ticks=3)
    robot = ScriptedRobot(read_percepts(tmp_path / "run.mcap"))
    first = robot.sense()
    robot.act(STOP)
    assert robot.sense().infrared != first.infrared


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        record(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("damage", [lambda data: data[:60], lambda data: b"rubbish", lambda data: b""])
def test_a_damaged_recording_is_refused_by_name(tmp_path: Path, damage: object) -> None:
    path = tmp_path / "run.mcap"
    record(path)
    path.write_bytes(damage(path.read_bytes()))  # type: ignore[operator]
    with pytest.raises(RecordingError, match=r"run\.mcap"):
        read_recording(path)


def test_a_flipped_bit_anywhere_in_what_a_recording_holds_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path)
    data = path.read_bytes()
    for place in range(8, data.index(b"\x0f", len(data) // 2), 97):
        flipped = bytearray(data)
        flipped[place] ^= 0x10
        path.write_bytes(bytes(flipped))
        with contextlib.suppress(RecordingError):
            assert not read_recording(path).complete, place


def test_a_recording_that_is_cut_off_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, ticks=1500)
    data, whole = path.read_bytes(), read_recording(path)
    assert whole.complete
    assert len(whole.ticks) == 1500
    path.write_bytes(data[: len(data) // 2])
    half = read_recording(path)
    assert not half.complete
    assert 100 < len(half.ticks) < 1400
    assert [tick.events for tick in half.ticks[:-1]] == [
        tick.events for tick in whole.ticks[: len(half.ticks) - 1]
    ]
    assert list(timeline(half))[-1] == "the recording is cut off here"
    assert replayed(path, Curious()).difference is None


class Full(io.FileIO):
    """A disk that takes 100,000 bytes."""

    left = 100_000

    def write(self, data: Any) -> int:
        self.left -= len(data)
        if self.left < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(data)


def test_a_full_disk_ends_the_recording_and_not_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "run.mcap"
    monkeypatch.setattr(
        "tolman.agent.recording.recorder.open_growing",
        lambda path, replace: io.BufferedWriter(Full(path, "wb")),
    )
    recorder = record(path, ticks=1500)
    said = f"{path}: recording ended: No space left on device"
    assert recorder.outcome == Outcome(False, reason=said)
    assert caplog.messages == [f"{said}; the run goes on without it"]
    half = read_recording(path)
    assert not half.complete
    assert 0 < len(half.ticks) < 1500
