"""The built-in worlds, and finding a world by name or by path."""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path

from ...files.messages import unknown
from ..errors import UnknownWorldError, WorldError
from ..spec import WorldSpec


@cache
def built_in_worlds() -> tuple[str, ...]:
    """Names of the worlds that come with the package, sorted."""
    files = (entry.name for entry in resources.files(__package__).iterdir())
    return tuple(sorted(name.removesuffix(".yaml") for name in files if name.endswith(".yaml")))


@cache
def built_in_world(name: str) -> WorldSpec:
    """The built-in world of this name.

    Raises: UnknownWorldError, listing those there are.
    """
    from ..formats.worldfile import (
        parse_world,  # here, so that importing tolman.world does not load a YAML reader
    )

    if name not in built_in_worlds():
        raise _unknown(name)
    text = resources.files(__package__).joinpath(f"{name}.yaml").read_text(encoding="utf-8")
    return parse_world(text, f"{name}.yaml", name, built_in_world)


def find_world(world: str | Path, scale: float = 1.0) -> WorldSpec:
    """A world by built-in name, or by path: a world file, a ROS map_server YAML, a maze (.txt) or a .wbt.

    scale: what lengths in a file are multiplied by.

    Raises: UnknownWorldError when there is neither; WorldFileError for a file that cannot be read.
    """
    if isinstance(world, str) and world in built_in_worlds():
        if scale != 1.0:
            raise WorldError(f"world {world!r} is built in and cannot be scaled (by {scale:g}); files can")
        return built_in_world(world)
    path = Path(world)
    if not path.suffix and not path.exists():
        raise _unknown(str(world))
    from ..formats.files import load_file  # here, so that built-in names alone need no readers

    return load_file(path, built_in_world, scale)


def _unknown(name: str) -> UnknownWorldError:
    return UnknownWorldError(f"{unknown('world', name, built_in_worlds())}; or the path of a world file")
