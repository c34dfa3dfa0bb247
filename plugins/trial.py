"""The test kit for behaviors: percepts from words, a scripted robot, a trial without an agent, assertions.

Everything here works without a simulator: `percept(right=0.02)` is what the robot senses with a wall 2 cm on
the right; `Trial(behavior).step(...)` is one control tick of one behavior alone. The fixtures of the same
names come with the pytest plugin that is installed with tolman; docs/plugins-testing.md has an example each.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..agent.behavior import Behavior, Context, Proposal
from ..agent.estimation.odometry import PathIntegrator
from ..agent.events import Event, EventBus
from ..agent.perception.infrared import raw_value
from ..world.robot import CONTROL_PERIOD, EPUCK, STOP, Image, Percept, Pose, RobotGeometry, WheelCommand

FAR = math.inf
"""The distance of a wall that is not there."""


def percept(
    *,
    front: float = FAR,
    left: float = FAR,
    rear: float = FAR,
    right: float = FAR,
    tick: int = 0,
    encoders: tuple[float, float] = (0.0, 0.0),
    geometry: RobotGeometry = EPUCK,
) -> Percept:
    """What is sensed between long straight walls at these distances (m) from the rim, without noise."""
    gaps = (front, left, rear, right)
    values = tuple(
        raw_value(geometry, _ray(gaps, angle, geometry.body_radius)) for angle in geometry.infrared_angles
    )
    return Percept(tick=tick, time=tick * CONTROL_PERIOD, infrared=values, encoders=encoders)


def _ray(gaps: Sequence[float], angle: float, radius: float) -> float:
    """Distance (m) from the rim along `angle` (rad) to the nearest of the walls front, left, rear, right."""
    toward = (math.cos(angle), math.sin(angle), -math.cos(angle), -math.sin(angle))
    hits = [(radius + gap) / part - radius for gap, part in zip(gaps, toward, strict=True) if part > 1e-9]
    return min(hits, default=FAR)


class ScriptedRobot:
    """A robot that senses what a list says and keeps what it was commanded.

    After the last percept it goes on with that one, time running on. With `moves` the encoders follow the
    commands, as those of a robot that nothing stops; else they are the percepts' own.
    """

    def __init__(
        self,
        percepts: Iterable[Percept] = (),
        *,
        moves: bool = True,
        image: Image | None = None,
        geometry: RobotGeometry = EPUCK,
    ) -> None:
        """percepts: in order, one a tick; none: an empty plain. image: what `look` gives; None: grey."""
        self._percepts = list(percepts) or [percept(geometry=geometry)]
        self._geometry = geometry
        self._image = image
        self._moves = moves
        self._encoders = self._percepts[0].encoders
        self._tick = 0
        self.commands: list[WheelCommand] = []

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's sizes."""
        return self._geometry

    @property
    def exhausted(self) -> bool:
        """Whether every percept of the list was acted upon."""
        return self._tick >= len(self._percepts)

    def sense(self) -> Percept:
        """The percept of this tick; the same again until `act`."""
        given = self._percepts[min(self._tick, len(self._percepts) - 1)]
        encoders = self._encoders if self._moves else given.encoders
        return replace(given, tick=self._tick, time=self._tick * CONTROL_PERIOD, encoders=encoders)

    def act(self, command: WheelCommand) -> None:
        """Keeps the command, and with `moves` turns the wheels. Raises: ValueError if it is not finite."""
        if not command.is_finite():
            raise ValueError(f"a wheel command must be finite, not {command!r}")
        command = command.clamped(self._geometry.max_speed)
        self.commands.append(command)
        left, right = self._encoders
        self._encoders = (left + command.left * CONTROL_PERIOD, right + command.right * CONTROL_PERIOD)
        self._tick += 1

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """The image it was given, or plain grey. Raises: ValueError for another size than the image's."""
        shape = (height, width, 3) if color else (height, width)
        if self._image is None:
            return np.full(shape, 0.5, dtype=np.float32)
        if self._image.shape != shape:
            raise ValueError(
                f"asked for {width} x {height} pixels, the scripted image is {self._image.shape}"
            )
        return self._image


class Trial:
    """One behavior alone: no agent, no mediator, no physics. Keeps proposals, states and events.

    The robot is taken to do what was proposed last, so path integration runs as if nothing stopped it.
    """

    def __init__(
        self, behavior: Behavior, *, goal: Any = None, seed: int = 0, geometry: RobotGeometry = EPUCK
    ) -> None:
        """Starts the behavior with its goal, as the agent does."""
        self.behavior = behavior
        self.events: list[Event] = []
        self.proposals: list[Proposal | None] = []
        self.states: list[Any] = [type(behavior).initial]
        self._odometry = PathIntegrator(geometry)
        self._encoders = (0.0, 0.0)
        self._tick = 0
        self.bus = EventBus()
        self.bus.subscribe(Event, self.events.append)
        self.context = Context(
            geometry=geometry,
            publish=self.bus.publish,
            look=_grey,
            rng=np.random.default_rng(seed),
            subscribe=self.bus.subscribe,
        )
        behavior.start(goal, self.context)
        if behavior.state is not self.states[-1]:
            self.states.append(behavior.state)

    @property
    def pose(self) -> Pose:
        """Where the robot is by path integration."""
        return self._odometry.pose

    def step(self, sensed: Percept | None = None) -> Proposal | None:
        """One tick with what this percept has of the robot's surroundings (None: an empty plain)."""
        sensed = sensed if sensed is not None else percept(geometry=self.context.geometry)
        now = self._tick * CONTROL_PERIOD
        sensed = replace(sensed, tick=self._tick, time=now, encoders=self._encoders)
        self._odometry.update(self._encoders)
        context = self.context
        context.time, context.pose = now, self._odometry.pose
        context.distance, context.turn = self._odometry.distance, self._odometry.turn
        proposal = None if self.behavior.finished else self.behavior.propose(sensed, context)
        context.in_control = proposal is not None
        self._drive(proposal.command if proposal is not None else STOP)
        self.proposals.append(proposal)
        if self.behavior.state is not self.states[-1]:
            self.states.append(self.behavior.state)
        self.bus.deliver()
        self._tick += 1
        return proposal

    def run(self, sensed: Percept | Iterable[Percept] | None = None, ticks: int = 1) -> Proposal | None:
        """The same percept for some ticks, or each of several in turn; returns the last proposal."""
        steps = [sensed] * ticks if sensed is None or isinstance(sensed, Percept) else list(sensed)
        proposal = None
        for each in steps:
            proposal = self.step(each)
        return proposal

    def _drive(self, command: WheelCommand) -> None:
        command = command.clamped(self.context.geometry.max_speed)
        left, right = self._encoders
        self._encoders = (left + command.left * CONTROL_PERIOD, right + command.right * CONTROL_PERIOD)


def _grey() -> Image:
    return np.full((16, 16), 0.5, dtype=np.float32)
