from __future__ import annotations

import math

import numpy as np
import pytest
from tolman.world import (
    EPUCK,
    Pose,
    Sensing,
    Timing,
    WheelCommand,
    WorldError,
    WorldSpec,
    built_in_world,
    open_world,
)
from tolman.world.geometry import Plan, cast
from tolman.world.sensors.infrared import FLOOR, InfraredModel
from tolman.world.sensors.infrared_rays import InfraredCaster
from tolman.world.sensors.rays import EmbreeCaster, NumpyCaster, embree_available
from tolman.world.sensors.scene import Faces, triangulate
from tolman.world.spec import Box, Cylinder, Polygon, Scenery, Shape, Surface, Texture, room_walls

SQUARE = WorldSpec("square", room_walls(2.0, 2.0))
MIXED = (
    *room_walls(2.0, 2.0),
    Box(0.5, 0.5, 0.3, 0.1, 0.4, 0.02),
    Cylinder(1.4, 0.6, 0.12, 0.06),
    Polygon(((0.3, 1.2), (0.8, 1.2), (0.8, 1.7), (0.55, 1.35), (0.3, 1.7)), 0.025),
)


def random_shapes(random: np.random.Generator) -> tuple[Shape, ...]:
    """A room of 2 x 2 m with boxes, cylinders and polygons anywhere, some of them overlapping."""
    places = random.uniform(0.3, 1.7, (9, 2)).tolist()
    boxes = [
        Box(
            x,
            y,
            random.uniform(0.05, 0.4),
            random.uniform(0.05, 0.4),
            random.uniform(-3, 3),
            random.uniform(0.01, 0.1),
        )
        for x, y in places[:4]
    ]
    cylinders = [Cylinder(x, y, random.uniform(0.02, 0.2), random.uniform(0.01, 0.1)) for x, y in places[4:7]]
    polygons = [
        Polygon(tuple((x + size * u, y + size * v) for u, v in ((0, 0), (1, 0.2), (0.8, 1), (0.4, 0.3))))
        for (x, y), size in zip(places[7:], random.uniform(0.1, 0.4, 2).tolist(), strict=True)
    ]
    return (*room_walls(2.0, 2.0), *boxes, *cylinders, *polygons)


@pytest.mark.skipif(not embree_available(), reason="embreex has no wheel here")
@pytest.mark.parametrize("shapes", [MIXED, *(random_shapes(np.random.default_rng(k)) for k in range(9))])
def test_both_casters_agree_over_ten_thousand_rays(shapes: tuple[Shape, ...]) -> None:
    faces, plan = Faces(shapes), Plan(shapes)
    random = np.random.default_rng(1)
    places = [at for at in random.uniform(0.05, 1.95, (4000, 2)).tolist() if plan.clearance(*at) > 0.001]
    origins = np.column_stack((np.array(places[:1000]), np.full(1000, 0.028)))
    directions = random.normal(size=origins.shape) * (1.0, 1.0, 0.2)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    exact, exact_face = NumpyCaster(faces).cast(origins, directions)
    quick, quick_face = EmbreeCaster(faces).cast(origins, directions)
    both = np.isfinite(exact) & np.isfinite(quick)
    same = both & (exact_face == quick_face)
    assert (np.isfinite(exact) != np.isfinite(quick)).sum() <= 1  # rays along an edge can fall either way
    assert (np.abs(exact[both] - quick[both]) < 1e-5).sum() >= both.sum() - 1
    assert np.abs(exact[same] - quick[same]).max() < 1e-5


@pytest.mark.parametrize("engine", ["numpy", "embree"])
def test_infrared_is_the_same_by_every_engine_over_ten_thousand_rays(engine: str) -> None:
    if engine == "embree" and not embree_available():
        pytest.skip("embreex has no wheel here")
    random = np.random.default_rng(5)
    model, worst, rays, apart = InfraredModel(EPUCK), 0.0, 0, 0
    for number in range(10):
        shapes = random_shapes(np.random.default_rng(100 + number))
        plan = Plan(shapes, min_height=model.height)
        caster = InfraredCaster(model, shapes, engine)
        while rays < 1000 * (number + 1):
            x, y, heading = random.uniform((0.04, 0.04, -3.2), (1.96, 1.96, 3.2)).tolist()
            if Plan(shapes).clearance(x, y) < EPUCK.body_radius:
                continue
            pose = Pose(x, y, heading)
            plain = model.distances(pose, plan.edges_near(x, y, model.reach))
            off = np.abs(np.subtract(plain, caster.distances(pose)))
            apart += int((off > 1e-5).sum())  # rays along an edge can fall either way
            worst, rays = max(worst, float(off[off <= 1e-5].max())), rays + len(plain)
    assert rays >= 10_000
    assert worst < 1e-5
    assert apart <= 2


def test_the_engine_can_be_chosen_for_infrared_too() -> None:
    spec = WorldSpec("two", room_walls(0.5, 0.5), robots=(Pose(0.2, 0.1, 0.0),))
    readings = [
        open_world(spec, noise="none", engine="kinematic", start=Pose(0.1, 0.1, 0.3), rays=rays)
        .robots[0]
        .sense()
        .infrared
        for rays in ("auto", "numpy")
    ]
    assert readings[0] == pytest.approx(readings[1], abs=1e-6)
    assert max(readings[0]) > 200


