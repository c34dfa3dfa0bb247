from __future__ import annotations

import math
import os
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tolman.world import WorldFileError, WorldWarning, find_world, open_world
from tolman.world.formats.bitmaps import parse_bitmap
from tolman.world.formats.maze import parse_maze
from tolman.world.formats.rosmap import free_cells, largest_area
from tolman.world.formats.webots import parse_webots
from tolman.world.geometry import Plan
from tolman.world.spec import Box

MAZE = """\
o---o---o---o
|       |   |
o   o---o   o
|   |       |
o   o   o---o
| S |     G |
o---o---o---o
"""

WEBOTS = """#VRML_SIM R2023b utf8
EXTERNPROTO "https://example.org/RectangleArena.proto"
WorldInfo { basicTimeStep 32 }
RectangleArena { floorSize 1.5 1.2 }
WoodenBox { translation 0.3 0.2 0.05 size 0.2 0.1 0.1 rotation 0 0 1 0.5 }
DEF PILLAR Solid {
  translation -0.4 0.1 0.05
  children [ Shape { geometry Cylinder { radius 0.08 height 0.1 } } ]
}
Wall { translation 0 -0.4 0 size 0.02 0.2 0.3 }
WoodenBox { translation 0 0 1 size 0.1 0.1 0.1 }
Robot { name "other" }
E-puck { translation 0 0.3 0 rotation 0 0 1 1.57 }
"""


def write_map(folder: Path, pixels: NDArray[np.int64], **keys: object) -> Path:
    height, width = pixels.shape
    (folder / "map.pgm").write_bytes(
        b"P5\n# made\n%d %d\n255\n" % (width, height) + pixels.astype(np.uint8).tobytes()
    )
    values = {"image": "map.pgm", "resolution": 0.02, "origin": "[-1, -2, 0]", **keys}
    path = folder / "map.yaml"
    path.write_text("".join(f"{key}: {value}\n" for key, value in values.items()))
    return path


def drawn_room() -> NDArray[np.int64]:
    """A 1.2 x 0.8 m room (2 cm cells) with one block, in the middle of unknown cells."""
    image = np.full((80, 100), 205)
    image[20:62, 20:82] = 0
    image[21:61, 21:81] = 254
    image[21:41, 45:55] = 0
    return image


def test_a_ros_map_becomes_a_few_walls_where_it_says(tmp_path: Path) -> None:
    spec = find_world(write_map(tmp_path, drawn_room(), free_thresh=0.25))
    plan = Plan(spec.shapes)
    assert len(spec.shapes) <= 9
    low_x, low_y = -1 + 21 * 0.02, -2 + (80 - 61) * 0.02
    assert plan.clearance(low_x + 0.1, low_y + 0.2) == pytest.approx(0.1, abs=1e-9)
    assert plan.contains(-1 + 50 * 0.02, -2 + (80 - 30) * 0.02)
    world = open_world(spec, noise="none")
    world.step()
    assert world.robots[0].sense().infrared[2] > 300


def test_a_map_for_a_larger_robot_is_scaled(tmp_path: Path) -> None:
    path = write_map(tmp_path, drawn_room(), resolution=0.2)
    x0, _, x1, _ = Plan(find_world(path, 0.1).shapes).bounds
    assert x1 - x0 == pytest.approx(1.2 + 2 * 0.02)


def test_a_turned_origin_turns_the_map(tmp_path: Path) -> None:
    turned = find_world(write_map(tmp_path, drawn_room(), origin=f"[0, 0, {math.pi / 2}]"))
    x0, y0, x1, y1 = Plan(turned.shapes).bounds
    assert (x1 - x0, y1 - y0) == pytest.approx((0.84, 1.24))
    assert x1 < 0 < y0


def test_modes_thresholds_and_negation_are_honored() -> None:
    image = np.array([[0, 100, 180, 206, 255]]) / 255
    assert free_cells(image, "trinary", 0.65, 0.196, False).tolist() == [[False, False, False, True, True]]
    assert free_cells(image, "trinary", 0.65, 0.4, False).tolist() == [[False, False, True, True, True]]
    assert free_cells(image, "trinary", 0.65, 0.196, True).tolist() == [[True, False, False, False, False]]
    assert free_cells(image, "scale", 0.9, 0.1, False).tolist() == [[False, False, True, True, True]]
    assert free_cells(image, "raw", 0.65, 0.2, False).tolist() == [[True, False, False, False, False]]


def test_only_the_largest_area_is_kept_and_diagonals_do_not_join() -> None:
    free = np.array([[1, 1, 0, 1], [0, 0, 1, 0], [1, 0, 1, 1], [1, 1, 1, 0]], dtype=bool)
    area = largest_area(free)
    assert area.sum() == 7
    assert not area[0].any()


