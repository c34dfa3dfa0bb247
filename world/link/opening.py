"""Opens a robot behind a link as a world: a real one or whatever speaks its protocol, or a simulated one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..spec import WorldSpec
from . import units
from .calibration import Calibration, load_calibration
from .channel import Channel, ModelChannel
from .device import Device
from .driver import LinkedRobot, LinkedWorld
from .model import Link, find_timings
from .tcp import TcpChannel

if TYPE_CHECKING:
    from ..base import World


def connect(url: str, place: str, seed: int = 0, calibration: Path | None = None) -> LinkedWorld:
    """The robot at `tcp://HOST:PORT`. place: what its surroundings are called, in maps.

    calibration: what `tolman calibrate` wrote. Raises: LinkError; WorldError for a wrong file.
    """
    measured = load_calibration(calibration) if calibration is not None else None
    return _opened(TcpChannel(url), WorldSpec(place, ()), seed, measured)


def behind_link(world: World, link: str, seed: int = 0, calibration: Path | None = None) -> LinkedWorld:
    """The first robot of a simulated world behind the modelled link of that name; its truth stays known.

    Raises: WorldError for an unknown link, or a wrong file.
    """
    measured = load_calibration(calibration) if calibration is not None else None
    channel = ModelChannel(Link(Device(world), find_timings(link), seed), f"link {link!r}")
    return _opened(channel, world.spec, seed, measured, world)


def _opened(
    channel: Channel, spec: WorldSpec, seed: int, measured: Calibration | None, inner: World | None = None
) -> LinkedWorld:
    geometry = units.E_PUCK2 if measured is None else measured.geometry(units.E_PUCK2)
    try:
        return LinkedWorld(LinkedRobot(channel, geometry, measured), spec, seed, inner)
    except BaseException:
        channel.close()
        raise
