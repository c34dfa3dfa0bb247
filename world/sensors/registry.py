"""The sensors that robots can carry: a new one is one file and one line here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

from ...files.messages import unknown
from ..errors import WorldError
from ..robot import RobotGeometry
from .accelerometer import Accelerometer
from .camera import Camera
from .encoders import Encoders
from .infrared import Infrared
from .range_finder import RangeFinder
from .sensor import Sensor, Timing

SENSORS: Mapping[str, type[Sensor]] = MappingProxyType(
    {
        "infrared": Infrared,
        "encoders": Encoders,
        "accelerometer": Accelerometer,
        "camera": Camera,
        "range": RangeFinder,
    }
)
STANDARD = ("infrared", "encoders", "accelerometer", "camera")
"""What every robot carries."""
Fitted: TypeAlias = Mapping[str, tuple[type[Sensor], Timing]]
"""The sensors of a robot, by name, with their timing."""


def fitted(
    geometry: RobotGeometry, sensing: Mapping[str, Timing | Mapping[str, Any]] | None = None
) -> Fitted:
    """The sensors that a robot carries: those of every robot, its own, and those that `sensing` names.

    sensing: other timings, such as {"camera": {"delay": 0.096}}; {"range": {}} adds a range finder.

    Raises: WorldError for an unknown sensor, naming the nearest, or a wrong timing.
    """
    chosen = dict.fromkeys((*STANDARD, *geometry.extra_sensors, *(sensing or {})))
    result = {}
    for name in chosen:
        if name not in SENSORS:
            raise WorldError(unknown("sensor", name, SENSORS))
        timing = SENSORS[name].timing.changed(name, (sensing or {}).get(name, {}))
        timing.ticks(name)
        result[name] = SENSORS[name], timing
    return result
