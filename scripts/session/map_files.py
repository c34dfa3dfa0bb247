"""A mapping kept in its file, node by node, with all that lets a killed one go on exactly."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...maps.storage.map_file import RUN, MapFile
from ..errors import SessionError
from ..plain import plain
from .truth import node_truth, run_truth

if TYPE_CHECKING:
    from types import TracebackType

    from ...agent.mapping.base import ArcKey
    from ...maps.meta import MapMeta
    from .mapping import Mapping
    from .requests import MapRequest


class MapWriter:
    """One mapping's hold on its map file. Use it as a context manager: the file is sealed at its end.

    map: the map so far, empty for a new file. resumes: whether there is something to go on from.
    """

    def __init__(self, file: MapFile, resumed: bool) -> None:
        """Not to be called: see `open`."""
        self.map = file.map
        self.resumes = resumed and file.state is not None
        self._file = file
        self._committed: int | None = None

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

    def commit(self, mapping: Mapping, node: int) -> None:
        """Saves a complete node with all that a resumed run needs; it is on disk when this returns."""
        nodes = [node] if self._committed is None else [self._committed, node]
        graph, observer = mapping.map.graph, mapping.observer
        arcs = [*graph.in_edges(node, keys=True), *graph.out_edges(node, keys=True)]
        truth = {node: plain(node_truth(observer.nodes[node], observer.track)), RUN: _run(mapping)}
        self._file.update(mapping.map, nodes, arcs, state=plain(_state(mapping)), truth=truth)
        self._committed = node
        observer.track = []

    def rest(self, mapping: Mapping, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Saves what changed while no node was added; those nodes and arcs are forgotten."""
        graph = mapping.map.graph
        if self._committed is not None and self._committed in graph:
            nodes = [*nodes, self._committed]
        state = {**_state(mapping), "track": mapping.observer.track}
        every = [*arcs, *graph.edges(keys=True)]
        self._file.update(mapping.map, nodes, every, state=plain(state), truth={RUN: _run(mapping)})

    def finish(self, mapping: Mapping) -> None:
        """Saves the whole map as it is, and seals the file."""
        graph = mapping.map.graph
        arcs = list(graph.edges(keys=True))
        self._file.update(mapping.map, list(graph), arcs, truth={RUN: _run(mapping)})
        self._file.seal()

    def restore(self, mapping: Mapping) -> None:
        """Takes everything back to when the last node was committed, to the bit. Raises: SessionError."""
        state: Any = self._file.state
        try:
            mapping.stage.world.restore(state["world"])
            mapping.mapper.restore(state["mapper"])
            mapping.agent.odometry.restore(state["odometry"])
            mapping.observer.restore(state)
            mapping.agent.driver = state["driver"]
            mapping.loop_correct = state.get("loop_correct")
        except (TypeError, ValueError, LookupError, AttributeError) as fault:
            problem = "its run was kept by another version of tolman; map it afresh, with --force"
            raise SessionError(f"{self._file.path}: {problem}") from fault
        self._committed = mapping.mapper.current


def _run(mapping: Mapping) -> dict[str, Any]:
    values: dict[str, Any] = plain(run_truth(mapping.observer.track, mapping.observer.pose))
    return values


def _state(mapping: Mapping) -> dict[str, Any]:
    loop_correct = mapping.loop_correct
    return {
        "mapper": mapping.mapper.state(),
        "odometry": mapping.agent.odometry.state(),
        **mapping.observer.state(),
        "driver": mapping.agent.driver,
        **({} if loop_correct is None else {"loop_correct": loop_correct}),
        "world": dict(mapping.stage.world.state()),
    }


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
