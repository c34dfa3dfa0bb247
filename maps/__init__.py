"""Self-organizing maps, local maps, the hybrid graph and its storage."""

from .errors import (
    MapError,
    MapFileDamagedError,
    MapFileError,
    MapFileExistsError,
    MapFileLockedError,
    NoMatchError,
    NoPathError,
    NotTrainedError,
    UnknownNodeError,
)
from .hybrid_map import Arc, HybridMap
from .local_map import LocalEstimate, LocalMap, LocalMapConfig
from .map_file import MapFile, Truth, read_truth
from .meta import MapMeta
from .schedules import BatchConfig, OnlineConfig
from .som import SOM

__all__ = [
    "SOM",
    "Arc",
    "BatchConfig",
    "HybridMap",
    "LocalEstimate",
    "LocalMap",
    "LocalMapConfig",
    "MapError",
    "MapFile",
    "MapFileDamagedError",
    "MapFileError",
    "MapFileExistsError",
    "MapFileLockedError",
    "MapMeta",
    "NoMatchError",
    "NoPathError",
    "NotTrainedError",
    "OnlineConfig",
    "Truth",
    "UnknownNodeError",
    "read_truth",
]
