from __future__ import annotations

import contextlib
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent import Agent, Behavior, Context, Proposal, Transition
from tolman.agent.errors import CodecError, RecordingError
from tolman.agent.events import Event, PluginEvent
from tolman.agent.goals import Follow, FollowFrom
from tolman.agent.recording.codec import dumps, loads
from tolman.agent.recording.recorder import Recorder, read_percepts, read_recording
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

    def propose(self, percept: RobotPercept, context: Context) -> Proposal | None:
        if percept.tick % 5 == 0:
            brightness = float(context.look().mean())
            context.publish(PluginEvent(time=context.time, name="seen", data={"brightness": brightness}))
        speed = self.gain * float(context.rng.normal(200.0, 50.0)) + 0.01 * percept.infrared[2]
        return Proposal(WheelCommand(speed, -speed), 0.5, "curious")


def record(path: Path, ticks: int = 40, truth: bool = True) -> None:
    rng = np.random.default_rng(5)
    percepts = [percept(right=float(rng.uniform(0.0, 0.07)), tick=tick) for tick in range(ticks)]
    robot = ScriptedRobot(percepts, image=rng.random((16, 16), dtype=np.float32))
    agent = Agent(robot, [Curious()])
    poses = (lambda: Pose(len(robot.commands) * 0.1, 1.0 / 3.0, -0.5)) if truth else None
    recorder = Recorder(path, agent, {"seed": 0, "note": "ä"}, poses, {"map": b"\x00\x01"})
    agent.start("curious")
    for _ in range(ticks):
        agent.tick()
    recorder.close()
    recorder.close()


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


def test_a_replay_of_the_same_agent_is_identical_to_the_bit(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap")
    robot = replayed(tmp_path / "run.mcap", Curious())
    assert robot.difference is None
    assert robot.ticks == 40


class Changed(Curious):
    """Is a little different from its thirteenth tick on."""

    how = "command"

    def propose(self, percept: RobotPercept, context: Context) -> Proposal | None:
        proposal = super().propose(percept, context)
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


@pytest.mark.parametrize("damage", [lambda data: data[:-200], lambda data: b"rubbish", lambda data: b""])
def test_a_damaged_recording_is_refused_by_name(tmp_path: Path, damage: object) -> None:
    path = tmp_path / "run.mcap"
    record(path)
    path.write_bytes(damage(path.read_bytes()))  # type: ignore[operator]
    with pytest.raises(RecordingError, match=r"run\.mcap"):
        read_recording(path)


def test_a_flipped_bit_in_a_recording_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 0x10
    path.write_bytes(bytes(data))
    with pytest.raises(RecordingError):
        read_recording(path)


def test_a_missing_recording_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no such recording"):
        read_recording(tmp_path / "none")


values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**60), 2**60), st.floats(), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.tuples(inner, inner),
        st.dictionaries(st.text("abc", min_size=1, max_size=3), inner, max_size=3),
    ),
    max_leaves=8,
)


@given(values)
def test_any_plain_value_survives_the_codec(value: object) -> None:
    again = loads(dumps(value))
    assert type(again) is type(value)
    assert dumps(again) == dumps(value)


def test_events_and_goals_survive_the_codec() -> None:
    event: Event = PluginEvent(time=0.1, name="x", data={"goal": Follow("left", FollowFrom.CONCAVE)})
    assert loads(dumps(event)) == event
    array = np.arange(6, dtype=np.float32).reshape(2, 3)
    assert np.array_equal(loads(dumps(array)), array)


@pytest.mark.parametrize("text", ["{", '{"$":"Pose","z":1}', "[" * 10_000])
def test_text_that_is_no_value_is_refused(text: str) -> None:
    with pytest.raises(CodecError):
        loads(text)


def test_a_class_the_codec_does_not_know_stays_a_dict() -> None:
    assert loads('{"$":"os.system","command":"ls"}') == {"$": "os.system", "command": "ls"}
