"""What brings a robot's packets: the contract, and one for a simulated robot behind a link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..errors import WorldError
from . import packets
from .model import Link
from .packets import Command, Pixels, Sensors


class LinkError(WorldError, RuntimeError):
    """The link to a robot is lost, or was never made."""


@dataclass(frozen=True, slots=True)
class Heard:
    """The newest packets. number: of sensors so far; time: s, when the last came; pictures: of images."""

    number: int = 0
    time: float = 0.0
    sensors: Sensors = Sensors()  # noqa: RUF009  frozen
    pictures: int = 0
    image: Pixels | None = None

    def with_packet(self, kind: int, payload: bytes, time: float) -> Heard:
        """The same with one more packet."""
        if kind == packets.SENSORS_ID:
            sensors = Sensors.unpack(payload)
            return Heard(self.number + 1, time, sensors, self.pictures, self.image)
        if kind == packets.IMAGE_ID:
            image = packets.unpack_image(payload)
            return Heard(self.number, self.time, self.sensors, self.pictures + 1, image)
        return self


class Channel(Protocol):
    """Packets of one robot, and the clock that they are timed by."""

    name: str
    in_step: bool
    """Whether each command is answered once, so that no time passes but by commands."""

    @property
    def heard(self) -> Heard:
        """The newest packets that have come."""

    def now(self) -> float:
        """Seconds since it was made."""

    def send(self, command: Command) -> None:
        """Sends a command; one that cannot be sent now is lost."""

    def wait(self, until: float, seen: Heard) -> None:
        """Lets time pass until something else than `seen` is heard, or until then. Raises: LinkError."""

    def close(self) -> None:
        """Ends it."""


class ModelChannel:
    """A simulated robot behind a modelled link, in simulated time."""

    in_step = False

    def __init__(self, link: Link, name: str = "simulated") -> None:
        """link: with the robot at its other end."""
        self.link, self.name = link, name
        self.heard = Heard()

    def now(self) -> float:
        """Simulated seconds."""
        return self.link.time

    def send(self, command: Command) -> None:
        """Sends a command."""
        self.link.send(command)

    def wait(self, until: float, seen: Heard) -> None:
        """Lets ticks pass until something arrives, or until then."""
        while self.heard is seen and self.now() < until:
            self.link.tick()
            for kind, payload in self.link.arrived():
                self.heard = self.heard.with_packet(kind, payload, self.now())

    def close(self) -> None:
        """Stops the robot and ends its simulation."""
        self.link.device.stop()
        self.link.device.world.close()
