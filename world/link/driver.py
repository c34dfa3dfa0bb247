"""Drives what speaks the e-puck2's protocol as a `Robot` in a `World`: an agent need not know of it.

A tick waits for the newest sensors. Step counters are told as they will be once the commands under way have
come (see `prediction`), so that turns end where they should. When no sensors come, the wheels stop.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..errors import PlacementError, WorldError
from ..robot import CONTROL_PERIOD, STOP, Image, Percept, Pose, Robot, RobotGeometry, WheelCommand
from ..spec import WorldSpec
from . import packets, units
from .channel import Channel, LinkError
from .packets import Command, wrapped
from .prediction import Predictor

if TYPE_CHECKING:
    from ..base import World
    from .calibration import Calibration

QUIET = 0.3
"""Seconds without sensors after which the wheels are told to stop."""
REPEATED = 0.1
"""Seconds between two commands to stop."""
LOST_AFTER = 30.0
"""Seconds without sensors, or an image that was asked for, after which a run is given up."""
FASTEST = 1300.0
"""Steps/s beyond which a counter has not counted but begun anew, as after power was off."""
EARLY = 0.004
"""Seconds by which a tick may come early: packets come every 21 ms or so, ticks are 32."""
_LUMA = np.array((0.2126, 0.7152, 0.0722))


class LinkedRobot:
    """Implements `robot.Robot` over a channel."""

    def __init__(
        self, channel: Channel, geometry: RobotGeometry, infrared: Calibration | None = None
    ) -> None:
        """infrared: gains and offsets of this specimen's sensors, which its readings are freed of."""
        self.channel = channel
        self.predictor = Predictor()
        self._geometry, self._calibration = geometry, infrared
        self._command, self._carry = STOP, (0.0, 0.0)
        self._counts: tuple[int, int] | None = None
        self._total = (0.0, 0.0)
        self._number = channel.heard.number
        self._time = self._counted_at = self._began = channel.now()
        self._percept = Percept(0, 0.0, (0.0,) * 8, (0.0, 0.0))
        self.stalls = 0

    @property
    def geometry(self) -> RobotGeometry:
        """The robot's sizes, as its maker publishes them, or as they were calibrated."""
        return self._geometry

    def sense(self) -> Percept:
        """This tick's percept."""
        return self._percept

    def act(self, command: WheelCommand) -> None:
        """Sets the wheel speeds that are sent with the next step. Raises: ValueError unless finite."""
        if not command.is_finite():
            raise ValueError(
                f"wheel speeds must be finite, not {command.left!r} and {command.right!r} steps/s"
            )
        self._command = command.clamped(self._geometry.max_speed)

    def look(self, width: int = 16, height: int = 16, color: bool = False) -> Image:
        """Stands still, asks for an image and waits for it: (height, width) or (height, width, 3), in [0, 1].

        Of the camera's picture the middle is taken in the form that is asked for. Raises: LinkError.
        """
        if not (1 <= width <= 640 and 1 <= height <= 480):
            raise WorldError(f"an image of {width}x{height} is outside 1x1..640x480")
        before, number = self.channel.heard.pictures, self.channel.heard.number
        self._send(STOP, packets.IMAGES | packets.SENSORS)
        end = self.channel.now() + LOST_AFTER
        while (heard := self.channel.heard).pictures == before or heard.number == number:
            if self.channel.now() > end:
                raise LinkError(f"{self.channel.name}: no image within {LOST_AFTER:g} s")
            self.channel.wait(self.channel.now() + REPEATED, heard)
        self._count()
        image = self.channel.heard.image
        assert image is not None
        return resized(image.astype(np.float32) / np.float32(255.0), width, height, color)

    def step(self) -> None:
        """Sends the wheels' speeds and waits for the sensors of the next tick. Raises: LinkError."""
        self._send(self._command)
        channel = self.channel
        due = 0.0 if channel.in_step else self._time + CONTROL_PERIOD - EARLY
        began = told = channel.now()
        while (heard := channel.heard).number == self._number or channel.now() < due:
            channel.wait(max(due, channel.now() + CONTROL_PERIOD), heard)
            if channel.in_step:
                continue
            quiet = channel.now() - max(began, channel.heard.time)
            if quiet > LOST_AFTER:
                raise LinkError(f"{channel.name}: no sensors for {LOST_AFTER:g} s")
            if quiet > QUIET and channel.now() - told > REPEATED:
                told = channel.now()
                self.stalls += self._command != STOP
                self._command = STOP
                self._send(STOP)
        self._count()
        self._perceive()

    def settle(self) -> None:
        """Ends driving: three commands to stop, until two counts are the same; then no more packets."""
        for _ in range(3):
            self._command = STOP
            self.step()
        for _ in range(100):
            counts = self._counts
            self.step()
            if counts == self._counts:
                break
        self.channel.send(Command(request=0))

    def _send(self, command: WheelCommand, request: int = packets.SENSORS) -> None:
        """Sends whole steps/s; what is cut off one is carried to the next."""
        left, right = (
            0.0 if speed == 0.0 else speed + rest
            for speed, rest in zip((command.left, command.right), self._carry, strict=True)
        )
        whole = round(left), round(right)
        self._carry = left - whole[0], right - whole[1]
        self.channel.send(Command(request, left=whole[0], right=whole[1]))
        self.predictor.sent(self.channel.now(), *whole)

    def _count(self) -> None:
        """Takes in the newest counts, which wrap at 16 bits."""
        heard, channel = self.channel.heard, self.channel
        at = channel.now() if channel.in_step else heard.time
        left, right = heard.sensors.steps
        if self._counts is not None:
            moved = wrapped(left - self._counts[0]), wrapped(right - self._counts[1])
            most = FASTEST * (max(0.0, at - self._counted_at) + 3.0 * CONTROL_PERIOD)
            if max(map(abs, moved)) <= most:
                self._total = self._total[0] + moved[0], self._total[1] + moved[1]
        self._counts, self._number, self._counted_at = (left, right), heard.number, at
        self._time = channel.now()
        self.predictor.counted(at, *self._total)

    def _perceive(self) -> None:
        sensors, calibration = self.channel.heard.sensors, self._calibration
        raw = tuple(map(float, sensors.proximity))
        left, ahead, up = (
            count / units.COUNTS_PER_G * units.GRAVITY for count in sensors.acceleration_vector
        )
        reach = min(sensors.tof / 1000.0, units.TOF_REACH)
        self._percept = Percept(
            self._percept.tick + 1,
            self._time - self._began,
            raw if calibration is None else calibration.freed(raw),
            self.predictor.now(self._time),
            (ahead, left, up),
            {"range": (reach,)},
        )


