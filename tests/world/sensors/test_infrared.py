from __future__ import annotations

import numpy as np
import pytest
from tolman.world import EPUCK, Pose, WorldSpec, built_in_world, open_world
from tolman.world.geometry import Plan, cast
from tolman.world.sensors.infrared import FLOOR, InfraredModel
from tolman.world.sensors.rays import embree_available, make_caster
from tolman.world.sensors.scene import Faces
from tolman.world.spec import Box, room_walls

from ..arrangements import SQUARE, random_shapes


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


@pytest.mark.parametrize("engine", ["numpy", "embree"])
def test_infrared_is_the_same_by_every_engine_over_ten_thousand_rays(engine: str) -> None:
    if engine == "embree" and not embree_available():
        pytest.skip("embreex has no wheel here")
    random = np.random.default_rng(5)
    model, worst, rays, apart = InfraredModel(EPUCK), 0.0, 0, 0
    for number in range(10):
        shapes = random_shapes(np.random.default_rng(100 + number))
        plan = Plan(shapes, min_height=model.height)
        caster = make_caster(Faces(shapes), engine)
        while rays < 1000 * (number + 1):
            x, y, heading = random.uniform((0.04, 0.04, -3.2), (1.96, 1.96, 3.2)).tolist()
            if Plan(shapes).clearance(x, y) < EPUCK.body_radius:
                continue
            pose = Pose(x, y, heading)
            plain = model.distances(pose, plan.edges_near(x, y, model.reach))
            off = np.abs(np.subtract(plain, model.cast(pose, caster)))
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
