"""Which reader a world file needs: by its suffix, and for YAML by its keys."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..errors import WorldFileError
from ..spec import WorldSpec
from .maze import load_maze
from .rosmap import load_ros_map
from .webots import load_webots
from .worldfile import load_world
from .yamlnodes import read_text, read_yaml


def load_file(path: Path, lookup: Callable[[str], WorldSpec], scale: float = 1.0) -> WorldSpec:
    """The world in a file: .yaml/.yml (ours, or ROS map_server), .txt/.maze (drawn maze), .wbt (Webots).

    Raises: WorldFileError naming the file, and line and key where they are known.
    """
    suffix = path.suffix.lower()
    if suffix == ".wbt":
        return load_webots(path, scale)
    if suffix in (".txt", ".maze"):
        return load_maze(path, scale)
    if suffix not in (".yaml", ".yml"):
        raise WorldFileError(f"{path}: a world file ends in .yaml, .yml, .txt, .maze or .wbt, not {suffix!r}")
    keys = read_yaml(read_text(path), str(path)).mapping()
    if "tolman-world" not in keys and "image" in keys:
        return load_ros_map(path, scale)
    return load_world(path, lookup, scale)
