from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
import yaml
from tolman.maps import Comparison, HybridMap, export, merge, read_json
from tolman.maps.errors import MapError, MapFileExistsError
from tolman.maps.formats.json_map import from_json, schema, to_json

from tools.torture.maps import map_made_up_world


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "m.tolman"
    map_made_up_world(path, 3, 5)
    return path


@pytest.fixture
def hybrid(stored: Path) -> HybridMap:
    return HybridMap.load(stored)


def test_json_comes_back_equal_to_the_byte(hybrid: HybridMap, tmp_path: Path) -> None:
    (path,) = export(hybrid, "json", tmp_path / "m.json")
    read_json(path).save(tmp_path / "back.tolman")
    hybrid.save(tmp_path / "there.tolman")
    assert (tmp_path / "back.tolman").read_bytes() == (tmp_path / "there.tolman").read_bytes()


def test_json_fits_its_schema(hybrid: HybridMap) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(schema())
    jsonschema.validate(json.loads(json.dumps(to_json(hybrid))), schema())


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("format",), "x"),
        (("version",), 2),
        (("meta", "seed"), "x"),
        (("nodes", 0, "id"), True),
        (("nodes", 0, "turn"), "1"),
        (("nodes", 0, "local_map", "metric", "rows"), 10**9),
        (("nodes", 0, "local_map", "hits"), [1]),
        (("nodes", 0, "local_map", "edges"), [[3, 2]]),
        (("arcs", 0, "end"), 99),
        (("arcs", 0, "distance"), -1.0),
        (("arcs", 0, "blocked"), 1),
        (("nodes",), None),
    ],
)
def test_json_with_a_wrong_value_is_refused_in_one_line(
    hybrid: HybridMap, keys: tuple[Any, ...], value: Any
) -> None:
    whole = json.loads(json.dumps(to_json(hybrid)))
    part = whole
    for key in keys[:-1]:
        part = part[key]
    part[keys[-1]] = value
    with pytest.raises(MapError) as caught:
        from_json(whole)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"format": NaN}', "[" * 100_000])
def test_text_that_is_no_map_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.json").write_text(text)
    with pytest.raises(MapError) as caught:
        read_json(tmp_path / "m.json")
    assert "\n" not in str(caught.value)


def test_graphml_opens_in_networkx_with_its_values(hybrid: HybridMap, tmp_path: Path) -> None:
    (path,) = export(hybrid, "graphml", tmp_path / "m.graphml")
    graph = nx.read_graphml(path, node_type=int, force_multigraph=True)
    assert sorted(graph) == hybrid.nodes()
    assert graph.number_of_edges() == len(list(hybrid.arcs()))
    assert graph.nodes[1]["turn"] == hybrid.graph.nodes[1]["turn"]


def test_geojson_has_a_point_a_node_and_a_line_a_free_arc(hybrid: HybridMap, tmp_path: Path) -> None:
    hybrid.block(0, 1, "right")
    (path,) = export(hybrid, "geojson", tmp_path / "m.geojson")
    features = json.loads(path.read_text())["features"]
    points = [one for one in features if one["geometry"]["type"] == "Point"]
    lines = [one for one in features if one["geometry"]["type"] == "MultiLineString"]
    assert len(points) == len(hybrid.nodes())
    assert len(lines) == len(list(hybrid.arcs())) - 1
    assert len({one["properties"]["id"] for one in features}) == len(features)
    known = {one["properties"]["id"] for one in points}
    assert all({one["properties"]["startid"], one["properties"]["endid"]} <= known for one in lines)


