"""The picture of a map: what is in it, and that its bytes depend on nothing else."""

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.patches import Circle
from tolman.files.messages import FileError
from tolman.scripts.drawing.plot import BLOCKED, CORNERS, FORAY, compose_figure, save_drawing
from tolman.scripts.drawing.style import ArcLine, Drawing, Lattice, extent, placed
from tolman.world.robot import Pose
from tolman.world.spec import Box, Cylinder, room_walls


def sample() -> Drawing:
    rows = np.stack(np.meshgrid(np.linspace(0, 0.2, 5), np.linspace(-0.1, 0.1, 5)), axis=-1).reshape(25, 2)
    edges = [(k, k + 1) for k in range(24) if k % 5 != 4] + [(k, k + 5) for k in range(20)]
    lattice = Lattice(rows, edges, np.arange(25) % 7 != 0)
    nodes = {
        0: Pose(0.06, 0.06, 0.0),
        1: Pose(0.94, 0.06, math.pi / 2),
        2: Pose(0.94, 0.94, math.pi),
        3: Pose(0.06, 0.94, -math.pi / 2),
    }
    arcs = [ArcLine(k, (k + 1) % 4, 0.88) for k in range(4)] + [
        ArcLine((k + 1) % 4, k, 0.88) for k in range(4)
    ]
    track = np.array([[0.06, 0.06], [0.94, 0.06], [0.94, 0.94], [0.06, 0.94]])
    shapes = (*room_walls(1.0, 1.0), Box(0.5, 0.5, 0.2, 0.1, 0.3), Cylinder(0.3, 0.6, 0.05))
    return Drawing("a room", nodes, arcs, {0: lattice, 2: lattice}, shapes, track)


@pytest.mark.parametrize(("suffix", "magic"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_the_same_map_gives_the_same_bytes(tmp_path: Path, suffix: str, magic: bytes) -> None:
    first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    save_drawing(sample(), first)
    save_drawing(sample(), second)
    assert first.read_bytes().startswith(magic)
    assert first.read_bytes() == second.read_bytes()


def test_every_node_is_numbered_and_every_pair_measured_once() -> None:
    texts = [text.get_text() for text in compose_figure(sample()).axes[0].texts]
    assert sorted(text for text in texts if not text.endswith("cm")) == ["0", "1", "2", "3"]
    assert sum(text == "88 cm" for text in texts) == 4


def test_a_map_without_nodes_can_be_drawn(tmp_path: Path) -> None:
    save_drawing(Drawing("empty", {}), tmp_path / "empty.png")
    assert (tmp_path / "empty.png").stat().st_size > 1000


def test_points_of_a_node_are_turned_by_its_heading() -> None:
    moved = placed(np.array([[1.0, 0.0], [0.0, 1.0]]), Pose(2.0, 3.0, math.pi / 2))
    assert moved == pytest.approx(np.array([[2.0, 4.0], [1.0, 3.0]]))


def test_nothing_drawn_lies_outside_the_picture() -> None:
    left, right, bottom, top = extent(sample())
    assert left < -0.05
    assert right > 1.05
    assert bottom < -0.05
    assert top > 1.05


def test_the_command_line_does_not_load_matplotlib_until_it_draws() -> None:
    program = (
        "import sys; from tolman.scripts.cli.commands import go, map; print('matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_the_legend_names_what_is_drawn_and_nothing_else() -> None:
    drawing = sample()
    plain = compose_figure(drawing).axes[0].get_legend()
    assert plain is not None
    names = {text.get_text() for text in plain.get_texts()}
    assert "wall" in names
    assert not {"blocked", "foray across open space", "node at a convex corner"} & names
    arcs = [*drawing.arcs, ArcLine(0, 2, 1.2, foray=True), ArcLine(1, 3, 1.2, foray=True, blocked=True)]
    more = compose_figure(replace(drawing, arcs=arcs, corners={0: "convex", 1: "none"})).axes[0].get_legend()
    assert more is not None
    names = {text.get_text() for text in more.get_texts()}
    assert {"blocked", "foray across open space", "node at a convex corner", "other node"} <= names


def test_forays_blocked_arcs_and_corners_have_colors_of_their_own() -> None:
    arcs = [ArcLine(0, 1, 0.9), ArcLine(0, 1, 1.0, foray=True), ArcLine(2, 3, 0.9, blocked=True)]
    figure = compose_figure(replace(sample(), arcs=arcs, corners={0: "convex"}))
    texts = {text.get_text(): text for text in figure.axes[0].texts}
    assert texts["100 cm"].get_color() == FORAY
    assert texts["100 cm"].get_position() != texts["90 cm"].get_position()
    blocked = [line for line in figure.axes[0].lines if line.get_color() == BLOCKED]
    assert len([line for line in blocked if np.size(line.get_xdata()) == 2]) == 1
    discs = [patch.get_facecolor() for patch in figure.axes[0].patches if isinstance(patch, Circle)]
    assert to_rgba(CORNERS["convex"]) in discs


def test_labels_of_arcs_are_read_from_below_or_from_the_right() -> None:
    texts = [text for text in compose_figure(sample()).axes[0].texts if text.get_text() == "88 cm"]
    assert sorted(round(text.get_rotation()) for text in texts) == [0, 0, 90, 90]


def test_an_arc_from_a_node_to_itself_is_a_ring_around_it() -> None:
    drawing = replace(sample(), arcs=[ArcLine(0, 0, 0.5)], shapes=(), lattices={})
    rings = [patch for patch in compose_figure(drawing).axes[0].patches if not patch.get_fill()]
    assert [isinstance(ring, Circle) and ring.center for ring in rings] == [(0.06, 0.06)]


def test_a_picture_is_no_pipe_and_leaves_nothing_beside_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    with pytest.raises(FileError, match=r"pipe\.png is a device, a pipe or a socket"):
        save_drawing(Drawing("empty", {}), tmp_path / "pipe.png")
    assert os.listdir(tmp_path) == ["pipe.png"]
