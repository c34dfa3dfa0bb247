"""Takes crafted map files through what commands do: load, validate, recover, plot, export. POSIX only."""

from __future__ import annotations

import contextlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from tolman.files.messages import FileError
from tolman.maps import HybridMap, LocalMap, MapError, MapFile, export, recover, validate
from tolman.scripts.cli.commands.info import summary, table
from tolman.scripts.drawing.map_picture import plot_map
from tolman.world.errors import WorldError

from .children import counted
from .crafted import craft
from .maps import content_digest, map_made_up_world

KNOWN = (MapError, FileError, WorldError)
"""What a command tells in one line."""


def commands(count: int, seed: int, folder: Path, plotted: int = 500) -> Counter[str]:
    """Takes `count` crafted files through all of it, counts how each ended; `plotted` of them are drawn."""
    source = folder / "source.tolman"
    make_source(source)
    every = max(1, count // plotted)
    return counted(count, lambda number: _one(source, number, seed, folder, number % every == 0))


def make_source(path: Path) -> None:
    """A small map with all that a file can hold; one local map has views, one has none."""
    map_made_up_world(path, 4, 1)
    with MapFile.resume(path) as file:
        bare = LocalMap.build(np.random.default_rng(1).uniform(-0.1, 0.1, (30, 2)))
        for node, local in ((1, bare), (2, None), (3, None)):
            file.map.graph.nodes[node]["local_map"] = local
        file.map.annotate(3, place_m=[0.5, 0.25])
        file.map.add_arc(0, 3, "right", 0.7, kind="foray", notes={"crossing": {"turn": 1.5}})
        file.update(file.map, file.map.nodes(), list(file.map.graph.edges(keys=True)))
        file.put_extension("someone", "color", {"door": "red"})


def _one(source: Path, number: int, seed: int, folder: Path, plot: bool) -> str:
    path = folder / "crafted.tolman"
    what = craft(source, path, np.random.default_rng([seed, number]))
    ended = []
    for name, deed in _deeds(path, folder, plot):
        try:
            ended.append("refused" if deed() is False else "done")
        except KNOWN as error:
            if "\n" in str(error):
                return f"more than one line: {name}: {what}"
            ended.append("refused")
        except Exception as error:
            return f"another exception: {number}: {name}: {what}: {type(error).__name__}: {str(error)[:90]!r}"
    if ended[0] == "refused":
        return "refused"
    fault = _ill_formed(path, folder)
    if fault:
        return f"silently wrong: {number}: {what}: {fault}"
    return (
        "loaded, and well-formed"
        if "refused" not in ended[:2]
        else "loaded, a local map or the truth refused"
    )


def _deeds(path: Path, folder: Path, plot: bool) -> Iterator[tuple[str, Callable[[], object]]]:
    loaded: list[HybridMap] = []

    def info() -> None:
        values = summary(loaded[0])
        table(values, values["meta"])
        json.dumps(values, allow_nan=False)

    yield "load", lambda: loaded.append(HybridMap.load(path))
    yield "read all", lambda: content_digest(path)
    yield "validate", lambda: validate(path).valid
    yield "recover", lambda: _recovered(path, folder / "recovered.tolman")
    if loaded:
        yield "info", info
        for form in ("json", "graphml", "geojson", "ros"):
            yield form, partial(export, loaded[0], form, folder / f"out.{form}", force=True)
    if plot or not loaded:
        yield "plot", lambda: plot_map(path, folder / "out.png")


def _recovered(path: Path, output: Path) -> None:
    recover(path, output, force=True)
    about = validate(output)
    if not about.valid:
        raise AssertionError(f"what was recovered is not valid: {about.problems[0]}")


def _ill_formed(path: Path, folder: Path) -> str:
    """What is wrong with a map that loaded, by checks that share nothing with the reader's."""
    hybrid, again = HybridMap.load(path), folder / "again.tolman"
    for node, data in hybrid.graph.nodes(data=True):
        angles = data["turn"], data["entry_heading"]
        if type(node) is not int or type(data["name"]) is not str or type(data["notes"]) is not dict:
            return f"node {node!r}"
        if any(type(angle) is not float or not math.isfinite(angle) for angle in angles):
            return f"angles of node {node}"
        if data["corner"] not in ("concave", "convex", "none"):
            return f"corner of node {node}"
    for arc in hybrid.arcs():
        numbers = arc.distance, arc.variance
        if any(type(value) is not float or not 0.0 <= value < 1e13 for value in numbers):
            return f"numbers of {arc}"
        if (
            type(arc.traversals) is not int
            or type(arc.blocked) is not bool
            or arc.side not in ("right", "left")
        ):
            return f"values of {arc}"
    with contextlib.suppress(MapError):  # a local map that cannot be read
        hybrid.save(again, force=True)
        if list(HybridMap.load(again).arcs()) != list(hybrid.arcs()):
            return "saved and loaded it is another"
    return ""
