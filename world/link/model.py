"""The radio link as a model: how late packets and commands are, drawn from published timings, by seed.

The figures come from measurements of one e-puck2 by its users (2021: 2858 exchanges, 549 images).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ...files.messages import unknown
from ..errors import WorldError
from . import packets
from .packets import Command

if TYPE_CHECKING:
    from .device import Device

_SOON = 1e-9
"""Seconds by which sums of ticks may differ."""


@dataclass(frozen=True, slots=True)
class Timings:
    """How late a link is; all in s.

    age: of sensors when they arrive, uniform between both. command: from sending to the wheels, likewise.
    stalls: the share of sensor packets at which the link stands still, and for how long, uniform.
    image: what one image takes, as the quantiles (share, s) of its distribution, linear between them.
    """

    age: tuple[float, float] = (0.0, 0.0)
    command: tuple[float, float] = (0.0, 0.0)
    stalls: tuple[tuple[float, float, float], ...] = ()
    image: tuple[tuple[float, float], ...] = ((0.0, 0.096), (1.0, 0.096))


AGE, COMMAND = (0.025, 0.050), (0.015, 0.045)
IMAGE = (
    (0.0, 0.05),
    (0.1, 0.071),
    (0.5, 0.133),
    (0.75, 0.309),
    (0.9, 1.12),
    (0.95, 1.69),
    (0.99, 4.67),
    (1.0, 5.9),
)
"""Receiving one image, both streams on: 293 of them."""
LINKS: Mapping[str, Timings] = MappingProxyType(
    {
        "ideal": Timings(),
        "calm": Timings(
            AGE, COMMAND, ((0.0004, 0.2, 0.4),), ((0.0, 0.1), (0.5, 0.161), (0.95, 0.205), (1.0, 1.33))
        ),
        "published": Timings(AGE, COMMAND, ((0.004, 0.2, 0.4), (0.003, 1.0, 2.0)), IMAGE),
    }
)
"""By name: no delays; the good day of those measurements; the bad one, with stalls of up to 2 s."""


def find_timings(name: str) -> Timings:
    """The timings of that name. Raises: WorldError, naming the nearest."""
    if name not in LINKS:
        raise WorldError(unknown("link", name, LINKS))
    return LINKS[name]


class Link:
    """A robot's stream as it arrives over a link: `send` commands, let time `tick`, take what `arrived`.

    Time is the world's. A cycle's packets are made and sent before the next one's; nothing is queued.
    """

    def __init__(self, device: Device, timings: Timings, seed: int = 0) -> None:
        """Silent, as the robot is until its first command."""
        self.device, self.timings = device, timings
        self.request: int | None = None
        self._random = np.random.default_rng(np.random.SeedSequence([seed, 0x2E]))
        self._commands: deque[tuple[float, Command]] = deque()
        self._under_way: deque[tuple[float, int, bytes]] = deque()
        self._stalled, self._busy = 0.0, 0.0

    @property
    def time(self) -> float:
        """Simulated s."""
        return self.device.world.time

    def hang_up(self) -> None:
        """The client is gone: what is under way is lost, and the robot is silent again."""
        self.request = None
        self._commands.clear()
        self._under_way.clear()
        self._busy = 0.0

    def send(self, command: Command) -> None:
        """Sends a command, which reaches the robot after a while, behind those sent before."""
        due = max(self.time + self._draw(self.timings.command), self._stalled)
        if self._commands:
            due = max(due, self._commands[-1][0])
        self._commands.append((due, command))

    def tick(self) -> None:
        """Lets 32 ms pass for robot and link."""
        while (
            self._commands and self._commands[0][0] <= self.time + _SOON and self._busy <= self.time + _SOON
        ):
            command = self._commands.popleft()[1]
            self.request = command.request
            self.device.obey(command)
        self.device.tick()
        if self.request is not None and self._busy <= self.time + _SOON:
            self._cycle(self.request)

    def arrived(self) -> list[tuple[int, bytes]]:
        """What has arrived since it was asked last: ids and payloads."""
        here = []
        while self._under_way and self._under_way[0][0] <= self.time + _SOON:
            here.append(self._under_way.popleft()[1:])
        return here

    def _cycle(self, request: int) -> None:
        """The robot's cycle: an image, then sensors, as asked for; an empty packet where neither is."""
        due = self.time + self._draw(self.timings.age)
        for share, shortest, longest in self.timings.stalls:
            if self._random.random() < share:
                self._stalled = max(self._stalled, self.time + self._draw((shortest, longest)))
        due = max(due, self._stalled)
        if request & packets.IMAGES:
            shares, seconds = zip(*self.timings.image, strict=True)
            due = max(due, self.time + float(np.interp(self._random.random(), shares, seconds)))
            self._busy = due
            self._put(due, packets.IMAGE_ID, self.device.image())
        if request & packets.SENSORS:
            self._put(due, packets.SENSORS_ID, self.device.sensors().pack())
        if request == 0:
            self._put(due, packets.EMPTY_ID, b"")

    def _put(self, due: float, kind: int, payload: bytes) -> None:
        if self._under_way:
            due = max(due, self._under_way[-1][0])
        self._under_way.append((due, kind, payload))

    def _draw(self, span: tuple[float, float]) -> float:
        low, high = span
        return low if low == high else float(self._random.uniform(low, high))
