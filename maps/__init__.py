"""Self-organizing maps, local maps, the hybrid graph and its storage."""

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
from .fields import Arc
from .formats.exporting import export
from .formats.json_map import read_json
from .hybrid_map import HybridMap
from .local.config import LocalMapConfig
from .local.local_map import LocalEstimate, LocalMap
from .local.training import train as train  # what LocalMap.build goes by
from .matching.comparing import Comparison, compare
from .matching.merging import merge
from .meta import MapMeta
from .som.schedules import BatchConfig, OnlineConfig
from .som.som import SOM
from .storage.map_file import MapFile, Truth, read_truth
from .storage.migration import migrate
from .storage.sealed import SealedFiles as SealedFiles  # what HybridMap.load and save go by
from .storage.validation import Validation, recover, validate

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
