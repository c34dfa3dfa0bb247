"""A whole map as JSON, with a schema, and back."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MapError
from ..fields import ARC, NODE, Arc, Record
from ..hybrid_map import HybridMap
from ..local.content import LocalMapContent
from ..local.local_map import LocalMap
from ..meta import META, MapMeta
from ..som.lattice import frozen
from ..som.som import SOM

JSON_FORMAT = "tolman-map"
JSON_VERSION = 1
MAX_JSON = 2 << 30


def to_json(hybrid: HybridMap) -> dict[str, Any]:
    """The map as plain JSON values, local maps included; `schema` describes them."""
    return {
        "format": JSON_FORMAT,
        "version": JSON_VERSION,
        "meta": hybrid.meta.to_json(),
        "nodes": [_node(hybrid, node) for node in hybrid.nodes()],
        "arcs": [
            {"start": arc.start, "end": arc.end, "kind": arc.kind, **arc.values(), "notes": dict(arc.notes)}
            for arc in hybrid.arcs()
        ],
    }


def from_json(value: Any) -> HybridMap:
    """The inverse of `to_json`. Raises: MapError with one line that says what is wrong."""
    if not isinstance(value, dict) or value.get("format") != JSON_FORMAT:
        raise MapError(f"not a map: the JSON has no format {JSON_FORMAT!r}")
    if value.get("version") != JSON_VERSION:
        raise MapError(f"JSON version {value.get('version')!r}; this program reads version {JSON_VERSION}")
    try:
        hybrid = HybridMap(MapMeta.from_json(value["meta"]))
        for entry in value["nodes"]:
            values = {**entry}
            node, local = values.pop("id"), values.pop("local_map")
            local_map = None if local is None else LocalMap(_content(local))
            hybrid.add_node(node=_integer(node), local_map=local_map, **_complete(NODE, values))
        for entry in value["arcs"]:
            hybrid.put_arc(Arc(*(entry[each.name] for each in ARC.keys), **_complete(ARC, entry)))
    except MapError:
        raise
    except KeyError as error:
        raise MapError(f"the JSON map lacks {error}") from None
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise MapError(f"the JSON map is not well-formed: {error}") from None
    return hybrid


def read_json(path: str | os.PathLike[str]) -> HybridMap:
    """A map from a JSON file. Raises: MapError."""
    source = Path(path)
    try:
        if source.stat().st_size > MAX_JSON:
            raise MapError(f"{source}: {source.stat().st_size} bytes: at most {MAX_JSON}")
        value = json.loads(source.read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise MapError(f"{source}: cannot read: {error.strerror}") from None
    except MapError:
        raise
    except (ValueError, RecursionError) as error:
        raise MapError(f"{source}: no valid JSON: {error}") from None
    try:
        return from_json(value)
    except MapError as error:
        raise MapError(f"{source}: {error}") from None


def _refuse(name: str) -> float:
    raise ValueError(f"{name} is not allowed")


def _complete(record: Record, entry: dict[str, Any]) -> Any:
    """The fields in an entry; those that version 1 of the JSON had must be there. Raises: KeyError."""
    known = {each.name for each in record.keys}
    values = {name: value for name, value in entry.items() if name not in known}
    return {**{each.name: values[each.name] for each in record.fields if each.column}, **values}


def _node(hybrid: HybridMap, node: int) -> dict[str, Any]:
    values = {name: hybrid.graph.nodes[node][name] for name in NODE.by_name}
    local = hybrid.local_map(node)
    return {
        **values,
        "id": node,
        "notes": dict(values["notes"]),
        "local_map": None if local is None else _local(local.content),
    }


def _local(content: LocalMapContent) -> dict[str, Any]:
    positions, panorama = content.view_positions, content.entry_panorama
    return {
        "metric": _som(content.metric),
        "hits": content.hits.tolist(),
        "edges": content.edges.tolist(),
        "blocked": [list(edge) for edge in sorted(content.blocked)],
        "perceptual": None if content.perceptual is None else _som(content.perceptual),
        "view_positions": None
        if positions is None
        else [None if np.isnan(row).any() else row.tolist() for row in positions],
        "view_error": content.view_error,
        "entry_heading": content.entry_heading,
        "entry_panorama": None if panorama is None else panorama.tolist(),
        "locating": content.locating,
    }


def _som(som: SOM) -> dict[str, Any]:
    return {"rows": som.rows, "cols": som.cols, "topology": som.topology, "weights": som.weights.tolist()}


def _content(value: dict[str, Any]) -> LocalMapContent:
    positions, panorama = value["view_positions"], value["entry_panorama"]
    nowhere = [None, None]
    return LocalMapContent(
        metric=_som_back(value["metric"], np.float64),
        hits=frozen(np.array(value["hits"], dtype=np.int64)),
        edges=frozen(np.array(value["edges"], dtype=np.int64).reshape(-1, 2)),
        entry_heading=_number(value["entry_heading"]),
        perceptual=None if value["perceptual"] is None else _som_back(value["perceptual"], np.float32),
        view_positions=None
        if positions is None
        else frozen(np.array([nowhere if row is None else row for row in positions], dtype=np.float64)),
        view_error=_number(value["view_error"]),
        entry_panorama=None if panorama is None else frozen(np.array(panorama, dtype=np.float32)),
        blocked=frozenset((_integer(i), _integer(j)) for i, j in value["blocked"]),
        locating=value["locating"],
    )


def _som_back(value: dict[str, Any], dtype: type[np.floating]) -> SOM:
    rows, cols = _integer(value["rows"]), _integer(value["cols"])
    return SOM(rows, cols, value["topology"], np.array(value["weights"], dtype=dtype))


def _integer(value: Any) -> int:
    if type(value) is not int:
        raise MapError(f"{value!r:.40} where a whole number is expected")
    return value


def _number(value: Any) -> float:
    if type(value) not in (int, float):
        raise MapError(f"{value!r:.40} where a number is expected")
    return float(value)


def schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what `to_json` gives."""
    number, integer = {"type": "number"}, {"type": "integer", "minimum": 0}
    som = _object(
        rows=integer,
        cols=integer,
        topology={"enum": ["hexagonal", "rectangular"]},
        weights=_array(_array(number)),
    )
    pair = {**_array(integer), "minItems": 2, "maxItems": 2}
    place = {**_array(number), "minItems": 2, "maxItems": 2}
    local = _object(
        metric=som,
        hits=_array(integer),
        edges=_array(pair),
        blocked=_array(pair),
        perceptual=_or_null(som),
        view_positions=_or_null(_array(_or_null(place))),
        view_error=number,
        entry_heading=number,
        entry_panorama=_or_null(_array(_array(_array(number)))),
        locating={"enum": ["best", "nearest", "radial"]},
    )
    whole = _object(
        format={"const": JSON_FORMAT},
        version={"const": JSON_VERSION},
        meta=_object(**META.schema()),
        nodes=_array(_object(**NODE.schema(), local_map=_or_null(local))),
        arcs=_array(_object(**ARC.schema())),
    )
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "tolman map", **whole}


def _object(**properties: Any) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": properties,
        "required": sorted(properties),
        "additionalProperties": False,
    }


def _array(items: Any) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _or_null(kind: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [kind, {"type": "null"}]}
