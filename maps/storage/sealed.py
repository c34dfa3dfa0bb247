"""Whole maps to sealed files and back: what `HybridMap.save` and `load` do."""

from __future__ import annotations

import os
from pathlib import Path

import networkx as nx

from ..errors import MapError, MapFileDamagedError, MapFileError
from ..hybrid_map import HybridMap
from ..meta import MapMeta
from .graph import put_arc, put_meta, put_node, read_graph
from .reader import reading
from .unpacking import StoredLocalMaps
from .writer import drafting

AnyPath = str | os.PathLike[str]


class SealedFiles:
    """Reads and writes sealed map files."""

    def write(self, path: AnyPath, meta: MapMeta, graph: nx.MultiDiGraph[int], force: bool = False) -> None:
        """Writes one sealed file: same content, same bytes. What it writes has been read back before.

        Raises: MapFileExistsError, MapFileError; MapError for a graph that could not be loaded again.
        """
        target = Path(path)
        if not isinstance(graph, nx.MultiDiGraph):
            raise MapError(f"{target}: not saved: the graph is a {type(graph).__name__}, not a MultiDiGraph")
        try:
            with drafting(target, force) as writer:
                put_meta(writer, meta)
                for node in sorted(graph, key=_order):
                    put_node(writer, graph, node)
                for key in sorted(graph.edges(keys=True), key=lambda key: [*map(_order, key)]):
                    put_arc(writer, graph, key)
                writer.finish()
                read_graph(writer.connection, StoredLocalMaps(target))
        except MapError as error:
            if isinstance(error, MapFileError) and not isinstance(error, MapFileDamagedError):
                raise
            raise MapError(f"{target}: not saved: {error}") from None

    def read(self, path: AnyPath) -> tuple[MapMeta, nx.MultiDiGraph[int]]:
        """Meta and graph of a map file; local maps are read and verified when they are first used.

        Raises: MapFileError, MapFileDamagedError.
        """
        target = Path(path)
        with reading(target) as connection:
            connection.execute("BEGIN")
            return read_graph(connection, StoredLocalMaps(target))


def _order(part: object) -> tuple[bool, str, object]:
    """Orders node numbers by size, and after them whatever else may stand in a graph, to be refused."""
    return (False, "", part) if type(part) is int else (True, type(part).__name__, str(part))


HybridMap.storage = SealedFiles()
