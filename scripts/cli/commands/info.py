"""`tolman info`: says what a map file holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..command import Command
from ..options import add_json
from ..output import check_input, print_json

if TYPE_CHECKING:
    from ....maps import HybridMap

OF_ARC = ("kind", "side", "distance", "variance", "traversals", "blocked")
"""What is told of each arc, besides its nodes; m."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman info`."""
    parser.add_argument("map", type=Path, metavar="FILE", help="the map")
    add_json(parser)


def summary(hybrid: HybridMap) -> dict[str, Any]:
    """Everything about a map but the contents of its local maps, as JSON values; m and rad."""
    nodes = [
        {
            "node": node,
            **{key: value for key, value in hybrid.graph.nodes[node].items() if key != "local_map"},
            "local_map": hybrid.local_map(node) is not None,
        }
        for node in hybrid.nodes()
    ]
    arcs = [
        {"from": arc.start, "to": arc.end, **{name: getattr(arc, name) for name in OF_ARC}}
        for arc in hybrid.arcs()
    ]
    return {
        "nodes": len(nodes),
        "arcs": len(arcs),
        "local_maps": sum(entry["local_map"] for entry in nodes),
        "loop_closed": hybrid.meta.loop_closed,
        "node_ids": hybrid.nodes(),
        "meta": hybrid.meta.to_json(),
        "node_list": nodes,
        "arc_list": arcs,
    }


def table(values: dict[str, Any], meta: dict[str, Any]) -> str:
    """The same for people: a heading and a line a node with the arcs that leave it."""
    closed = "loop closed" if values["loop_closed"] else "loop not closed"
    lines = [
        f"world {meta['world'] or 'unknown'}, mapped along the {meta['side']} wall; "
        f"profile {meta['profile']}, noise {meta['noise']}, seed {meta['seed']}",
        f"{values['nodes']} nodes, {values['arcs']} arcs, {values['local_maps']} local maps; {closed}; "
        f"the robot is at node {'none' if meta['current_node'] is None else meta['current_node']}",
        "",
        f"{'node':>5} {'name':<12} {'corner':<8} {'local map':<10} arcs",
    ]
    for entry in values["node_list"]:
        leaving = [
            f"{'x' if arc['blocked'] else ''}{arc['kind']} to {arc['to']} ({arc['distance']:.2f} m)"
            for arc in values["arc_list"]
            if arc["from"] == entry["node"]
        ]
        has = "yes" if entry["local_map"] else "no"
        lines.append(
            f"{entry['node']:>5} {entry['name']:<12} {entry['corner']:<8} {has:<10} {', '.join(leaving)}"
        )
    return "\n".join(lines)


def run(options: argparse.Namespace) -> int:
    """Prints what the map holds."""
    check_input(options.map, "map")
    from ....maps import HybridMap

    values = summary(HybridMap.load(options.map))
    if options.json:
        print_json(values)
    else:
        print(table(values, values["meta"]))
    return 0


COMMAND = Command("info", "Says what a map file holds.", add_arguments, run)
