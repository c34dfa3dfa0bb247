from __future__ import annotations

import math

import numpy as np
import pytest
from tolman.world import PRESETS, Image, Pose, WorldError, WorldSpec, open_world
from tolman.world.spec import Box, Scenery, Surface, Texture, room_walls

from ..arrangements import SQUARE

LUMA = np.array((0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("rays", ["numpy", "auto"])
def test_the_camera_sees_sky_over_wall_over_floor(rays: str) -> None:
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0), rays=rays)
    image = world.robots[0].look(32, 24)
    assert image.shape == (24, 32)
    assert image.dtype == np.float32
    top, middle, bottom = image[0].mean(), image[12, 8:24].mean(), image[-1].mean()
    assert top > middle + 0.02
    assert middle > bottom + 0.02
    assert image.min() >= 0.0
    assert image.max() <= 1.0


def test_both_ray_engines_render_the_same_picture() -> None:
    for name in ("env1-textured", "islands"):
        pictures = [
            open_world(name, noise="none", engine="kinematic", rays=rays).robots[0].look(48, 32)
            for rays in ("numpy", "auto")
        ]
        assert np.abs(pictures[0] - pictures[1]).mean() < 2e-3


def test_walls_that_face_differently_differ_unless_the_light_is_even() -> None:
    for ambient, least, most in ((0.4, 0.05, 1.0), (1.0, 0.0, 1e-6)):
        spec = WorldSpec("lit", room_walls(0.4, 0.4), scenery=Scenery(ambient=ambient))
        shades = [
            float(
                open_world(spec, noise="none", engine="kinematic", start=Pose(0.2, 0.2, turn))
                .robots[0]
                .look(4, 4)[2]
                .mean()
            )
            for turn in (0.0, math.pi / 2, math.pi, -math.pi / 2)
        ]
        assert least <= max(shades) - min(shades) <= most


def test_a_texture_shows_on_the_wall_upright() -> None:
    """Dark on the left half and light on the right half of each tile, as seen by someone facing the wall."""
    texture = Texture("halves", ((0.1, 1.0),))
    wall = Box(1.0, 1.2, 0.4, 0.02, 0.0, 0.5, Surface(texture="halves", tile=(0.4, 0.5)))
    spec = WorldSpec("painted", (*room_walls(2.0, 2.0), wall), textures=(texture,))
    image = (
        open_world(spec, noise="none", engine="kinematic", start=Pose(1.0, 0.9, math.pi / 2)).robots[0].look()
    )
    assert image[2, :6].mean() < image[2, 10:].mean() - 0.2


@pytest.mark.parametrize("size", [(0, 16), (641, 16), (16, 481), (-1, 4)])
def test_impossible_image_sizes_are_refused(size: tuple[int, int]) -> None:
    world = open_world(SQUARE, engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    with pytest.raises(WorldError, match="640x480"):
        world.robots[0].look(*size)


def test_the_largest_image_can_be_taken() -> None:
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    assert world.robots[0].look(640, 480).shape == (480, 640)


@pytest.mark.parametrize("name", ["env1-textured", "islands"])
@pytest.mark.parametrize("size", [(16, 16), (160, 120)])
def test_a_color_image_has_the_luminance_of_the_plain_one(name: str, size: tuple[int, int]) -> None:
    robot = open_world(name, noise="none", engine="kinematic").robots[0]
    plain, color = robot.look(*size), robot.look(*size, color=True)
    assert color.shape == (size[1], size[0], 3)
    assert color.dtype == np.float32
    assert np.abs(color @ LUMA - plain).max() < 1e-6


def test_a_red_wall_is_red_and_a_gray_one_gray() -> None:
    for surface, reddish in ((Surface((0.85, 0.15, 0.1)), True), (Surface((0.5, 0.5, 0.5)), False)):
        spec = WorldSpec("one color", room_walls(0.4, 0.4, surface=surface))
        robot = open_world(spec, noise="none", engine="kinematic", start=Pose(0.2, 0.2, 0.0)).robots[0]
        red, green, blue = robot.look(32, 24, color=True)[12, 16].tolist()
        assert (red > 3 * green and red > 3 * blue) == reddish
        assert reddish or red == green == blue


def test_another_robot_is_seen_in_its_color() -> None:
    spec = WorldSpec("two", room_walls(2.0, 2.0), robots=(Pose(1.1, 1.0, 0.0),))
    robot = open_world(spec, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0)).robots[0]
    red, green, blue = robot.look(color=True)[8, 8].tolist()
    assert green > red
    assert green > blue


def test_noise_of_a_color_image_is_drawn_for_every_tone() -> None:
    def taken(noise: str) -> Image:
        world = open_world(SQUARE, noise=noise, engine="kinematic", start=Pose(1.0, 1.0, 0.0))
        return world.robots[0].look(64, 48, color=True)

    off = taken("thesis") - taken("none")
    inside = off[16:32]  # where no value is cut off at 0 or 1
    assert np.std(inside) == pytest.approx(PRESETS["thesis"].camera, rel=0.1)
    assert np.abs(np.corrcoef(inside[..., 0].ravel(), inside[..., 1].ravel())[0, 1]) < 0.1
