from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from tolman.world import WorldFileError, WorldWarning, find_world, open_world
from tolman.world.formats.bitmaps import parse_bitmap
from tolman.world.formats.maze import parse_maze
from tolman.world.formats.rosmap import free_cells, largest_area
from tolman.world.formats.webots import parse_webots
from tolman.world.geometry import Plan

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
        ({"image": "gone.pgm"}, "gone.pgm: cannot be read"),
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
    plain = parse_bitmap(b"P2\n# c\n2 1\n# d\n255\n0 255\n", "a")
    raw = parse_bitmap(b"P5 2 1 255 \x00\xff", "a")
    wide = parse_bitmap(b"P5 2 1 65535\n\x00\x00\xff\xff", "a")
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
        ('#VRML_SIM R2023b utf8\nWorldInfo { coordinateSystem "NUE" }', "only the coordinate system ENU"),
        ("#VRML_SIM R2023b utf8\nUSE A", "no DEF names"),
        ("#VRML_SIM R2023b utf8\n" + "Group { children [ " * 60, "nested deeper"),
        ("#VRML_SIM R2023b utf8\n?", "w.wbt:2: unexpected"),
        ("#VRML_SIM R2023b utf8\nWoodenBox { size 1 0 1 }", "is no box"),
    ],
)
def test_a_wrong_webots_world_is_explained(text: str, problem: str) -> None:
    with pytest.raises(WorldFileError, match=problem):
        parse_webots(text, "w.wbt", "w")


def test_an_unknown_kind_of_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "world.sdf"
    path.write_text("x")
    with pytest.raises(WorldFileError, match=r"ends in \.yaml"):
        find_world(path)
