"""Measures what a control step costs, and how that compares: `make bench`.

Everything is measured in one run, in turns: each round times every contender for some ticks, and a ratio is
the median of the rounds' ratios, so that a machine that is slow for a while is slow for both sides. Times are
processor time of this process. `--json FILE` also writes all figures down.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world
from tolman.world import CONTROL_PERIOD, built_in_world, find_world, open_world
from tolman.world.spec import Box

from .figures import Figure, report
from .pipeline import Parts, Pipeline, boxes_world
from .rivals import ir_sim, raw_dart

BOXES = (12, 100, 1000)
ROBOTS = (1, 4, 16)
CAMERA_SIZES = ((16, 16), (64, 64), (640, 480))
Tick = Callable[[], object]


def timed(step: Tick, ticks: int) -> float:
    """Seconds a tick, over so many."""
    began = time.process_time()
    for _ in range(ticks):
        step()
    return (time.process_time() - began) / ticks


def in_turns(contenders: Mapping[str, Tick], rounds: int, ticks: int) -> dict[str, list[float]]:
    """Seconds a tick of each contender in each round."""
    found: dict[str, list[float]] = {name: [] for name in contenders}
    for step in contenders.values():
        timed(step, max(20, ticks // 10))
    for _ in range(rounds):
        for name, step in contenders.items():
            found[name].append(timed(step, ticks))
            pipeline = getattr(step, "__self__", None)
            if isinstance(pipeline, Pipeline):
                pipeline.renew()
    return found


def ratio(found: Mapping[str, list[float]], above: str, below: str) -> float:
    """How many times what `below` costs `above` costs: the median over the rounds."""
    return statistics.median(a / b for a, b in zip(found[above], found[below], strict=True))


def ros_map(folder: Path) -> Path:
    """A map_server map of 600 x 500 cells of 1 cm: a room of uneven walls with a pillar every meter."""
    random = np.random.default_rng(0)
    image = np.full((500, 600), 205, dtype=np.uint8)
    image[20:480, 20:580] = 254
    depth = np.repeat(random.integers(0, 3, (4, 24)), 25, axis=1)
    for column in range(20, 580):
        image[20 : 20 + depth[0, column], column] = 0
        image[480 - depth[1, column] : 480, column] = 0
    for row in range(20, 480):
        image[row, 20 : 20 + depth[2, row]] = 0
        image[row, 580 - depth[3, row] : 580] = 0
    for row in range(100, 450, 100):
        for column in range(100, 550, 100):
            image[row : row + 12, column : column + 12] = 0
    (folder / "map.pgm").write_bytes(b"P5 600 500 255\n" + image.tobytes())
    path = folder / "map.yaml"
    path.write_text("image: map.pgm\nresolution: 0.01\norigin: [0, 0, 0]\n")
    return path


def step_by_part(
    rounds: int, ticks: int, boxes_counts: Sequence[int], robots_counts: Sequence[int]
) -> dict[str, dict[str, float]]:
    """Seconds a tick by part, for every number of boxes and of robots."""
    table: dict[str, dict[str, float]] = {}
    for boxes, robots in [(count, 1) for count in boxes_counts] + [
        (12, count) for count in robots_counts[1:]
    ]:
        pipeline = Pipeline(boxes_world(boxes, robots))
        whole = min(timed(pipeline.step, ticks) for _ in range(rounds))
        parts = Parts(pipeline)
        timed(pipeline.step, ticks)
        shares = {name: spent / ticks for name, spent in parts.shares().items()}
        table[f"{boxes} boxes, {robots} robot{'s' if robots > 1 else ''}"] = {"whole": whole, **shares}
    return table


def camera(rounds: int, sizes: Sequence[tuple[int, int]]) -> dict[str, float]:
    """Seconds an image by size, in env1."""
    robot = open_world("env1", noise="thesis").robots[0]
    found = {}
    for width, height in sizes:
        look = partial(robot.look, width, height)
        timed(look, 1)
        found[f"{width}x{height}"] = min(timed(look, 20 if width < 100 else 1) for _ in range(rounds))
    return found


def compare(rounds: int, ticks: int) -> tuple[dict[str, list[float]], dict[str, float]]:
    """Everything whose ratio has a target, in turns; and single figures that belong to it."""
    twelve = boxes_world(12)
    boxes = [shape for shape in twelve.shapes if isinstance(shape, Box)]
    side = max(box.x for box in boxes)
    with tempfile.TemporaryDirectory() as folder:
        path = ros_map(Path(folder))
        began = time.process_time()
        imported = find_world(path)
        loading = time.process_time() - began
    contenders: dict[str, Tick] = {
        "raw DART, wheels": raw_dart(boxes, "wheels"),
        "raw DART, planar": raw_dart(boxes, "planar"),
        "tolman, wheels": Pipeline(twelve).step,
        "tolman, planar": Pipeline(twelve, "planar").step,
        "tolman, env1": Pipeline(built_in_world("env1")).step,
        "tolman, 1000 boxes": Pipeline(boxes_world(1000)).step,
        "tolman, ROS map": Pipeline(imported).step,
    }
    rival = ir_sim(boxes, side)
    if rival is not None:
        contenders["ir-sim"] = rival
    found = in_turns(contenders, rounds, ticks)
    return found, {"ROS map of 600x500 cells loaded (s)": loading, "its boxes": float(len(imported.shapes))}


def mapping(world: str = "env1") -> dict[str, float]:
    """One mapping of env1 with local maps, from start to sealed file."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        mapped = map_world(MapRequest(world=world, output=Path(folder, "bench.tolman")))
        spent = time.process_time() - began
    return {"processor s": spent, "simulated s": mapped.sim_time_s, "x real time": mapped.sim_time_s / spent}


