"""The kinds of worlds that can be drawn, and drawing one: `make_world`.

A kind and a seed give the same bytes on every machine. What is drawn is a file as a user would have it, a
world file or a ROS map with its image, so that it goes the same way through the readers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from ...files.messages import unknown
from ..errors import WorldError
from ..formats.writing import world_text
from ..spec import WorldSpec
from . import clutter, halls, mazes, offices, scans

_STREAM = 41
"""Keeps these draws apart from others with the same seed."""


@dataclass(frozen=True, slots=True)
class DrawnWorld:
    """A drawn world as files. text: of the YAML file. beside: name ending -> bytes of files beside it."""

    text: str
    beside: Mapping[str, bytes] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of worlds. draw: from random numbers and the name of the world (its file, without ending)."""

    name: str
    description: str
    draw: Callable[[np.random.Generator, str], DrawnWorld]


def _by_spec(
    draw: Callable[[np.random.Generator], WorldSpec],
) -> Callable[[np.random.Generator, str], DrawnWorld]:
    return lambda rng, name: DrawnWorld(world_text(draw(rng)))


def _scan(rng: np.random.Generator, name: str) -> DrawnWorld:
    text, image = scans.scanned_plan(rng, f"{name}.pgm")
    return DrawnWorld(text, {".pgm": image})


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            Kind(
                "scan", "a scanned plan: ragged, slanted, rooms with door posts, legs, unknown pockets", _scan
            ),
            Kind("office", "a corridor between rooms with desks and cupboards", _by_spec(offices.office)),
            Kind("building", "a hundred rooms along ten corridors", _by_spec(offices.building)),
            Kind("hall", "a hall with curved walls, alcoves and round pillars", _by_spec(halls.hall)),
            Kind(
                "clutter",
                "posts, wedges, stubs of thin walls, gaps too narrow to pass",
                _by_spec(clutter.room),
            ),
            Kind("maze", "a maze without loops", _by_spec(mazes.tree_maze)),
            Kind("islands", "a maze with loops, so that walls stand free", _by_spec(mazes.braided_maze)),
            Kind(
                "contest",
                "16 x 16 cells with a free-standing center, as in contests",
                _by_spec(mazes.contest_maze),
            ),
        )
    }
)
"""What can be drawn, by name."""


def make_world(kind: str, seed: int, name: str = "world") -> DrawnWorld:
    """The world of a kind and a seed. name: what its image is called, without ending.

    Raises: WorldError for an unknown kind, naming those there are, or a seed below 0.
    """
    if kind not in KINDS:
        raise WorldError(unknown("kind of worlds", kind, KINDS))
    if seed < 0:
        raise WorldError(f"a seed is a whole number from 0, not {seed}")
    sequence = np.random.SeedSequence([seed, _STREAM, list(KINDS).index(kind)])
    return KINDS[kind].draw(np.random.default_rng(sequence), name)
