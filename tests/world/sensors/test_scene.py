from __future__ import annotations

import pytest
from tolman.world.sensors.scene import triangulate


def test_triangles_cover_a_concave_polygon_once() -> None:
    points = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.5), (0.0, 2.0))
    area = 0.0
    for a, b, c in triangulate(points):
        (x0, y0), (x1, y1), (x2, y2) = points[a], points[b], points[c]
        area += abs((x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)) / 2
    assert area == pytest.approx(2.5)
