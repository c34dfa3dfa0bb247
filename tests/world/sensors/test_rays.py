from __future__ import annotations

import math

import numpy as np
import pytest
from tolman.world.geometry import Plan, cast
from tolman.world.sensors.rays import EmbreeCaster, NumpyCaster, embree_available
from tolman.world.sensors.scene import Faces
from tolman.world.spec import Shape

from ..arrangements import MIXED, random_shapes


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
