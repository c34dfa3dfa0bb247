"""Keeps a run in an MCAP file, and reads it back: percepts, images, proposals, commands, events, truth.

Topics: /percept, /image, /proposals, /command, /event, /truth, one JSON object a message, stamped with the
simulated time; the run's header is the metadata record `tolman`. docs/recordings.md describes the fields.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...world.robot import CONTROL_PERIOD, Image, Percept, Pose, Robot, RobotGeometry, WheelCommand
from ..agent import Agent
from ..errors import RecordingError
from ..events import Event
from .codec import dumps

if TYPE_CHECKING:
    from mcap.writer import Writer

VERSION = 1
_FIELDS: dict[str, dict[str, str]] = {
    "/percept": {"tick": "integer", "infrared": "array", "encoders": "array", "accelerometer": "array"},
    "/image": {
        "tick": "integer",
        "width": "integer",
        "height": "integer",
        "encoding": "string",
        "data": "string",
    },
    "/proposals": {"tick": "integer", "proposals": "array"},
    "/command": {"tick": "integer", "left": "number", "right": "number", "driver": "string"},
    "/event": {"tick": "integer", "event": "object"},
    "/truth": {"tick": "integer", "x": "number", "y": "number", "heading": "number"},
}


class RecordedRobot:
    """Stands between an agent and its robot and keeps what passes."""

    def __init__(
        self, writer: Writer, agent: Agent, truth: Callable[[], Pose] | None = None, prefix: str = ""
    ) -> None:
        """prefix: before the topics of all robots but the first."""
        self._writer, self._agent, self._robot, self._truth = writer, agent, agent.robot, truth
        self._channels = {topic: self._register(topic, fields, prefix) for topic, fields in _FIELDS.items()}
        self._counts = dict.fromkeys(_FIELDS, 0)
        self._tick = -1
        agent.robot = self
        self._subscription = agent.bus.subscribe(Event, self._hear)

    # --- Robot -----------------------------------------------------------------------------------------

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's."""
        return self._robot.geometry

    def sense(self) -> Percept:
        """The robot's percept, kept once a tick."""
        percept = self._robot.sense()
        if percept.tick != self._tick:
            self._tick = percept.tick
            self._put(
                "/percept",
                {
                    "tick": percept.tick,
                    "time": percept.time,
                    "infrared": [float(value) for value in percept.infrared],
                    "encoders": [float(value) for value in percept.encoders],
                    "accelerometer": [float(value) for value in percept.accelerometer],
                },
            )
        return percept

    def look(self, width: int = 16, height: int = 16) -> Image:
        """The robot's image, kept."""
        image = self._robot.look(width, height)
        data = base64.b64encode(np.ascontiguousarray(image, dtype="<f4").tobytes()).decode()
        self._put(
            "/image",
            {"tick": self._tick, "width": width, "height": height, "encoding": "32FC1", "data": data},
        )
        return image

    def act(self, command: WheelCommand) -> None:
        """Passes the command on; keeps it, who drives, what was proposed, and where the robot truly is."""
        self._robot.act(command)
        agent = self._agent
        self._put("/proposals", {"tick": self._tick, "proposals": described_proposals(agent)})
        self._put(
            "/command",
            {
                "tick": self._tick,
                "left": float(command.left),
                "right": float(command.right),
                "driver": agent.driver,
            },
        )
        if self._truth is not None:
            pose = self._truth()
            self._put("/truth", {"tick": self._tick, "x": pose.x, "y": pose.y, "heading": pose.heading})

    # --- the file --------------------------------------------------------------------------------------

    def release(self) -> None:
        """Keeps no more; the agent gets its robot back."""
        self._subscription.cancel()
        self._agent.robot = self._robot

    def _hear(self, event: Event) -> None:
        self._put_text("/event", f'{{"event":{dumps(event)},"tick":{self._tick}}}')

    def _put(self, topic: str, value: Mapping[str, Any]) -> None:
        self._put_text(topic, json.dumps(value, separators=(",", ":")))

    def _put_text(self, topic: str, text: str) -> None:
        now = round(max(self._tick, 0) * CONTROL_PERIOD * 1e9)
        count = self._counts[topic] = self._counts[topic] + 1
        self._writer.add_message(self._channels[topic], now, text.encode(), now, count)

    def _register(self, topic: str, fields: Mapping[str, str], prefix: str) -> int:
        properties = {name: {"type": kind} for name, kind in fields.items()}
        schema = json.dumps({"type": "object", "properties": properties}).encode()
        schema_id = self._writer.register_schema(f"tolman{topic.replace('/', '.')}", "jsonschema", schema)
        return self._writer.register_channel(prefix + topic, "json", schema_id)