def test_a_large_noisy_map_becomes_far_fewer_walls_than_cells(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    image = np.full((500, 600), 205)
    image[50:450, 50:550] = 254
    image[50:450:40, 50:550] = np.where(random.random((10, 500)) < 0.4, 0, 254)
    spec = find_world(write_map(tmp_path, image, resolution=0.05))
    assert len(spec.shapes) < 4000


def test_a_passage_narrower_than_a_robot_alone_is_no_room(tmp_path: Path) -> None:
    image = np.full((60, 60), 0)
    image[30:33, 5:55] = 254
    with pytest.raises(WorldFileError, match="wide enough"):
        find_world(write_map(tmp_path, image, resolution=0.01))


def test_a_map_of_noise_is_refused_before_it_takes_long(tmp_path: Path) -> None:
    image = np.where(np.random.default_rng(0).random((900, 900)) < 0.3, 0, 254)
    with pytest.raises(WorldFileError, match="the limit is"):
        find_world(write_map(tmp_path, image, resolution=0.05))


def test_a_start_lies_in_the_room_also_where_its_walls_stand_around_a_place_outside(tmp_path: Path) -> None:
    """A corridor of 20 cm round a closed court of 1 m, whose walls are longer than the corridor is wide."""
    image = np.full((80, 80), 205)
    image[5:75, 5:75] = 254
    image[15:65, 15:65] = 0
    spec = find_world(write_map(tmp_path, image, free_thresh=0.25))
    for start in spec.starts:
        assert not (-1 + 0.3 < start.pose.x < -1 + 1.3 and -2 + 0.3 < start.pose.y < -2 + 1.3)


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ({"image": "gone.pgm"}, r"map.yaml:1: image: .*gone.pgm: there is no such file"),
        ({"resolution": 0}, "map.yaml:2: resolution"),
        ({"origin": "[0, 0]"}, "map.yaml:3: origin: expected 3 values"),
        ({"mode": "trinay"}, "did you mean 'trinary'"),
        ({"free_tresh": 0.2}, "did you mean 'free_thresh'"),
        ({"free_thresh": 0.9}, "above occupied_thresh"),
        ({"resolution": 0.001}, "is the scale right"),
        ({"resolution": 0.0002}, "is the scale right"),
    ],
)
def test_a_wrong_map_is_explained(tmp_path: Path, keys: dict[str, object], problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem):
        find_world(write_map(tmp_path, drawn_room(), **keys))


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"GIF89a", "neither"),
        (b"P5 2 2 255\n\x00", "1 pixels, 4 expected"),
        (b"P5 99999 99999 255\n", "more than the limit"),
        (b"P2 2 1 255 1 x", "not a number"),
        (b"P5 2", "header is damaged"),
        (b"P5 2 2 0\n\x00\x00\x00\x00", "makes no sense"),
        (b"\x89PNG\r\n\x1a\n rest", "damaged PNG"),
    ],
)
def test_a_damaged_image_is_explained(data: bytes, problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem):
        parse_bitmap(data, "map.pgm")


def test_all_kinds_of_pgm_read_the_same() -> None:
    plain = parse_bitmap(b"P2\n# c\n2 1\n# d\n255\n0 255\n", "a").gray
    raw = parse_bitmap(b"P5 2 1 255 \x00\xff", "a").gray
    wide = parse_bitmap(b"P5 2 1 65535\n\x00\x00\xff\xff", "a").gray
    assert plain.tolist() == raw.tolist() == wide.tolist() == [[0.0, 1.0]]


def test_a_maze_has_its_walls_where_they_are_drawn(tmp_path: Path) -> None:
    path = tmp_path / "maze.txt"
    path.write_text(MAZE)
    spec = find_world(path)
    plan = Plan(spec.shapes)
    for x, y in ((0.18, 0.09), (0.27, 0.36), (0.36, 0.45), (0.45, 0.18), (0.0, 0.3)):
        assert plan.contains(x, y), (x, y)
    for x, y in ((0.09, 0.18), (0.09, 0.36), (0.27, 0.18), (0.36, 0.27), (0.18, 0.45)):
        assert plan.clearance(x, y) > 0.02, (x, y)
    start = open_world(path, noise="none", engine="kinematic").true_pose()
    assert 0 < start.x < 0.18
    assert start.y < 0.36


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "0 lines"),
        ("+---+\n|   |\n", "2 lines"),
        ("+--+\n|  |\n+--+", "m.txt:1: 4 characters"),
        ("+---+\n|   |\n+-x-+", "m.txt:3: '-x-' is neither"),
        ("+---+\nx   |\n+---+", "m.txt:2: 'x' is neither"),
        ("+---+\n|   |  |\n+---+", "m.txt:2: 8 characters"),
        ("+---+\n|   |\n----+", "no post at character 1"),
        ("+   +\n     \n+   +", "no place beside a wall"),
    ],
)
def test_a_wrong_maze_is_explained(text: str, problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem):
        parse_maze(text, "m.txt", "m")


