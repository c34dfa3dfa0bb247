"""Measures the house: widest room, longest chain of imports, circles, lines; `python -m tools.structure`.

Reads the source as text and runs none of it. A chain counts modules that import one another when they are
loaded: imports at the top of a file, not those for type checkers or within functions. Circles count all.
"""

from __future__ import annotations

import argparse
import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import networkx as nx

ROOT = Path(__file__).resolve().parent.parent
FLOORS = ("files", "world", "maps", "agent", "behaviors", "plugins", "scripts")
"""The folders of the package, lowest first."""
MOST_MODULES, MOST_CHAIN = 14, 14


@dataclass(frozen=True)
class House:
    """The modules of the package, by dotted name below `tolman`, and what each imports.

    loaded: when it is loaded itself. all: also for type checkers and within functions.
    """

    files: Mapping[str, Path]
    loaded: Mapping[str, frozenset[str]]
    all: Mapping[str, frozenset[str]]

    @classmethod
    def read(cls, root: Path = ROOT) -> House:
        """Reads the package's folders below `root`."""
        files = {}
        for floor in FLOORS:
            for path in sorted((root / floor).rglob("*.py")):
                parts = path.relative_to(root).with_suffix("").parts
                if parts[:2] != ("scripts", "missions"):  # examples, loaded by path
                    files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
        edges = {name: tuple(_imports(name, path, files)) for name, path in files.items()}
        loaded = {name: frozenset(to for to, at_load in found if at_load) for name, found in edges.items()}
        every = {name: frozenset(to for to, _ in found) for name, found in edges.items()}
        return cls(files, loaded, every)

    @cached_property
    def chain(self) -> tuple[str, ...]:
        """The longest chain of modules of which each loads the next; circles count once."""
        folded = nx.condensation(nx.DiGraph({name: sorted(self.loaded[name]) for name in sorted(self.files)}))
        return tuple(min(folded.nodes[each]["members"]) for each in nx.dag_longest_path(folded))

    def circles(self, rooms: bool = False) -> list[tuple[str, ...]]:
        """Modules (or rooms) that import one another, for type checkers too: each circle's members."""
        graph = nx.DiGraph()
        for name, imported in self.all.items():
            for to in imported:
                graph.add_edge(self._room(name) if rooms else name, self._room(to) if rooms else to)
        return sorted(
            tuple(sorted(each)) for each in nx.strongly_connected_components(graph) if len(each) > 1
        )

    def _room(self, name: str) -> str:
        """The folder two below the root that a module is in, or itself where it stands on its floor."""
        parts = name.split(".")
        inside = len(parts) > 2 or self.files[name].name == "__init__.py"
        return ".".join(parts[:2]) if inside else name

    def widths(self) -> dict[str, int]:
        """Modules in each folder, `__init__` not counted."""
        found: dict[str, int] = {}
        for path in self.files.values():
            if path.name not in ("__init__.py", "__main__.py"):
                found[str(path.parent)] = found.get(str(path.parent), 0) + 1
        return found

    def lines(self) -> dict[str, int]:
        """Lines of Python in each floor."""
        found: dict[str, int] = {}
        for name, path in self.files.items():
            floor = name.partition(".")[0]
            found[floor] = found.get(floor, 0) + len(path.read_text(encoding="utf-8").splitlines())
        return found


def _imports(name: str, path: Path, files: Mapping[str, Path]) -> Iterator[tuple[str, bool]]:
    """Modules of the package that a module imports, and whether when it is loaded."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    later = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) or _is_for_type_checkers(node)
        for inner in ast.walk(node)
    }
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom):
            continue
        if node.level:
            place = package[: len(package) + 1 - node.level]
            base = ".".join([*place, *([node.module] if node.module else [])])
        else:
            base = (node.module or "").removeprefix("tolman").lstrip(".")
            if not (node.module or "").startswith("tolman"):
                continue
        for alias in node.names:
            for target in (f"{base}.{alias.name}".lstrip("."), base):
                if target in files and target != name:
                    yield target, id(node) not in later
                    break


def _is_for_type_checkers(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)


def main() -> None:
    """Prints the measures."""
    parser = argparse.ArgumentParser(prog="python -m tools.structure", description=__doc__)
    parser.add_argument("--within", metavar="PLACE", help="print the longest chain within this floor or room")
    options = parser.parse_args()
    house = House.read()
    if options.within:
        inside = {name for name in house.files if f"{name}.".startswith(f"{options.within}.")}
        kept = {name: house.loaded[name] & inside for name in inside}
        house = House({name: house.files[name] for name in inside}, kept, kept)
    print(f"longest chain: {len(house.chain)}\n  " + "\n  ".join(house.chain))
    for kind, rooms in (("circles of modules", False), ("circles of rooms", True)):
        found = house.circles(rooms)
        print(f"{kind}: {len(found)}", *(f"\n  {' '.join(circle)}" for circle in found), sep="")
    wide = sorted(((count, folder) for folder, count in house.widths().items()), reverse=True)[:5]
    print("widest folders:", ", ".join(f"{Path(folder).relative_to(ROOT)} {count}" for count, folder in wide))
    lines = house.lines()
    print(
        "lines:",
        ", ".join(f"{floor} {count}" for floor, count in lines.items()),
        "| all",
        sum(lines.values()),
    )


if __name__ == "__main__":
    main()