def targets(figures: dict[str, Any]) -> list[Figure]:
    """What is measured against a target."""
    found, single = figures["in turns (s a tick)"], figures["single figures"]
    parts = figures["by part (s a tick)"]["12 boxes, 1 robot"]
    mapped = figures["mapping env1 with local maps"]
    raw = statistics.median(found["raw DART, wheels"])
    agent, loading = parts["whole"] - parts["physics"], "ROS map of 600x500 cells loaded (s)"
    real_time = CONTROL_PERIOD / statistics.median(found["tolman, wheels"])
    rows = [
        Figure(
            "whole step / raw DART loop, wheels, 12 boxes",
            ratio(found, "tolman, wheels", "raw DART, wheels"),
            "",
            1.6,
        ),
        Figure("1000 boxes / env1", ratio(found, "tolman, 1000 boxes", "tolman, env1"), "", 2.0),
        Figure("ROS map / env1", ratio(found, "tolman, ROS map", "tolman, env1"), "", 2.0),
        Figure("loading a ROS map of 600x500 cells", single[loading], "s", 2.0),
        Figure("agent and sensing / raw DART loop", agent / raw, "", 0.6),
        Figure("agent and sensing / own physics", agent / parts["physics"], "", 0.6),
        Figure("x real time, wheels, 12 boxes", real_time, "", 100.0, True),
    ]
    if "ir-sim" in found:
        for model, least in (("wheels", 2.0), ("planar", 4.0)):
            times = ratio(found, "ir-sim", f"tolman, {model}")
            rows.append(Figure(f"ir-sim / whole step, {model}", times, "", least, True))
    if mapped:
        whole = mapped["x real time"]
        rows += [
            Figure("mapping env1 with local maps: x real time", whole, "", 100.0, True),
            Figure("the same / raw DART loop's x real time", whole / (CONTROL_PERIOD / raw), "", 0.6, True),
            Figure("the same", mapped["processor s"], "s", 30.0),
        ]
    return rows


def show(figures: dict[str, Any]) -> None:
    """Prints the tables."""
    print("Control step by part (us)")
    names = ["whole", *Parts.NAMES]
    print(f"{'':24}" + "".join(f"{name:>16}" for name in names))
    for world, parts in figures["by part (s a tick)"].items():
        print(f"{world:24}" + "".join(f"{parts[name] * 1e6:16.1f}" for name in names))
    print("\nCamera, one image (ms), 16 rays a pixel")
    for size, spent in figures["camera (s an image)"].items():
        print(f"{size:24}{spent * 1e3:16.2f}")
    print("\nIn turns, median of the rounds (us a tick, x real time)")
    for name, times in figures["in turns (s a tick)"].items():
        spent = statistics.median(times)
        print(f"{name:24}{spent * 1e6:16.1f}{CONTROL_PERIOD / spent:16.0f}")
    if "ir-sim" not in figures["in turns (s a tick)"]:
        print("ir-sim is not installed: pip install tolman[bench]")
    print("\nTargets")
    report(targets(figures))


def measure(rounds: int, ticks: int, whole: bool, smoke: bool = False) -> dict[str, Any]:
    """All figures, as JSON can hold them; smoke: only the smallest number or size of each kind."""
    last = 1 if smoke else None
    found, single = compare(rounds, ticks)
    figures: dict[str, Any] = {
        "rounds": rounds,
        "ticks": ticks,
        "in turns (s a tick)": found,
        "single figures": single,
        "by part (s a tick)": step_by_part(rounds, ticks, BOXES[:last], ROBOTS[:last]),
        "camera (s an image)": camera(rounds, CAMERA_SIZES[:last]),
        "mapping env1 with local maps": mapping() if whole else {},
    }
    figures["targets"] = [asdict(figure) | {"reached": figure.reached} for figure in targets(figures)]
    return figures


def main() -> int:
    """Measures, prints and writes. Exit status 0 also where a target is missed: the machine may be busy."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--ticks", type=int, default=400, help="of each contender in each round")
    parser.add_argument("--without-mapping", action="store_true", help="leave the whole mapping of env1 out")
    parser.add_argument("--smoke", action="store_true", help="a few ticks, to see whether it runs at all")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    if options.smoke:
        figures = measure(1, 10, whole=False, smoke=True)
    else:
        figures = measure(options.rounds, options.ticks, not options.without_mapping)
    show(figures)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