def test_a_webots_world_is_taken_over_with_a_warning_for_the_rest(tmp_path: Path) -> None:
    path = tmp_path / "arena.wbt"
    path.write_text(WEBOTS)
    with pytest.warns(WorldWarning, match=r"skipped: 1 Robot, 1 box \(off the floor\)"):
        spec = find_world(path)
    plan = Plan(spec.shapes)
    assert len(spec.shapes) == 4 + 3
    assert plan.clearance(0.0, 0.55) == pytest.approx(0.05)
    assert plan.contains(0.3, 0.2)
    assert plan.clearance(-0.4, 0.25) == pytest.approx(0.07, abs=1e-3)
    assert plan.contains(0.0, -0.31)
    assert spec.starts[0].name == "robot"
    assert spec.starts[0].pose.heading == pytest.approx(1.57)
    assert {start.name for start in spec.starts} == {"robot", "right", "left"}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "does not begin"),
        ("#VRML_SIM R2023b utf8\n", "no arena"),
        (
            "#VRML_SIM R2023b utf8\nWoodenBox {\n size 1 1\n}",
            "w.wbt: line 2: WoodenBox.size: .*3 numbers",
        ),
        ("#VRML_SIM R2023b utf8\nWoodenBox {\n size 1 1 1", "w.wbt:3: expected"),
        (
            '#VRML_SIM R2023b utf8\nWorldInfo { coordinateSystem "NUE" }',
            "w.wbt:2: a world whose z is not up; save it with z up",
        ),
        ("#VRML_SIM R2023b utf8\nUSE A", "no DEF names"),
        ("#VRML_SIM R2023b utf8\n" + "Group { children [ " * 60, "nested deeper"),
        ("#VRML_SIM R2023b utf8\n?", "w.wbt:2: unexpected"),
        ("#VRML_SIM R2023b utf8\nWoodenBox { size 1 0 1 }", "is no box"),
    ],
)
def test_a_wrong_webots_world_is_explained(text: str, problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem):
        parse_webots(text, "w.wbt", "w")


@pytest.mark.parametrize("version", ["R2020a", "R2021b", "V8.5.0"])
def test_a_webots_world_with_y_up_is_refused(version: str) -> None:
    text = f"#VRML_SIM {version} utf8\nWoodenBox {{ translation 0.2 0.05 0.3 size 0.1 0.1 0.2 }}"
    with pytest.raises(WorldFileError, match=r"w.wbt:1: a y-up world, of before Webots R2022a; save it with"):
        parse_webots(text, "w.wbt", "w")


def boxes_of(nodes: str) -> list[tuple[float, ...]]:
    """x, y, width, depth (m) and heading (degrees) of the boxes that stand in an arena."""
    text = f"#VRML_SIM R2023b utf8\nRectangleArena {{ floorSize 2 2 }}\n{nodes}"
    boxes = [shape for shape in parse_webots(text, "w.wbt", "w").shapes[4:] if isinstance(shape, Box)]
    return [(box.x, box.y, box.width, box.depth, math.degrees(box.angle)) for box in boxes]


def test_scale_is_honored() -> None:
    shape = "Shape { geometry Box { size 0.1 0.2 0.1 } }"
    pose = "translation 0.1 0.2 0.05"
    assert boxes_of(f"Transform {{ {pose} scale 2 2 2 children [ {shape} ] }}") == [
        pytest.approx((0.1, 0.2, 0.2, 0.4, 0.0))
    ]
    inner = f"Pose {{ translation 0.1 0 0 rotation 0 0 1 1.5707963 children [ {shape} ] }}"
    (turned,) = boxes_of(f"Transform {{ {pose} scale 2 1 1 children [ {inner} ] }}")
    assert turned == pytest.approx((0.3, 0.2, 0.1, 0.4, 90.0), abs=1e-5)
    (both,) = boxes_of(
        f"Transform {{ scale 2 2 1 children [ Transform {{ scale 1 2 1 children [ {shape} ] }} ] }}"
    )
    assert both == pytest.approx((0.0, 0.0, 0.2, 0.8, 0.0))


