"""Fields of nodes and arcs are declared once; all that stores, checks or exports them follows from that."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tolman.maps.fields import ARC, NODE, Field
from tolman.maps.meta import META

ROOT = Path(__file__).parents[2]
LINE = '    notes: Annotated[Mapping[str, Any], Field("notes", default={}, column=1)]\n'
ADDED = '    visits: Annotated[int, Field("integer", low=0, high=99, default=0, route=True)]\n'
SCRIPT = """
import json, sys
import networkx as nx
from tolman.maps import HybridMap, MapError, export, read_json, validate
from tolman.maps.formats.json_map import schema, to_json

hybrid = HybridMap.load(sys.argv[1])
assert {hybrid.graph.nodes[node]["visits"] for node in hybrid.nodes()} == {0}
hybrid.add_node(visits=7)
try:
    hybrid.add_node(visits=100)
except MapError as error:
    print(error)
new = hybrid.nodes()[-1]
hybrid.save("new.tolman")
assert validate("new.tolman").valid
loaded = HybridMap.load("new.tolman")
for form in ("json", "graphml", "geojson"):
    export(loaded, form, f"m.{form}")
points = [one["properties"] for one in json.load(open("m.geojson"))["features"]]
print(json.dumps({
    "loaded": loaded.graph.nodes[new]["visits"],
    "notes": loaded.graph.nodes[new]["notes"],
    "json": read_json("m.json").graph.nodes[new]["visits"],
    "graphml": nx.read_graphml("m.graphml", node_type=int, force_multigraph=True).nodes[new]["visits"],
    "geojson": next(one for one in points if one["id"] == new)["metadata"]["visits"],
    "schema": schema()["properties"]["nodes"]["items"]["properties"]["visits"],
}))
"""


def test_a_field_added_in_one_line_is_checked_stored_loaded_and_exported(tmp_path: Path) -> None:
    package = tmp_path / "tolman"
    package.mkdir()
    (package / "__init__.py").touch()
    for floor in ("files", "world"):
        (package / floor).symlink_to(ROOT / floor)
    shutil.copytree(ROOT / "maps", package / "maps")
    fields = package / "maps" / "fields.py"
    declared = fields.read_text()
    assert LINE in declared
    fields.write_text(declared.replace(LINE, ADDED + LINE))
    golden = Path(__file__).parent / "storage" / "data" / "version1.tolman"
    ran = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(golden)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    refused, found = ran.stdout.splitlines()
    assert refused.endswith("visits = 100: expected a whole number from 0 to 99")
    assert json.loads(found) == {
        "loaded": 7,
        "notes": {},
        "json": 7,
        "graphml": 7,
        "geojson": 7,
        "schema": {"type": "integer", "minimum": 0, "maximum": 99},
    }


@pytest.mark.parametrize(
    ("field", "value", "kept"),
    [
        (Field("real", low=0, high=5), np.float32(0.5), 0.5),
        (Field("real", low=0, high=5), 3, 3.0),
        (Field("integer"), np.int64(7), 7),
        (Field("text", empty=True), None, None),
        (Field("scalars"), {"a": 1.5, "b": None}, {"a": 1.5, "b": None}),
    ],
)
def test_values_are_kept_as_plain_python(field: Field, value: object, kept: object) -> None:
    found = field.clean(value)
    assert (found, type(found)) == (kept, type(kept))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        (Field("real"), math.nan),
        (Field("real"), math.inf),
        (Field("real"), True),
        (Field("real"), 10**400),
        (Field("real", high=5), 5.1),
        (Field("integer"), 7.0),
        (Field("flag"), 1),
        (Field("text"), "a\nb"),
        (Field("text"), "\ud800"),
        (Field("text", shortest=1), ""),
        (Field("text", choices=("right", "left")), "up"),
        (Field("text"), None),
        (Field("notes"), [1]),
        (Field("scalars"), {"a": [1]}),
    ],
)
def test_values_of_another_type_or_beyond_the_range_are_refused(field: Field, value: object) -> None:
    with pytest.raises(ValueError, match=r"expected "):
        field.clean(value)


def test_a_message_names_the_node_or_arc_and_what_is_expected() -> None:
    with pytest.raises(
        ValueError, match=r"^node 3: turn = 'x': expected a number in rad from -10000 to 10000$"
    ):
        NODE.clean((3,), {"name": "n3", "turn": "x"})
    with pytest.raises(ValueError, match=r"^arc 0 -> 1 \(right\): it has no side$"):
        ARC.clean((0, 1, "right"), {"distance": 1.0})
    with pytest.raises(ValueError, match=r"^node 3: unknown field 'color'; known: name, corner"):
        NODE.clean((3,), {"name": "n3", "color": "red"})


def test_every_field_has_a_default_that_it_would_keep_or_none() -> None:
    for record in (NODE, ARC, META):
        for each in record.fields:
            assert each.default is ... or each.clean(each.default) == each.default