class Recorder:
    """Keeps what passes between agents and their robots in a file. `close` completes it.

    Attach it to a new agent, before anything is started: what was published before is not in it.
    """

    def __init__(
        self,
        path: Path,
        agent: Agent,
        header: Mapping[str, Any],
        truth: Callable[[], Pose] | None = None,
        attachments: Mapping[str, bytes] | None = None,
        others: Sequence[tuple[Agent, Callable[[], Pose] | None]] = (),
    ) -> None:
        """header: JSON values that say how the run is made again. truth: the robot's true pose, for `/truth`.

        attachments: files the run began with, by name, such as the map of a trip. others: further robots of
        the same world, with their truth; what passes there is under `/robot1`, `/robot2`, ...
        """
        from mcap.writer import CompressionType, Writer

        self._file = path.open("wb")
        self._writer = writer = Writer(self._file, compression=CompressionType.ZSTD)
        writer.start(profile="tolman", library="tolman")
        self._robots = [RecordedRobot(writer, agent, truth)]
        for name, content in (attachments or {}).items():
            writer.add_attachment(0, 0, name, "application/octet-stream", content)
        writer.add_metadata("tolman", {"version": str(VERSION), "header": json.dumps(header, sort_keys=True)})
        for index, (other, its_truth) in enumerate(others, start=1):
            self._robots.append(RecordedRobot(writer, other, its_truth, f"/robot{index}"))
        self._closed = False

    def close(self) -> None:
        """Writes the index and closes the file; the agents get their robots back. Twice does no harm."""
        if not self._closed:
            self._closed = True
            for robot in self._robots:
                robot.release()
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()


def described_proposals(agent: Agent) -> list[list[Any]]:
    """The last tick's proposals as JSON: name, priority, left, right, activation, reason."""
    return [
        [
            name,
            priority,
            float(proposal.command.left),
            float(proposal.command.right),
            float(proposal.activation),
            proposal.reason,
        ]
        for name, priority, proposal in agent.proposals
    ]


@dataclass(slots=True)
class RecordedTick:
    """All that was kept of one tick, as it stands in the file."""

    percept: Percept
    images: list[Image] = field(default_factory=list)
    proposals: list[Any] = field(default_factory=list)
    command: WheelCommand | None = None
    driver: str | None = None
    events: list[str] = field(default_factory=list)
    truth: Pose | None = None


@dataclass(frozen=True, slots=True)
class Recording:
    """A recorded run. early: events from before the first tick, as text.

    ticks: of the first robot; others: of the world's further ones, in order.
    """

    header: Mapping[str, Any]
    ticks: list[RecordedTick]
    attachments: Mapping[str, bytes]
    early: list[str]
    others: tuple[list[RecordedTick], ...] = ()


def read_recording(path: Path) -> Recording:
    """Reads a whole recording. Raises: RecordingError if it is none or damaged."""
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such recording")
    try:
        return _read(path)
    except RecordingError:
        raise
    except Exception as fault:  # the library raises whatever a damaged file leads it to
        raise RecordingError(f"{path}: not a whole recording ({type(fault).__name__}: {fault})") from fault


def read_percepts(path: Path) -> list[Percept]:
    """The percepts of a recording, in order: what a scripted robot plays. Raises: RecordingError."""
    return [tick.percept for tick in read_recording(path).ticks]


def _read(path: Path) -> Recording:
    from mcap.reader import make_reader

    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        header = _header(path, {record.name: record.metadata for record in reader.iter_metadata()})
        attachments = {record.name: record.data for record in reader.iter_attachments()}
        ticks: list[RecordedTick] = []
        early: list[str] = []
        others: dict[int, list[RecordedTick]] = {}
        for topic, text in _messages(reader):
            if topic.startswith("/robot"):
                index, _, rest = topic.removeprefix("/robot").partition("/")
                _take(others.setdefault(int(index), []), f"/{rest}", json.loads(text))
                continue
            value = json.loads(text)
            if not ticks and topic != "/percept":
                early.append(text)
            else:
                _take(ticks, topic, value)
        return Recording(header, ticks, attachments, early, tuple(others[index] for index in sorted(others)))


def _take(ticks: list[RecordedTick], topic: str, value: Mapping[str, Any]) -> None:
    """Adds a message to the ticks of its robot."""
    if topic == "/percept":
        ticks.append(RecordedTick(_percept(value)))
    elif ticks:
        _fill(ticks[-1], topic, value)


def _messages(reader: Any) -> Iterator[tuple[str, str]]:
    for _, channel, message in reader.iter_messages(log_time_order=False):
        yield channel.topic, message.data.decode()


def _header(path: Path, metadata: Mapping[str, Mapping[str, str]]) -> Mapping[str, Any]:
    if "tolman" not in metadata:
        raise RecordingError(f"{path}: an MCAP file, but not a recording of tolman")
    record = metadata["tolman"]
    if record.get("version") != str(VERSION):
        raise RecordingError(
            f"{path}: a recording of version {record.get('version')}; this tolman reads {VERSION}"
        )
    header: Mapping[str, Any] = json.loads(record["header"])
    return header


def _percept(value: Mapping[str, Any]) -> Percept:
    left, right = value["encoders"]
    x, y, z = value["accelerometer"]
    return Percept(value["tick"], value["time"], tuple(value["infrared"]), (left, right), (x, y, z))


def _fill(tick: RecordedTick, topic: str, value: Mapping[str, Any]) -> None:
    if topic == "/image":
        pixels = np.frombuffer(base64.b64decode(value["data"]), dtype="<f4")
        tick.images.append(pixels.reshape(value["height"], value["width"]).astype(np.float32))
    elif topic == "/proposals":
        tick.proposals = value["proposals"]
    elif topic == "/command":
        tick.command = WheelCommand(value["left"], value["right"])
        tick.driver = value["driver"]
    elif topic == "/event":
        tick.events.append(json.dumps(value["event"], separators=(",", ":"), sort_keys=True))
    elif topic == "/truth":
        tick.truth = Pose(value["x"], value["y"], value["heading"])


_: type[Robot] = RecordedRobot  # what keeps what a robot does is one
