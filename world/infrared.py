"""The eight infrared sensors: distances to raw values, with the response and the noise of the real ones."""

from __future__ import annotations

import math

import numpy as np

from .geometry import Floats, Plan, cast
from .noise import Noise
from .robot import Pose, RobotGeometry

RAYS = 5
"""Rays over the aperture of one sensor; its value is the mean of their responses."""
FLOOR = 10.0
"""Raw value where nothing is in range."""
TOP = 4095.0
"""Largest raw value."""


class InfraredModel:
    """What the infrared sensors of one robot model would read."""

    def __init__(self, geometry: RobotGeometry, rays: int = RAYS) -> None:
        """Prepares the rays in the robot's frame and the response tables."""
        spread = np.linspace(-0.5, 0.5, rays) * geometry.infrared_aperture if rays > 1 else np.zeros(1)
        mounts = np.array(geometry.infrared_angles)
        angles = (mounts[:, None] + spread).ravel()
        self.rays = rays
        self.count = len(mounts)
        self.range = geometry.infrared_range
        self.height = geometry.infrared_height
        self.reach = geometry.body_radius + self.range
        rim = np.repeat(np.stack((np.cos(mounts), np.sin(mounts)), 1), rays, 0) * geometry.body_radius
        self._local = np.concatenate((rim, np.stack((np.cos(angles), np.sin(angles)), 1)))
        table = np.array(geometry.infrared_response)
        self._distances, self._values = table[:, 0].copy(), table[:, 1].copy()
        self._noise_values = np.concatenate(((FLOOR,), table[::-1, 1]))
        self._deviations = np.concatenate(((0.0,), table[::-1, 1] * table[::-1, 2]))

    def world_rays(self, pose: Pose) -> tuple[Floats, Floats]:
        """Origins and unit directions (sensors * rays, 2) in the world frame; rays of one sensor together."""
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        turned = self._local @ np.array(((cosine, sine), (-sine, cosine)))
        half = len(turned) // 2
        return turned[:half] + np.array((pose.x, pose.y)), turned[half:]

    def distances(self, pose: Pose, plan: Plan) -> Floats:
        """Distances (sensors * rays,) m to the plan's edges, inf beyond the range."""
        near = plan.near(pose.x, pose.y, self.reach)
        if not len(near):
            return np.full(self.count * self.rays, np.inf)
        return cast(*self.world_rays(pose), plan.segments[near])

    def values(self, distances: Floats) -> Floats:
        """Noise-free raw values (sensors,) for distances (sensors * rays,) m."""
        response = np.interp(distances, self._distances, self._values, right=FLOOR)
        means: Floats = response.reshape(self.count, self.rays).sum(axis=1) / self.rays
        return means

    def noisy(self, values: Floats, noise: Noise, random: np.random.Generator) -> Floats:
        """Values (sensors,) with noise added, cut to 0..4095; draws even when the noise is zero."""
        draws = random.standard_normal((2, self.count))
        deviation = np.interp(values, self._noise_values, self._deviations) * noise.infrared
        floor = np.where(values <= FLOOR + 1e-9, noise.infrared_floor, 0.0)
        noisy: Floats = np.minimum(np.maximum(values + deviation * draws[0] + floor * draws[1], 0.0), TOP)
        return noisy
