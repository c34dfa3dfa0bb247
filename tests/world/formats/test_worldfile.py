from __future__ import annotations

import json
import math
import time
from importlib import resources
from pathlib import Path

import pytest
import yaml
from tolman.world import Pose, WorldFileError, built_in_world, find_world, open_world
from tolman.world.formats.worldfile import TOP_KEYS, parse_world
from tolman.world.spec import Box, Cylinder, Polygon, Wall

WHOLE = """
tolman-world: 1
name: whole
description: one of everything
room: {size: [2, 2], thickness: 0.04, color: red}
boxes:
  - corners: [[0.2, 0.2], [0.5, 0.4]]
  - {at: [1.0, 1.0], size: [0.2, 0.1], angle: 90, height: 0.2, texture: dots, tile: [0.1, 0.1]}
walls: [{from: [1.5, 0], to: [1.5, 0.5], thickness: 0.03}]
cylinders: [{at: [0.5, 1.5], radius: 0.1, color: [0.1, 0.2, 0.3]}]
polygons: [{points: [[1.2, 1.5], [1.5, 1.5], [1.4, 1.8]]}]
movable: [{at: [0.3, 0.8], size: [0.05, 0.05], mass: 0.02}]
robots: [[1.8, 1.8, 90]]
starts: {here: [0.8, 0.6, 180]}
scenery: {ambient: 0.5, sky: blue}
textures:
  dots: {rows: [[0, 1], [1, 0]]}
  lines: {pattern: stripes, size: [8, 1]}
"""


def test_everything_in_the_format_is_read() -> None:
    spec = parse_world(WHOLE, "whole.yaml", "whole")
    kinds = [type(shape) for shape in spec.shapes]
    assert kinds == [Box] * 4 + [Box, Box, Wall, Cylinder, Polygon]
    assert spec.start("here") == Pose(0.8, 0.6, math.pi)
    assert spec.robots[0].heading == pytest.approx(1.5707963)
    assert spec.movable[0].mass == 0.02
    assert spec.scenery.ambient == 0.5
    assert spec.textures[0].rows == ((0.0, 1.0), (1.0, 0.0))
    world = open_world(spec, noise="none", engine="kinematic")
    world.step()
    assert world.robots[0].look().std() > 0


MINIMAL = "tolman-world: 1\nroom: {size: [1, 1]}\n"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "the file is empty"),
        ("- 1", "f.yaml:1: expected a mapping"),
        ("tolman-world: 1", "needs at least one of room"),
        ("room: {size: [1, 1]}", "'tolman-world' is missing"),
        ("tolman-world: 2\nroom: {size: [1, 1]}", "f.yaml:1: tolman-world: 2 is outside 1 to 1"),
        (MINIMAL + "boxs: []", "f.yaml:3: boxs: unknown key; did you mean 'boxes'"),
        (MINIMAL + "boxes:\n- {at: [1, 1], siz: [1, 1]}", r"f.yaml:4: boxes\[0\].siz: .*did you mean 'size'"),
        (MINIMAL + "boxes:\n- {at: [1, 1]}", r"f.yaml:4: boxes\[0\]: the key 'size' is missing"),
        (
            MINIMAL + "boxes:\n- {at: [1, one], size: [1, 1]}",
            r"boxes\[0\].at\[1\]: .* found 'one'",
        ),
        (MINIMAL + "boxes:\n- {at: [1, .nan], size: [1, 1]}", "expected a number"),
        (MINIMAL + "boxes:\n- {at: [1, 1], size: [1, -1]}", "-1 is outside 0.001 to 1000"),
        (MINIMAL + "boxes:\n- {corners: [[1, 1], [1, 2]]}", "thinner than"),
        (MINIMAL + "boxes:\n- {corners: [[1, 1], [2, 2]], angle: 4}", "goes with 'at'"),
        (MINIMAL + "cylinders:\n- {at: [1, 1], radius: 0.1, color: rod}", "did you mean 'red'"),
        (
            MINIMAL + "cylinders:\n- {at: [1, 1], radius: 0.1, color: [1, 2, 0]}",
            r"color\[1\]: 2 is outside 0 to 1",
        ),
        (MINIMAL + "polygons:\n- {points: [[0, 0], [1, 1]]}", "at least 3 points"),
        (MINIMAL + "starts: {a: [1, 2]}", "starts.a: expected 3 values, found 2"),
        (MINIMAL + "starts: {a: [1, 2, 3], a: [1, 2, 3]}", "appears twice"),
        (MINIMAL + "surfaces: [{texture: nope}]", "no texture is called 'nope'"),
        (MINIMAL + "textures: {a: {pattern: plaid}}", "'plaid' is none of stripes"),
        (MINIMAL + "textures: {a: {file: no.png}}", "only be named"),
        (MINIMAL + "based-on: nowhere", "based on"),
        (MINIMAL + "mirror: perhaps", "expected true or false, found 'perhaps'"),
        (MINIMAL + "name: &a x\ndescription: *a", "f.yaml:4: description: aliases"),
        ("tolman-world: 1\nroom: {size: [1, 1]", "f.yaml:2: not valid YAML|f.yaml:3: not valid YAML"),
        ("a: " + "[" * 80 + "]" * 80, "nested deeper"),
        ("tolman-world: 1\n\troom: 2", "not valid YAML"),
        ("a: 1\n---\nb: 2", "a second document"),
    ],
)
def test_an_error_names_file_line_and_key(text: str, problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem) as caught:
        parse_world(text, "f.yaml", "f")
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("f.yaml")


