"""Self-organizing maps, local maps, the hybrid graph and its storage."""

from .checking import Validation, recover, validate
from .comparing import Comparison, compare
from .errors import (
    MapError,
    MapFileDamagedError,
    MapFileError,
    MapFileExistsError,
    MapFileLockedError,
    MapFileVersionError,
    NoMatchError,
    NoPathError,
    NotTrainedError,
    UnknownNodeError,
)
from .exporting import export
from .hybrid_map import Arc, HybridMap
from .json_map import read_json
from .local_map import LocalEstimate, LocalMap
from .local_training import LocalMapConfig
from .map_file import MapFile, Truth, read_truth
from .merging import merge
from .meta import MapMeta
from .migrating import migrate
from .schedules import BatchConfig, OnlineConfig
from .som import SOM

__all__ = [
    "SOM",
    "Arc",
    "BatchConfig",
    "Comparison",
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
    "MapFileVersionError",
    "MapMeta",
    "NoMatchError",
    "NoPathError",
    "NotTrainedError",
    "OnlineConfig",
    "Truth",
    "UnknownNodeError",
    "Validation",
    "compare",
    "export",
    "merge",
    "migrate",
    "read_json",
    "read_truth",
    "recover",
    "validate",
]
