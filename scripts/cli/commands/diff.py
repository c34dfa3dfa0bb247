"""`tolman diff` and `tolman merge`: what two maps of one world have in common, and one map of both."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..command import Command
from ..options import add_force, add_json
from ..output import check_input, check_output, print_json

if TYPE_CHECKING:
    from ....maps import HybridMap
    from ....maps.matching.comparing import Comparison

DIFF = """Compares two maps of the same world: which node is which, nodes that only one has, and arcs whose
distances differ by more than their spread. The maps need not share a start, a side or a frame. Maps
that do not match, or match in more than one way, are refused."""

MERGED = """Joins two maps of the same world into one: the nodes and the frame of A, what B has more, and the
distances that both measured, averaged. Maps that do not match are refused."""


def _add_maps(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("one", type=Path, metavar="A", help="a map")
    parser.add_argument("other", type=Path, metavar="B", help="another map of the same world")


def _loaded(options: argparse.Namespace) -> tuple[HybridMap, HybridMap]:
    for path in (options.one, options.other):
        check_input(path, "map")
    from ....maps import HybridMap

    return HybridMap.load(options.one), HybridMap.load(options.other)


def add_diff_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman diff`."""
    _add_maps(parser)
    add_json(parser)


def add_merge_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options of `tolman merge`."""
    _add_maps(parser)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="C", help="the map to write")
    add_force(parser)


def text(found: Comparison) -> str:
    """A comparison for people."""
    lines = ["A = B: " + ", ".join(f"{one} = {other}" for one, other in sorted(found.matched.items()))]
    for name, nodes in (("A", found.only_one), ("B", found.only_other)):
        if nodes:
            lines.append(f"only in {name}: {', '.join(map(str, nodes))}")
    for arc in found.arcs:
        if arc.differs:
            lines.append(
                f"arc {arc.one[0]} - {arc.one[1]} of A: {arc.distance_one:.3f} m, "
                f"in B ({arc.other[0]} - {arc.other[1]}) {arc.distance_other:.3f} m"
            )
    differing = sum(arc.differs for arc in found.arcs)
    lines.append(f"{len(found.matched)} nodes matched; {differing} of {len(found.arcs)} arcs differ")
    return "\n".join(lines)


def run_diff(options: argparse.Namespace) -> int:
    """Compares and prints."""
    one, other = _loaded(options)
    from ....maps.matching.comparing import compare

    found = compare(one, other)
    if options.json:
        print_json(found.to_json())
    else:
        print(text(found))
    return 0


def run_merge(options: argparse.Namespace) -> int:
    """Merges and says what came of it."""
    one, other = _loaded(options)
    check_output(options.output, replace=options.force)
    from ....maps.matching.merging import merge

    merged = merge(one, other)
    merged.save(options.output, force=options.force)
    graph = merged.graph
    print(f"{options.output}: {graph.number_of_nodes()} nodes, {graph.number_of_edges()} arcs")
    return 0


COMMAND = Command("diff", DIFF, add_diff_arguments, run_diff)
MERGE = Command("merge", MERGED, add_merge_arguments, run_merge)
