"""Which reader a world file needs: by its suffix, and for YAML by its keys."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ...files.messages import printable
from ...files.reading import read_text
from ...files.yaml_nodes import MAX_BYTES, parse_yaml
from ..errors import WorldFileError
from ..spec import WorldSpec
from .maze import parse_maze
from .rosmap import ros_map
from .webots import parse_webots
from .worldfile import complete_world

LIMITS = {".yaml": MAX_BYTES, ".yml": MAX_BYTES, ".txt": 100_000, ".maze": 100_000, ".wbt": 5_000_000}
"""Bytes that are read of a file of each kind."""


def load_file(path: Path, lookup: Callable[[str], WorldSpec], scale: float = 1.0) -> WorldSpec:
    """The world in a file: .yaml/.yml (ours, or ROS map_server), .txt/.maze (drawn maze), .wbt (Webots).

    Raises: WorldFileError naming the file, and line and key where they are known.
    """
    suffix = path.suffix.lower()
    if suffix not in LIMITS:
        known = ", ".join(LIMITS)
        raise WorldFileError(f"{printable(str(path))}: a world file ends in one of {known}, not {suffix!r}")
    text, source = read_text(path, LIMITS[suffix], WorldFileError), str(path)
    if suffix == ".wbt":
        return parse_webots(text, source, path.stem, scale)
    if suffix in (".txt", ".maze"):
        return parse_maze(text, source, path.stem, scale)
    document = parse_yaml(text, source, WorldFileError)
    keys = document.mapping()
    if "tolman-world" not in keys and "image" in keys:
        return ros_map(document, source, path.parent, path.stem, scale)
    return complete_world(document, path, lookup, scale)
