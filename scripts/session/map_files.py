"""A mapping kept in its file, node by node, with all that lets a killed one go on exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...maps.storage.map_file import MapFile
from ..errors import SessionError

if TYPE_CHECKING:
    from types import TracebackType

    from ...agent.mapping.base import ArcKey
    from ...maps.meta import MapMeta
    from .requests import MapRequest


class MapWriter:
    """One mapping's hold on its map file. Use it as a context manager: the file is sealed at its end.

    map: the map so far, empty for a new file. state: what to go on from, None for a mapping that begins.
    committed: the last node that is complete. States and truths are JSON values.
    """

    def __init__(self, file: MapFile, resumed: bool) -> None:
        """Not to be called: see `open`."""
        self.map = file.map
        self.state: Any = file.state if resumed else None
        self.committed: int | None = None
        self._file = file

    @classmethod
    def open(cls, path: Path, request: MapRequest, meta: MapMeta) -> MapWriter:
        """A new file for a map that says `meta` of itself, or one to go on with, as the request says.

        Raises: MapError, SessionError.
        """
        if not request.resume:
            return cls(MapFile.create(path, meta, force=request.force), resumed=False)
        file = MapFile.resume(path)
        why = _why_not_resumed(file.map.meta, meta)
        if why:
            file.seal()
            raise SessionError(f"{path}: {why}")
        return cls(file, resumed=True)

    def __enter__(self) -> MapWriter:
        """The writer itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Seals the file, or just closes it when the block raises: then it can be resumed."""
        self._file.__exit__(kind, error, trace)

    def commit(self, node: int, state: dict[str, Any], truth: Mapping[int, Any]) -> None:
        """Saves a complete node with all that a resumed run needs; it is on disk when this returns."""
        nodes = [node] if self.committed is None else [self.committed, node]
        graph = self.map.graph
        arcs = [*graph.in_edges(node, keys=True), *graph.out_edges(node, keys=True)]
        self._file.update(self.map, nodes, arcs, state=state, truth=truth)
        self.committed = node

    def rest(
        self, nodes: Sequence[int], arcs: Sequence[ArcKey], state: dict[str, Any], truth: Mapping[int, Any]
    ) -> None:
        """Saves what changed while no node was added; those nodes and arcs are forgotten."""
        graph = self.map.graph
        if self.committed is not None and self.committed in graph:
            nodes = [*nodes, self.committed]
        self._file.update(self.map, nodes, [*arcs, *graph.edges(keys=True)], state=state, truth=truth)

    def finish(self, truth: Mapping[int, Any]) -> None:
        """Saves the whole map as it is, and seals the file."""
        graph = self.map.graph
        self._file.update(self.map, list(graph), list(graph.edges(keys=True)), truth=truth)
        self._file.seal()


def _why_not_resumed(begun: MapMeta, asked: MapMeta) -> str:
    """What keeps a map from being gone on with as asked; nothing if it can be."""
    if begun.loop_closed:
        return "this mapping is complete, its loop is closed; --force begins a new one"
    if begun.world_digest != asked.world_digest:
        return f"a map of {begun.world}, not of {asked.world}: cannot be resumed there"
    islands = asked.scalars.get("islands")
    if begun.scalars.get("islands") != islands:
        return f"begun with{'out' if islands else ''} --islands: resume it in the same way"
    for name in ("side", "seed", "noise", "profile"):
        then, now = getattr(begun, name), getattr(asked, name)
        if then != now:
            return f"begun with --{name} {then}, not {now}: resume it with the same"
    for name in ("noise_scale", "robot_model"):
        then, now = begun.scalars.get(name), asked.scalars.get(name)
        if then != now:
            return f"begun with --{name.replace('_', '-')} {then}, not {now}: resume it with the same"
    return ""