class LinkedWorld:
    """The surroundings of a robot behind a link, as `base.World`; truth is known in simulation only."""

    def __init__(
        self, robot: LinkedRobot, spec: WorldSpec, seed: int = 0, inner: World | None = None
    ) -> None:
        """inner: the simulation behind a modelled link, which knows what is true."""
        self.spec, self.seed = spec, seed
        self._robot, self._inner, self._open = robot, inner, True
        robot.act(STOP)
        robot.step()

    @property
    def robots(self) -> Sequence[Robot]:
        """The one robot."""
        return (self._robot,)

    @property
    def time(self) -> float:
        """Seconds since the start, by the link's clock."""
        return self._robot.sense().time

    def step(self) -> None:
        """Lets the next tick come. Raises: LinkError, or WorldError for a closed world."""
        if not self._open:
            raise WorldError(f"the link {self._robot.channel.name} is closed")
        self._robot.step()

    def true_pose(self, robot: int = 0) -> Pose:
        """Where the robot truly is; not a number where there is no simulation to ask."""
        return Pose(math.nan, math.nan, math.nan) if self._inner is None else self._inner.true_pose(robot)

    def collisions(self, robot: int = 0) -> int:
        """Ticks in which its shell touched something; 0 where nobody counts them."""
        return 0 if self._inner is None else self._inner.collisions(robot)

    def clearance(self, x: float, y: float) -> float:
        """Distance (m) from a point to the nearest shape; not a number where nobody knows."""
        return math.nan if self._inner is None else self._inner.clearance(x, y)

    def place(self, pose: Pose, robot: int = 0) -> None:
        """Raises: PlacementError, always: a robot behind a link is put somewhere by hand."""
        raise PlacementError("a robot behind a link cannot be placed: carry it there, and begin again")

    def state(self) -> Mapping[str, Any]:
        """Nothing that could be gone back to."""
        return {"kind": "link"}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Raises: WorldError, always."""
        raise WorldError("a robot behind a link cannot be put back to where a run was: begin a new one")

    def close(self) -> None:
        """Stops the robot, sees that it stands, and ends the link."""
        if self._open:
            self._open = False
            with contextlib.suppress(LinkError):
                self._robot.settle()
            self._robot.channel.close()

    def __enter__(self) -> Self:
        """The world itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closes it."""
        self.close()


def resized(image: Image, width: int, height: int, color: bool) -> Image:
    """An image (rows, columns, 3) as (height, width), or with 3 colors: pixels are means.

    The whole width is kept. Pixels stay square as far as there are rows: what is missing above and below
    repeats the first and the last row.
    """
    rows, columns = image.shape[:2]
    tall = columns * height / width
    edges = np.clip((np.arange(height + 1) / height - 0.5) * tall + rows / 2.0, 0.0, rows)
    over = _shares(edges, rows)
    across = _shares(np.arange(width + 1) / width * columns, columns)
    found = np.einsum("hr,rcx,wc->hwx", over, image, across, optimize=True)
    small: Image = (found if color else found @ _LUMA).astype(np.float32)
    return small


def _shares(edges: Any, count: int) -> Any:
    """(pixels, count): the share that each of `count` cells has in each pixel, given the pixels' edges."""
    low, high = edges[:-1, None], edges[1:, None]
    cells = np.arange(count)[None]
    share = np.clip(np.minimum(high, cells + 1) - np.maximum(low, cells), 0.0, None)
    total = share.sum(axis=1, keepdims=True)
    nearest = (cells == np.clip(np.floor((low + high) / 2.0), 0, count - 1)).astype(float)
    return np.where(total > 1e-9, share / np.where(total > 1e-9, total, 1.0), nearest)
