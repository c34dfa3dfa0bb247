"""The worlds of experiments by name (see `names`): built in, changed, drawn, or imported."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from ....world.arenas.catalog import built_in_worlds, find_world
from ....world.errors import WorldError
from ....world.spec import WorldSpec
from ....world.transforms import mirrored, rotated, scaled
from .names import NOISIER, RANDOM, split
from .random_rooms import random_room
from .shaped_rooms import SHAPES, shaped_room

ODD_ANGLE = math.radians(17.0)
"""No multiple of it up to a full turn is near a right angle's."""
CHANGES: Mapping[str, Callable[[WorldSpec], WorldSpec]] = MappingProxyType(
    {
        "rotated": lambda spec: rotated(spec, ODD_ANGLE),
        "mirrored": mirrored,
        "smaller": lambda spec: scaled(spec, 0.8),
        "larger": lambda spec: scaled(spec, 1.2),
        NOISIER: lambda spec: spec,
    }
)
"""What is done to an environment, to see whether results hold there."""
_SCALE = re.compile(r"x(\d+(?:\.\d+)?)")
_SUFFIXES = {".yaml", ".yml", ".wbt", ".txt"}


def experiment_world(name: str, folder: Path) -> WorldSpec:
    """The world of that name. folder: the work folder. Raises: WorldError and its kinds."""
    base, change = split(name)
    if base == RANDOM:
        return random_room(int(change))
    if base in SHAPES:
        return shaped_room(base, int(change))
    scale = _SCALE.fullmatch(change)
    world: str | Path = base if base in built_in_worlds() else _imported(folder) / base
    if scale is not None:
        return find_world(world, float(scale.group(1)))
    spec = find_world(world)
    if not change:
        return spec
    if change not in CHANGES:
        raise WorldError(
            f"unknown change {change!r} of world {base!r}; known: {', '.join(CHANGES)}, x<scale>"
        )
    return CHANGES[change](spec)


def import_world(source: str, folder: Path) -> str:
    """Copies a world file, with the bitmap it may name, into the work folder; returns its name there.

    source: "FILE" or "FILE:SCALE". Work folders so hold all that their runs depend on.
    Raises: WorldError for a file that is not there or not a world's.
    """
    text, _, scale = source.rpartition(":")
    if not text:
        text, scale = source, ""
    path = Path(text)
    if path.suffix not in _SUFFIXES or not path.is_file():
        raise WorldError(f"{source}: expected an existing world file ({', '.join(sorted(_SUFFIXES))})")
    if scale and not _SCALE.fullmatch(f"x{scale}"):
        raise WorldError(f"{source}: {scale!r} is no scale; write it as in {path.name}:0.4")
    target = _imported(folder)
    target.mkdir(parents=True, exist_ok=True)
    for file in (path, *_bitmaps(path)):
        shutil.copyfile(file, target / file.name)
    return f"{path.name} x{scale}" if scale else path.name


def _bitmaps(path: Path) -> list[Path]:
    """The file that a ROS map names as its image, if it lies beside it."""
    if path.suffix not in (".yaml", ".yml"):
        return []
    named = re.search(
        r"^image:\s*['\"]?([^'\"\n]+?)['\"]?\s*$", path.read_text(encoding="utf-8"), re.MULTILINE
    )
    beside = path.parent / Path(named.group(1)).name if named else path
    return [beside] if named and beside.is_file() else []


def _imported(folder: Path) -> Path:
    return folder / "worlds"
