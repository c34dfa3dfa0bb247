"""Panoramas of made-up surroundings."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from tolman.world.robot import EPUCK

FIELD = EPUCK.camera_field_of_view


def panorama(seed: int, turned: float = 0.0, width: int = 16) -> NDArray[np.float32]:
    """Four views (4, 16, width) of smooth scenery all around, taken after turning by `turned` (rad)."""
    rng = np.random.default_rng(seed)
    orders = np.arange(1, 9)
    amplitude = rng.normal(0.0, 1.0, (16, 8)) / orders
    phase = rng.uniform(0.0, math.tau, (16, 8))
    focal = 0.5 * width / math.tan(0.5 * FIELD)
    bearing = np.arctan((0.5 * width - np.arange(width) - 0.5) / focal)
    views = [
        (
            amplitude[:, None, :] * np.cos(orders * (bearing[None, :, None] + direction) + phase[:, None, :])
        ).sum(2)
        for direction in turned + 0.5 * math.pi * np.arange(4)
    ]
    return (0.5 + 0.1 * np.array(views)).astype(np.float32)
