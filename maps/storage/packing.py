"""Local maps to a JSON manifest and the bytes of their arrays: see docs/format.md."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MapFileDamagedError
from .values import dump_json, parse_object

if TYPE_CHECKING:
    from ..local.content import LocalMapContent
    from ..som.som import SOM


def pack_local_map(content: LocalMapContent) -> tuple[str, bytes]:
    """A local map as JSON manifest and the bytes of its tensors, one after another."""
    tensors: dict[str, NDArray[Any]] = {
        "metric": content.metric.weights.astype(np.float64),
        "hits": content.hits.astype(np.int32),
        "edges": content.edges.astype(np.int32).reshape(-1, 2),
        "blocked": np.array(sorted(content.blocked), dtype=np.int32).reshape(-1, 2),
    }
    if content.perceptual is not None and content.view_positions is not None:
        tensors["perceptual"] = content.perceptual.weights
        tensors["view_positions"] = content.view_positions.astype(np.float64)
    if content.entry_panorama is not None:
        tensors["entry_panorama"] = content.entry_panorama.astype(np.float32)
    data = b"".join(np.ascontiguousarray(t, t.dtype.newbyteorder("<")).tobytes() for t in tensors.values())
    manifest = {
        "metric": _shape(content.metric),
        "perceptual": None if content.perceptual is None else _shape(content.perceptual),
        "entry_heading": content.entry_heading,
        "view_error": content.view_error,
        "locating": content.locating,
        "tensors": [
            [name, f"{t.dtype.kind}{t.dtype.itemsize}", list(t.shape)] for name, t in tensors.items()
        ],
        "bytes": len(data),
        "hash": hashlib.blake2b(data, digest_size=16).hexdigest(),
    }
    return dump_json(manifest, "a local map's manifest"), data


def _shape(som: SOM) -> list[Any]:
    return [som.rows, som.cols, som.topology]


def check_manifest(manifest: str, data: bytes, where: str) -> dict[str, Any]:
    """The manifest of bytes, whose length and hash it must tell. Raises: MapFileDamagedError."""
    about = parse_object(manifest, f"{where}: the local map's manifest")
    if (len(data), hashlib.blake2b(data, digest_size=16).hexdigest()) != (
        about.get("bytes"),
        about.get("hash"),
    ):
        raise MapFileDamagedError(f"{where}: the local map's bytes do not match their checksum")
    return about