def test_the_flat_caster_agrees_with_the_spatial_one() -> None:
    plan, faces = Plan(MIXED, min_height=0.021), Faces([shape for shape in MIXED if shape.height >= 0.021])
    random = np.random.default_rng(2)
    origins = random.uniform(0.1, 1.9, (2000, 2))
    turns = random.uniform(-math.pi, math.pi, 2000)
    directions = np.stack((np.cos(turns), np.sin(turns)), 1)
    flat = cast(origins, directions, plan.segments)
    spatial, _ = NumpyCaster(faces).cast(
        np.column_stack((origins, np.full(2000, 0.021))), np.column_stack((directions, np.zeros(2000)))
    )
    assert np.allclose(flat, spatial, atol=1e-9)


@pytest.mark.parametrize(("distance", "value", "_"), EPUCK.infrared_response[1:])
def test_infrared_reads_the_published_response_in_front_of_a_wall(
    distance: float, value: float, _: float
) -> None:
    """Sensor ps5 looks straight to the left; the aperture's outer rays are a little longer."""
    model = InfraredModel(EPUCK)
    pose = Pose(1.0, 2.0 - EPUCK.body_radius - distance, 0.0)
    read = model.read(pose, Plan(SQUARE.shapes).edges_near(pose.x, pose.y, model.reach))
    assert read[5] == pytest.approx(value, rel=0.02 if distance < 0.07 else 0.9)
    assert read[2] == FLOOR


def test_infrared_rays_agree_with_the_general_caster() -> None:
    model, plan = InfraredModel(EPUCK), Plan(built_in_world("env1").shapes)
    random = np.random.default_rng(3)
    for x, y, heading in random.uniform((0.0, 0.0, -3.0), (1.0, 1.0, 3.0), (60, 3)).tolist():
        pose = Pose(x, y, heading)
        if plan.clearance(x, y) > EPUCK.body_radius:
            general = cast(*model.world_rays(pose), plan.segments)
            found = model.distances(pose, plan.edges_near(x, y, model.reach))
            assert np.allclose(found, np.minimum(general, model.range), atol=1e-9)


def test_sensors_pressed_into_a_wall_by_a_hair_do_not_look_through_it() -> None:
    model = InfraredModel(EPUCK)
    pose = Pose(1.0, 2.0 - EPUCK.body_radius + 1e-4, 0.0)
    read = model.read(pose, Plan(SQUARE.shapes).edges_near(pose.x, pose.y, model.reach))
    assert read[5] > 4000


def test_infrared_ignores_what_is_lower_than_its_rays() -> None:
    low = WorldSpec("low", (*room_walls(2.0, 2.0), Box(1.08, 1.0, 0.04, 0.2, 0.0, 0.02)))
    world = open_world(low, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    assert world.robots[0].sense().infrared == (FLOOR,) * 8


def test_infrared_noise_has_the_published_size() -> None:
    world = open_world(SQUARE, noise="encoder", engine="kinematic", start=Pose(1.0, 1.935, 0.0))
    values = []
    for _ in range(400):
        world.step()
        values.append(world.robots[0].sense().infrared[5])
    assert np.std(values) / np.mean(values) == pytest.approx(0.024, rel=0.25)


def test_robots_see_each_other_by_infrared_and_camera() -> None:
    spec = WorldSpec("two", room_walls(2.0, 2.0), robots=(Pose(1.1, 1.0, 0.0),))
    world = open_world(spec, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    alone = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 0.0))
    assert world.robots[0].sense().infrared[0] > 120
    assert not np.array_equal(world.robots[0].look(), alone.robots[0].look())


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


def test_the_accelerometer_feels_gravity_and_the_start() -> None:
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.0, 1.0, 1.0))
    assert world.robots[0].sense().accelerometer == (0.0, 0.0, 9.81)
    world.robots[0].act(WheelCommand(500, 500))
    world.step()
    ahead, left, up = world.robots[0].sense().accelerometer
    assert ahead == pytest.approx(500 * EPUCK.distance_per_step / 0.032)
    assert left == pytest.approx(0.0, abs=1e-9)
    assert up == 9.81
    world.step()
    assert world.robots[0].sense().accelerometer[0] == pytest.approx(0.0, abs=1e-9)


def test_a_delayed_sensor_lags_and_a_slow_one_repeats() -> None:
    sensing = Sensing(infrared=Timing(interval=0.096), encoders=Timing(delay=0.064))
    world = open_world(SQUARE, noise="none", engine="kinematic", start=Pose(1.9, 1.0, 0.0), sensing=sensing)
    robot = world.robots[0]
    encoders, infrared = [], []
    for _ in range(9):
        robot.act(WheelCommand(100, 100))
        world.step()
        encoders.append(robot.sense().encoders[0] / 3.2)
        infrared.append(robot.sense().infrared[0])
    assert encoders == pytest.approx([0, 0, 1, 2, 3, 4, 5, 6, 7])
    assert infrared[2] == infrared[3] == infrared[4] != infrared[5]


@pytest.mark.parametrize(
    ("sensing", "problem"),
    [
        ({"infrared": {"delay": 0.01}}, "0.01 s is not a multiple of the control period of 0.032"),
        ({"infrred": {"delay": 0.032}}, "did you mean 'infrared'"),
        ({"camera": {"interval": 0.0}}, "outside"),
        ({"camera": {"delay": "soon"}}, "number of seconds"),
        ({"camera": 3}, "expected a mapping"),
    ],
)
def test_a_wrong_sensor_setting_is_explained(sensing: dict[str, object], problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        open_world("env1", engine="kinematic", sensing=sensing)


def test_triangles_cover_a_concave_polygon_once() -> None:
    points = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.5), (0.0, 2.0))
    area = 0.0
    for a, b, c in triangulate(points):
        (x0, y0), (x1, y1), (x2, y2) = points[a], points[b], points[c]
        area += abs((x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)) / 2
    assert area == pytest.approx(2.5)
