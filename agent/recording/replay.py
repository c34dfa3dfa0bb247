"""Re-runs an agent on recorded percepts and images, and finds the first difference.

The replay takes the place of the world: whatever ran the recorded session runs again on `ReplayWorld`, and
is compared tick by tick, to the bit, as it goes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from ...files.messages import printable
from ...world.robot import CONTROL_PERIOD, EPUCK, EPUCK2, Image, Percept, Pose, RobotGeometry, WheelCommand
from ..codec import dumps
from ..errors import RecordingError
from ..events import Event
from .reader import RecordedTick, Recording
from .recorder import described_proposals

if TYPE_CHECKING:
    from ..agent import Agent

_GEOMETRIES = {geometry.name: geometry for geometry in (EPUCK, EPUCK2)}


@dataclass(frozen=True, slots=True)
class Difference:
    """Where a replay first parts from its recording. what: images, proposals, driver, command or event."""

    tick: int
    time: float
    what: str
    recorded: str
    replayed: str

    def text(self) -> str:
        """One line."""
        return (
            f"tick {self.tick} ({self.time:.3f} s), {self.what}: recorded {self.recorded}, "
            f"replayed {self.replayed}"
        )


class ReplayEnded(Exception):  # noqa: N818  no error: the end of a replay, early or not
    """The replay is over: at the end of the recording, or at the first difference."""


class ReplayRobot:
    """A robot that senses and sees what was recorded, and compares what it is told to do.

    difference: the first one found, None as long as there is none. ticks: how many were the same.
    """

    def __init__(self, recording: Recording, index: int = 0) -> None:
        """index: which of the recorded robots.

        Raises: RecordingError for a robot whose geometry is not known here, or an empty recording.
        """
        name = str(recording.header.get("geometry", EPUCK.name))
        if name not in _GEOMETRIES:
            raise RecordingError(f"the recorded robot is a {name!r}; known: {', '.join(_GEOMETRIES)}")
        if not recording.ticks:
            raise RecordingError("the recording has no ticks")
        self.geometry: RobotGeometry = _GEOMETRIES[name]
        self._ticks = recording.ticks if index == 0 else recording.others[index - 1]
        self._acted = False
        self._agent: Agent | None = None
        self._events: list[str] = []
        self._looks = 0
        self.ticks = 0
        self.difference: Difference | None = None

    def watch(self, agent: Agent) -> None:
        """Compares this agent from now on; called once, before its first tick."""
        self._agent = agent
        agent.bus.subscribe(Event, lambda event: self._events.append(dumps(event)))

    @property
    def recorded(self) -> RecordedTick:
        """What was kept of the tick that is replayed now."""
        return self._ticks[min(self.ticks, len(self._ticks) - 1)]

    def sense(self) -> Percept:
        """The recorded percept. Raises: ReplayEnded when there is no more."""
        if self.ticks >= len(self._ticks) or self.recorded.command is None:
            raise ReplayEnded
        return self.recorded.percept

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """The next recorded image of this tick. Raises: RecordingError if none of that size was taken."""
        images, shape = self.recorded.images, (height, width, 3) if color else (height, width)
        if self._looks >= len(images) or images[self._looks].shape != shape:
            raise RecordingError(f"no {width} x {height} image was recorded at this point")
        self._looks += 1
        return images[self._looks - 1]

    def act(self, command: WheelCommand) -> None:
        """Compares everything but the events. Raises: ReplayEnded at a difference."""
        then = self.recorded
        agent = self._agent
        if agent is None:
            raise RecordingError("nobody watches the replayed agent: call watch(agent)")
        self._acted = True
        self._compare("images taken", len(then.images), self._looks)
        self._compare("proposals", then.proposals, described_proposals(agent))
        self._compare("driver", then.driver, agent.driver)
        self._compare("command", then.command, command)

    def step(self) -> None:
        """Compares the tick's events and goes on to the next tick, if anything was done in this one.

        Raises: ReplayEnded at a difference.
        """
        if not self._acted:
            return  # a session that was resumed lets its world step before the first tick
        then, now = self.recorded.events, self._events
        for index in range(max(len(then), len(now))):
            self._compare("event", _item(then, index), _item(now, index))
        now.clear()
        self._acted = False
        self._looks = 0
        self.ticks += 1

    def _compare(self, what: str, then: Any, now: Any) -> None:
        if then != now:
            percept = self.recorded.percept
            self.difference = Difference(percept.tick, percept.time, what, _short(then), _short(now))
            raise ReplayEnded


class ReplayWorld:
    """Stands in for the world a session ran in: time passes, and the true pose is the recorded one."""

    def __init__(self, recording: Recording, spec: Any = None) -> None:
        """spec: of the recorded world, for a session that asks for it."""
        count = 1 + len(recording.others)
        self.robots: Sequence[ReplayRobot] = tuple(ReplayRobot(recording, index) for index in range(count))
        self.robot = self.robots[0]
        self.spec = spec
        self.seed = int(recording.header.get("seed", 0))

    @property
    def difference(self) -> Difference | None:
        """The first one found on any of the robots."""
        return next((robot.difference for robot in self.robots if robot.difference is not None), None)

    @property
    def time(self) -> float:
        """Simulated seconds, as recorded."""
        return self.robot.recorded.percept.tick * CONTROL_PERIOD

    def step(self) -> None:
        """One tick of the recording."""
        for robot in self.robots:
            robot.step()

    def true_pose(self, robot: int = 0) -> Pose:
        """Where the robot truly was."""
        return self.robots[robot].recorded.truth or Pose()

    def collisions(self, robot: int = 0) -> int:
        """Not recorded."""
        return 0

    def place(self, pose: Pose, robot: int = 0) -> None:
        """Nobody is there to be put anywhere: the percepts tell where it was."""

    def state(self) -> Mapping[str, Any]:
        """Nothing of the world is here."""
        return {}

    def restore(self, state: Mapping[str, Any]) -> None:
        """What a resumed session goes back to is in the percepts."""

    def close(self) -> None:
        """Nothing to free."""

    def __enter__(self) -> Self:
        """The world itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes it."""
        self.close()


def _item(events: Sequence[str], index: int) -> str:
    return events[index] if index < len(events) else "nothing"


def _short(value: Any) -> str:
    text = printable(str(value))
    return text if len(text) <= 200 else text[:200] + "..."