def test_the_ros_map_is_free_around_visited_units_and_unknown_elsewhere(
    hybrid: HybridMap, tmp_path: Path
) -> None:
    image, sheet = export(hybrid, "ros", tmp_path / "m.yaml")
    about = yaml.safe_load(sheet.read_text())
    assert about["image"] == image.name
    magic, size, depth, data = image.read_bytes().split(b"\n", 3)
    width, height = (int(n) for n in size.split())
    assert (magic, depth, len(data)) == (b"P5", b"255", width * height)
    grid = np.frombuffer(data, dtype=np.uint8).reshape(height, width)
    assert set(np.unique(grid).tolist()) == {205, 254}
    local = hybrid.local_map(0)
    assert local is not None
    turn, unit = local.entry_heading, local.nearest_unit()
    x, y = local.position(unit)
    place = np.array([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)])
    col, row = ((place - about["origin"][:2]) / about["resolution"]).astype(int)
    assert grid[height - 1 - row, col] == 254


def test_without_local_maps_there_is_nothing_to_draw_for_ros(tmp_path: Path) -> None:
    hybrid = HybridMap()
    hybrid.add_node()
    with pytest.raises(MapError, match="no node has a local map"):
        export(hybrid, "ros", tmp_path / "m.yaml")


def test_unknown_formats_name_the_known_and_files_are_not_overwritten(
    hybrid: HybridMap, tmp_path: Path
) -> None:
    with pytest.raises(MapError, match="known: geojson, graphml, json, ros"):
        export(hybrid, "pdf", tmp_path / "m.pdf")
    export(hybrid, "graphml", tmp_path / "m.graphml")
    with pytest.raises(MapFileExistsError):
        export(hybrid, "graphml", tmp_path / "m.graphml")
    export(hybrid, "graphml", tmp_path / "m.graphml", force=True)


@pytest.fixture
def with_a_round_island(hybrid: HybridMap) -> HybridMap:
    """A node without a corner, joined to itself round a pillar and reached by a foray alone."""
    pillar = hybrid.add_node(corner="none", entry_heading=0.4, name="pillar", notes={"place_m": [0.4, 0.3]})
    hybrid.add_arc(pillar, pillar, hybrid.meta.side, 0.44)
    hybrid.add_arc(0, pillar, "right", 0.5, kind="foray", both_ways=False, notes={"crossing": {"turn": 1.5}})
    return hybrid


def test_forays_and_places_without_a_corner_come_back_from_file_and_json(
    with_a_round_island: HybridMap, tmp_path: Path
) -> None:
    expected = list(with_a_round_island.arcs())
    with_a_round_island.save(tmp_path / "m.tolman")
    (path,) = export(with_a_round_island, "json", tmp_path / "m.json")
    for found in (HybridMap.load(tmp_path / "m.tolman"), read_json(path)):
        assert list(found.arcs()) == expected
        assert found.graph.nodes[found.find("pillar")]["corner"] == "none"


def test_exports_place_an_island_where_the_foray_found_it(
    with_a_round_island: HybridMap, tmp_path: Path
) -> None:
    pillar = with_a_round_island.find("pillar")
    (path,) = export(with_a_round_island, "graphml", tmp_path / "m.graphml")
    graph = nx.read_graphml(path, node_type=int, force_multigraph=True)
    assert (graph.nodes[pillar]["x"], graph.nodes[pillar]["y"]) == (0.4, 0.3)
    assert "foray" in graph[0][pillar]
    (path,) = export(with_a_round_island, "geojson", tmp_path / "m.geojson")
    features = json.loads(path.read_text())["features"]
    kinds = [one["properties"]["metadata"].get("kind") for one in features]
    assert kinds.count("foray") == 1
    assert [0.4, 0.3] in [one["geometry"]["coordinates"] for one in features]


def test_two_maps_with_a_round_island_are_merged(with_a_round_island: HybridMap) -> None:
    same = {node: node for node in with_a_round_island.nodes()}
    found = Comparison(same, (), (), (), 0.0, 9.0, 0.0)
    merged = merge(with_a_round_island, with_a_round_island, found)
    pillar = merged.find("pillar")
    assert merged.arc(pillar, pillar, "right").traversals == 2
    assert [arc.kind for arc in merged.leaving(0) if arc.end == pillar] == ["foray"]
    assert merged.graph.number_of_edges() == with_a_round_island.graph.number_of_edges()