def test_a_file_on_disk_is_opened_by_its_path_and_scaled(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("tolman-world: 1\nroom: {size: [2, 2]}\n")
    spec = find_world(path, 0.5)
    assert spec.name == "mine"
    assert spec.shapes[1].x == pytest.approx(1.025 - 0.0125 + 0.0)  # type: ignore[union-attr]
    open_world(path, noise="none", engine="kinematic", scale=0.5).step()


def test_a_start_is_chosen_beside_a_wall_when_none_is_given(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("tolman-world: 1\nroom: {size: [2, 2]}\n")
    world = open_world(path, noise="none", engine="kinematic")
    assert world.robots[0].sense().infrared[2] > 300
    left = open_world(path, noise="none", engine="kinematic", start="left")
    assert left.robots[0].sense().infrared[5] > 300


def test_a_bitmap_beside_the_file_is_a_texture(tmp_path: Path) -> None:
    (tmp_path / "dots.pgm").write_bytes(b"P5 2 1 255\n\x00\xff")
    path = tmp_path / "mine.yaml"
    path.write_text("tolman-world: 1\nroom: {size: [2, 2], texture: d}\ntextures: {d: {file: dots.pgm}}\n")
    assert find_world(path).textures[0].rows == ((0.0, 1.0),)


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(WorldFileError, match="not a text file"):
        find_world(path)


def test_the_schema_knows_the_keys_of_the_reader() -> None:
    schema = json.loads(resources.files("tolman.world.formats").joinpath("world.schema.json").read_text())
    assert set(schema["properties"]) == set(TOP_KEYS)
    assert schema["additionalProperties"] is False


def test_a_mirror_swaps_the_sides() -> None:
    plain, mirror = built_in_world("env1"), built_in_world("env1-mirrored")
    assert mirror.start("right").x == pytest.approx(1.0 - plain.start("left").x)
    assert len(mirror.shapes) == len(plain.shapes)


def test_a_large_world_opens_in_at_most_three_times_what_composing_its_yaml_takes(tmp_path: Path) -> None:
    box = "  - {{at: [{0}.3, {1}.3], size: [0.1, 0.1], angle: {0}}}\n"
    boxes = "".join(box.format(number % 60, number // 60) for number in range(3_000))
    text = "tolman-world: 1\nroom: {size: [100, 100]}\nboxes:\n" + boxes
    path = tmp_path / "large.yaml"
    path.write_text(text)
    composing, opening = math.inf, math.inf
    for _ in range(3):
        began = time.process_time()
        yaml.compose(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        composing = min(composing, time.process_time() - began)
        began = time.process_time()
        assert len(find_world(path).shapes) == 3_004
        opening = min(opening, time.process_time() - began)
    assert opening < 3.0 * composing


def test_a_name_holds_no_control_characters() -> None:
    text = 'tolman-world: 1\nname: "a\\x1b[31m\\x07b"\nroom: {size: [1, 1]}\n'
    with pytest.raises(WorldFileError, match=r"f.yaml:2: name: 'a\\x1b\[31m\\x07b' holds control characters"):
        parse_world(text, "f.yaml", "f")
