"""Reads what a page is made of: a recording, a map file, or both."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...agent.containment import describe
from ...agent.errors import RecordingError
from ...agent.recording.reader import MAGIC, RecordedTick, Recording, read_recording
from ...files.reading import open_regular
from ...maps import HybridMap, MapError
from ...world.arenas.catalog import find_world
from ...world.errors import WorldError
from ...world.robot import CONTROL_PERIOD, EPUCK, Pose
from ..drawing.map_picture import alone, walls_of
from ..errors import UsageError
from ..session.recording import outlines
from ..session.truth import read_map_truth
from .map_content import map_content
from .robots import GEOMETRIES, robot_content
from .ticks import Gatherer

_KINDS = {"map": "mapping", "go": "trip", "mission": "mission"}


@dataclass(frozen=True, slots=True)
class Subject:
    """What a page shows, and what there is to say about how it was read. content: for `pack`."""

    content: dict[str, Any]
    remarks: tuple[str, ...] = ()


def is_recording(path: Path) -> bool:
    """Whether a file begins as recordings do. Raises: UsageError if it cannot be read."""
    with open_regular(path, UsageError) as file:
        return file.read(len(MAGIC)) == MAGIC


def read_subject(path: Path, map_file: Path | None = None, world: str | None = None) -> Subject:
    """Reads a recording or a map file. map_file: the map that a recorded run made or drove by.

    world: name or file of the world to draw, instead of the one that the file names.

    Raises: RecordingError, MapError, WorldError, UsageError.
    """
    if not is_recording(path):
        if map_file is not None:
            raise UsageError(f"--map goes with a recording, and {path} is none")
        return map_subject(path, world)
    try:
        return run_subject(path, map_file, world)
    except (TypeError, ValueError, LookupError, AttributeError, OverflowError) as fault:
        if type(fault).__module__.startswith("tolman."):
            raise  # it says in one line what is wrong; the others come of a recording that holds anything
        raise RecordingError(f"{path}: it holds what no page can show ({describe(fault)})") from fault


def map_subject(path: Path, world: str | None = None) -> Subject:
    """What a map file alone shows. Raises: MapError, WorldError."""
    hybrid = HybridMap.load(path)
    truth = read_map_truth(path)
    known = truth is not None and set(hybrid.graph) <= truth.nodes.keys()
    poses = dict(truth.nodes) if truth is not None and known else alone(hybrid)
    meta = hybrid.meta
    about = {
        "title": path.name,
        "kind": "map file",
        "facts": {"world": meta.world, "seed": meta.seed, "noise": meta.noise, "profile": meta.profile},
        "placed": "true" if known else "map",
        "period": CONTROL_PERIOD,
    }
    content = {
        "about": about,
        "walls": [list(map(list, shape.outline())) for shape in walls_of(hybrid, world)] if known else [],
        "robot": robot_content(EPUCK),
        "behaviors": [],
        "track": truth.track.round(4).tolist() if truth is not None and known else [],
        "map": map_content(hybrid, poses),
    }
    return Subject(content)


def run_subject(path: Path, map_file: Path | None, world: str | None) -> Subject:
    """What a recording shows, with its map if it is found. Raises: RecordingError, MapError, WorldError."""
    recording = read_recording(path)
    header = recording.header
    if not recording.ticks:
        raise RecordingError(f"{path}: the recording has no ticks")
    geometry = GEOMETRIES.get(str(header.get("geometry")), EPUCK)
    gatherer = Gatherer(geometry)
    for tick in recording.ticks:
        gatherer.add(tick)
    remarks = [] if recording.complete else [f"{path}: the recording is cut off"]
    hybrid, truth, remark = _map_of(path, recording, map_file)
    remarks += [remark] if remark else []
    poses = corner_poses(recording.ticks) | truth
    asked = header.get("request", {})
    facts = {name: asked[name] for name in ("to", "side", "noise", "profile") if asked.get(name) is not None}
    content = {
        "about": {
            "title": path.name,
            "kind": _KINDS.get(str(header.get("kind")), "run"),
            "facts": {"world": header.get("world"), "seed": header.get("seed"), **facts},
            "complete": recording.complete,
            "placed": "true" if gatherer.start is not None else "map",
            "period": CONTROL_PERIOD,
            "grown": header.get("kind") == "map" or hybrid is None,
        },
        "walls": _walls(header, world),
        "robot": robot_content(geometry),
        "behaviors": _behaviors(header),
        "track": [],
        "ticks": gatherer.take(),
        "map": {"nodes": [], "arcs": []} if hybrid is None else map_content(hybrid, poses),
        "places": {node: [pose.x, pose.y, pose.heading] for node, pose in poses.items()},
    }
    return Subject(content, tuple(remarks))


def corner_poses(ticks: Iterable[RecordedTick]) -> dict[int, Pose]:
    """Node -> where the robot truly was when it met the node's corner, of the nodes that a run made."""
    corners: dict[int, Pose] = {}
    nodes: dict[int, Pose] = {}
    for tick in ticks:
        for text in tick.events:
            if '"CornerReached"' not in text and '"NodeCreated"' not in text:
                continue
            event = json.loads(text)
            number, node = event.get("number"), event.get("node")
            if event.get("$") == "CornerReached" and isinstance(number, int) and tick.truth is not None:
                corners[number] = tick.truth
            elif event.get("$") == "NodeCreated" and isinstance(node, int) and event.get("met") in corners:
                nodes[node] = corners[event["met"]]
    return nodes


