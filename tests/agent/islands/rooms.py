"""A room and an island in it, as outlines."""

from __future__ import annotations

import math

from tolman.agent.islands.outlines import Outline

QUARTER = 0.5 * math.pi
ROOM = Outline(((0.0, 0.0), (1.2, 0.0), (1.2, 1.0), (0.0, 1.0)), (0, 1, 2, 3), ("concave",) * 4)
ISLAND = Outline(((0.4, 0.4), (0.4, 0.6), (0.8, 0.6), (0.8, 0.4)), (4, 5, 6, 7), ("convex",) * 4)
