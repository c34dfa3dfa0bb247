"""What the command line, the experiments and missions ask for: mapping a world, and a trip over a map."""

from .mapping_run import map_world
from .requests import GoReport, GoRequest, MapReport, MapRequest, Progress, SessionError, Simulation
from .trip_run import go_to

__all__ = [
    "GoReport",
    "GoRequest",
    "MapReport",
    "MapRequest",
    "Progress",
    "SessionError",
    "Simulation",
    "go_to",
    "map_world",
]