def _walls(header: Mapping[str, Any], world: str | None) -> list[list[list[float]]]:
    """Outlines (m) of the walls: those in the recording, or of the world of that name if it is the same."""
    if world is None and isinstance(header.get("walls"), list):
        return [[[float(x), float(y)] for x, y in outline] for outline in header["walls"]]
    if world is not None:
        return outlines(find_world(world))
    asked = header.get("request", {})
    try:
        spec = find_world(str(asked.get("world") or header.get("world")), float(asked.get("scale", 1.0)))
    except WorldError:
        return []
    return outlines(spec) if spec.digest == header.get("world_digest") else []


def _behaviors(header: Mapping[str, Any]) -> list[Any]:
    """The behaviors that the recording describes, as far as they are what `described` makes."""
    found = header.get("behaviors", [])
    kinds = {"name": str, "priority": int, "about": str, "settings": dict, "states": list, "initial": str}
    kinds |= {"edges": list, "children": dict}
    return [
        each
        for each in (found if isinstance(found, list) else ())
        if isinstance(each, dict) and all(isinstance(each.get(name), kind) for name, kind in kinds.items())
    ]


def _map_of(
    path: Path, recording: Recording, asked: Path | None
) -> tuple[HybridMap | None, dict[int, Pose], str]:
    """The map, the true places of its nodes, and a remark on where it is from.

    It is the one asked for, the one that came with the recording, or the one that the run wrote, if that
    still lies there and was made by the same run.
    """
    kind = recording.header.get("kind")
    if asked is not None:
        return *_loaded(asked), ""
    if kind != "map" and "map" in recording.attachments:
        with tempfile.TemporaryDirectory() as folder:
            kept = Path(folder) / "map.tolman"
            kept.write_bytes(recording.attachments["map"])
            return *_loaded(kept), ""
    output = recording.header.get("request", {}).get("output")
    if kind != "map" or not isinstance(output, str):
        return None, {}, ""
    for place in (Path(output), path.parent / Path(output).name):
        if place.is_file():
            try:
                hybrid, truth = _loaded(place)
            except (MapError, OSError):
                continue
            if _same_run(hybrid, recording.header):
                return hybrid, truth, f"with the map that it made, {place}"
    return None, {}, "without its local maps: give the map that it made with --map FILE"


def _loaded(path: Path) -> tuple[HybridMap, dict[int, Pose]]:
    hybrid = HybridMap.load(path)
    for node in hybrid.nodes():
        local_map = hybrid.local_map(node)
        if local_map is not None:
            _ = local_map.content  # read now: the file may go
    truth = read_map_truth(path)
    return hybrid, {} if truth is None else dict(truth.nodes)


def _same_run(hybrid: HybridMap, header: Mapping[str, Any]) -> bool:
    asked, meta = header.get("request", {}), hybrid.meta
    then = (header.get("world_digest"), header.get("seed"), asked.get("noise"), asked.get("profile"))
    return then == (meta.world_digest, meta.seed, meta.noise, meta.profile)
