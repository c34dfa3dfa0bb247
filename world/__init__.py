"""The robot and its surroundings: worlds as data, simulated with DART or kinematically."""

from .arenas.catalog import built_in_world, built_in_worlds, find_world
from .base import World
from .errors import (
    EngineMissingError,
    PlacementError,
    SimulationError,
    UnknownWorldError,
    WorldError,
    WorldFileError,
    WorldWarning,
)
from .factory import open_world
from .noise.model import PRESETS, Noise
from .robot import CONTROL_PERIOD, EPUCK, EPUCK2, Image, Percept, Pose, Robot, RobotGeometry, WheelCommand
from .sensors.sensor import Timing
from .spec import WorldSpec

__all__ = [
    "CONTROL_PERIOD",
    "EPUCK",
    "EPUCK2",
    "PRESETS",
    "EngineMissingError",
    "Image",
    "Noise",
    "Percept",
    "PlacementError",
    "Pose",
    "Robot",
    "RobotGeometry",
    "SimulationError",
    "Timing",
    "UnknownWorldError",
    "WheelCommand",
    "World",
    "WorldError",
    "WorldFileError",
    "WorldSpec",
    "WorldWarning",
    "built_in_world",
    "built_in_worlds",
    "find_world",
    "open_world",
]
