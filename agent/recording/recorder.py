"""Keeps a run in an MCAP file: percepts, images, proposals, commands, events, truth.

Topics: /percept, /image, /proposals, /command, /event, /truth, /agent, one JSON object a message, stamped
with the simulated time; the run's header is the metadata record `tolman`. docs/recordings.md describes
the fields.
"""

from __future__ import annotations

import base64
import json
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from ...files.messages import printable
from ...files.writing import open_growing
from ...world.robot import CONTROL_PERIOD, Image, Percept, Pose, Robot, RobotGeometry, WheelCommand
from ..codec import dumps
from ..events import Event
from ..listener import Listener
from .reader import VERSION

if TYPE_CHECKING:
    from mcap.writer import Writer

    from ..agent import Agent

_CHUNK = 1 << 18
"""Bytes that are packed together: as much may be missing where a run is cut off."""
_FIELDS: dict[str, dict[str, str]] = {
    "/percept": {
        "tick": "integer",
        "infrared": "array",
        "encoders": "array",
        "accelerometer": "array",
        "readings": "object",
    },
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
    "/agent": {"tick": "integer", "pose": "array", "states": "object", "belief": "object"},
}
_log = logging.getLogger(__name__)
Truth = Callable[[], Pose]


class RecordedRobot:
    """Stands between an agent and its robot and passes all on, to the recorder too."""

    def __init__(
        self,
        put: Callable[[str, str, float], None],
        agent: Agent,
        truth: Truth | None = None,
        prefix: str = "",
    ) -> None:
        """put: takes topic, text and simulated time (s). prefix: of the topics, for further robots."""
        self._put_text, self._agent, self._robot, self._truth = put, agent, agent.robot, truth
        self._prefix = prefix
        self.geometry: RobotGeometry = agent.robot.geometry
        self._tick = -1
        self._states: dict[str, str] = {}
        self._belief: dict[int, float] = {}
        agent.robot = self
        self._subscription = agent.bus.subscribe(Event, self._hear)

    def sense(self) -> Percept:
        """The robot's percept, kept once a tick."""
        percept = self._robot.sense()
        if percept.tick != self._tick:
            self._tick = percept.tick
            values = {each.name: _numbers(getattr(percept, each.name)) for each in fields(percept)}
            self._put("/percept", {name: value for name, value in values.items() if value != {}})
        return percept

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """The robot's image, kept."""
        image = self._robot.look(width, height, color)
        encoding = "32FC3" if color else "32FC1"
        data = base64.b64encode(np.ascontiguousarray(image, dtype="<f4").tobytes()).decode()
        self._put("/image", {"width": width, "height": height, "encoding": encoding, "data": data})
        return image

    def act(self, command: WheelCommand) -> None:
        """Passes the command on; keeps it, who drives, what was proposed, and where the robot truly is."""
        self._robot.act(command)
        self._put("/proposals", {"proposals": described_proposals(self._agent)})
        left, right = float(command.left), float(command.right)
        self._put("/command", {"left": left, "right": right, "driver": self._agent.driver})
        if self._truth is not None:
            pose = self._truth()
            self._put("/truth", {"x": pose.x, "y": pose.y, "heading": pose.heading})
        self._put("/agent", self._inside())

    def _inside(self) -> dict[str, Any]:
        """Where the agent believes to be; states of behaviors and belief over nodes if they have changed."""
        pose = self._agent.odometry.pose
        inside: dict[str, Any] = {"pose": [round(pose.x, 5), round(pose.y, 5), round(pose.heading, 5)]}
        states, belief = self._agent.states(), self._agent.belief()
        if states != self._states:
            inside["states"] = self._states = states
        if belief != self._belief:
            self._belief = belief
            inside["belief"] = {str(node): round(weight, 4) for node, weight in belief.items()}
        return inside

    def release(self) -> None:
        """Keeps no more; the agent gets its robot back."""
        self._subscription.cancel()
        self._agent.robot = self._robot

    def _hear(self, event: Event) -> None:
        self._put_text(f"{self._prefix}/event", f'{{"event":{dumps(event)},"tick":{self._tick}}}', self._time)

    def _put(self, topic: str, value: Mapping[str, Any]) -> None:
        text = json.dumps({"tick": self._tick, **value}, separators=(",", ":"))
        self._put_text(self._prefix + topic, text, self._time)

    @property
    def _time(self) -> float:
        return max(self._tick, 0) * CONTROL_PERIOD