@pytest.mark.parametrize(
    ("nodes", "skipped"),
    [
        ("Transform { scale 2 1 1 children [ WoodenBox { rotation 0 0 1 0.5 } ] }", r"WoodenBox \(sheared"),
        (
            "Transform { scale 2 1 1 children [ Shape { geometry Cylinder { radius 0.1 height 0.1 } } ] }",
            r"Cylinder \(scaled to an ellipse\)",
        ),
    ],
)
def test_what_a_scale_makes_of_no_kind_known_is_skipped(nodes: str, skipped: str) -> None:
    with pytest.warns(WorldWarning, match=skipped):
        assert boxes_of(nodes) == []


def test_hidden_fields_are_skipped() -> None:
    text = (
        "#VRML_SIM R2023b utf8\nRectangleArena { floorSize 1 1 }\n"
        "E-puck { translation 0.1 0.1 0 hidden position_0_0 1.5 hidden position_0_1 -2 }"
    )
    assert parse_webots(text, "w.wbt", "w").starts[0].pose.x == 0.1


def test_nodes_used_endlessly_often_are_refused() -> None:
    lines = ["#VRML_SIM R2023b utf8", "DEF A0 Group { }"]
    lines += [f"DEF A{n} Group {{ children [ {f'USE A{n - 1} ' * 9} ] }}" for n in range(1, 20)]
    with pytest.raises(WorldFileError, match=r"more than .* nodes"):
        parse_webots("\n".join(lines), "w.wbt", "w")


def test_what_is_transparent_was_never_seen(tmp_path: Path) -> None:
    pixels = np.zeros((40, 60, 4), dtype=np.uint8)
    pixels[1:39, 1:59] = 255
    pixels[:, 40:, 3] = 0
    Image.fromarray(pixels, "RGBA").save(tmp_path / "map.png")
    for mode in ("scale", "Trinary"):
        path = write_map(tmp_path, drawn_room(), image="map.png", origin="[0, 0, 0]", mode=mode)
        plan = Plan(find_world(path).shapes)
        assert plan.clearance(0.7, 0.4) == pytest.approx(0.1, abs=0.005)
        assert plan.bounds[2] == pytest.approx(0.8, abs=0.05)


@pytest.mark.parametrize("word", ["true", "True", "TRUE", "1", "Yes"])
def test_negate_and_mode_are_read_in_any_case(tmp_path: Path, word: str) -> None:
    room = 255 - drawn_room()
    negated = find_world(write_map(tmp_path, room, negate=word, mode="SCALE"))
    assert negated.shapes == find_world(write_map(tmp_path, 255 - room, mode="scale")).shapes


def test_an_image_is_a_regular_file_of_a_possible_name(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.pgm")
    for image, problem in (
        ("/dev/zero", "/dev/zero: a device, not a file"),
        ("pipe.pgm", "pipe.pgm: a pipe, not a file"),
        ('"a\\0b.pgm"', "holds control characters"),
        (".", "a folder, not a file"),
    ):
        with pytest.raises(WorldFileError, match=rf"map.yaml:1: image: .*{problem}"):
            find_world(write_map(tmp_path, drawn_room(), image=image))


@pytest.mark.parametrize("suffix", [".yaml", ".txt", ".wbt"])
def test_a_world_file_is_a_regular_file(tmp_path: Path, suffix: str) -> None:
    os.mkfifo(tmp_path / f"pipe{suffix}")
    (tmp_path / f"zero{suffix}").symlink_to("/dev/zero")
    for name, kind in (("pipe", "a pipe"), ("zero", "a device")):
        with pytest.raises(WorldFileError, match=f"{name}{suffix}: {kind}, not a file"):
            find_world(tmp_path / f"{name}{suffix}")


def png_of(width: int, height: int) -> bytes:
    """A PNG that says it has so many pixels, in a hundred bytes."""
    chunks = b""
    for kind, data in (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(b"\0" * 1000)),
        (b"IEND", b""),
    ):
        chunks += struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunks


@pytest.mark.parametrize(
    "data",
    [png_of(100_000, 100_000), b"P5 100000 100000 255\n", b"P2 9999 9999 255\n1"],
    ids=["png", "P5", "P2"],
)
def test_nothing_is_decoded_of_an_image_that_says_it_is_huge(data: bytes) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(WorldFileError, match="pixels, more than the limit"):
            parse_bitmap(data, "map.png")
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()


def test_written_out_pixels_take_no_more_memory_than_raw_ones() -> None:
    data = b"P2 1000 1000 255\n" + b"7 " * 1_000_000
    tracemalloc.start()
    try:
        assert parse_bitmap(data, "map.pgm").gray[0, 0] == 7 / 255
        assert tracemalloc.get_traced_memory()[1] < 30e6
    finally:
        tracemalloc.stop()


def test_an_unknown_kind_of_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "world.sdf"
    path.write_text("x")
    with pytest.raises(WorldFileError, match=r"ends in one of \.yaml"):
        find_world(path)