class Recorder(Listener):
    """Keeps what passes between agents and their robots in a file, from `start` to `close`: a tick listener.

    Start it with a new agent, before anything else is started: what was published before is not in it. A disk
    that takes no more ends the recording and nothing else: `outcome` says so, and a line in the log.
    """

    def __init__(
        self,
        path: Path,
        agent: Agent,
        header: Mapping[str, Any],
        truth: Truth | None = None,
        attachments: Mapping[str, bytes] | None = None,
        others: Sequence[tuple[Agent, Truth | None]] = (),
    ) -> None:
        """header: JSON values that say how the run is made again. truth: the robot's true pose, for `/truth`.

        attachments: files the run began with, by name, such as the map of a trip. others: further robots of
        the same world, with their truth; what passes there is under `/robot1`, `/robot2`, ...
        """
        super().__init__(agent)
        self._path = path
        self._agents = [(agent, truth), *others]
        self._header, self._attachments = header, attachments or {}
        self._robots: list[RecordedRobot] = []
        self._counts: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._file: BinaryIO | None = None
        self._flushed = 0

    def start(self) -> None:
        """Opens the file and begins. Raises: FileError where no file can be written."""
        from mcap.writer import CompressionType, Writer

        self._file = open_growing(self._path, replace=True)
        self._writer: Writer = Writer(
            self._file, _CHUNK, compression=CompressionType.ZSTD, enable_data_crcs=True
        )
        self._try(self._begin)
        for index, (agent, truth) in enumerate(self._agents):
            self._robots.append(RecordedRobot(self._put, agent, truth, f"/robot{index}" if index else ""))

    def stop(self, reason: str = "cancelled") -> None:
        """Completes the file."""
        if self.outcome is None and self._file is not None:
            self.finish(True, self._path, reason)

    def finish(self, succeeded: bool, result: Any = None, reason: str = "") -> None:
        """Writes the index and closes the file; the agents get their robots back."""
        for robot in self._robots:
            robot.release()
        super().finish(succeeded, result, reason)
        file, self._file = self._file, None
        if file is not None:
            if succeeded:
                self._try(self._writer.finish)
            self._try(file.close)

    def close(self) -> None:
        """Completes the file. Twice does no harm."""
        self.stop("")
        super().close()

    def _begin(self) -> None:
        writer = self._writer
        writer.start(profile="tolman", library="tolman")
        header = {"version": str(VERSION), "header": json.dumps(self._header, sort_keys=True)}
        writer.add_metadata("tolman", header)
        for name, content in self._attachments.items():
            writer.add_attachment(0, 0, name, "application/octet-stream", content)
        for index in range(len(self._agents)):
            for topic, kinds in _FIELDS.items():
                self._register(f"/robot{index}{topic}" if index else topic, topic, kinds)

    def _register(self, name: str, topic: str, kinds: Mapping[str, str]) -> None:
        properties = {each: {"type": kind} for each, kind in kinds.items()}
        schema = json.dumps({"type": "object", "properties": properties}).encode()
        number = self._writer.register_schema(f"tolman{topic.replace('/', '.')}", "jsonschema", schema)
        self._channels[name] = self._writer.register_channel(name, "json", number)

    def _put(self, topic: str, text: str, time: float) -> None:
        if self._file is None:
            return
        now = round(time * 1e9)
        count = self._counts[topic] = self._counts.get(topic, 0) + 1
        self._try(lambda: self._writer.add_message(self._channels[topic], now, text.encode(), now, count))

    def _try(self, write: Callable[[], None]) -> None:
        """Writes and hands over to the system what a run that is cut off must not lose."""
        try:
            write()
            if self._file is not None and self._file.tell() != self._flushed:
                self._file.flush()
                self._flushed = self._file.tell()
        except OSError as fault:
            if self.outcome is None or self.outcome.succeeded:
                reason = f"{printable(str(self._path))}: recording ended: {fault.strerror or fault}"
                _log.error("%s; the run goes on without it", reason)
                self.finish(False, reason=reason)


def _numbers(value: Any) -> Any:
    """What a percept holds as JSON's own types: numbers, lists of them, such by name."""
    if isinstance(value, Mapping):
        return {str(name): _numbers(each) for name, each in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [_numbers(each) for each in value]
    return value.item() if isinstance(value, np.generic) else value


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


_: type[Robot] = RecordedRobot  # what keeps what a robot does is one
