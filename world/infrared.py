"""The eight infrared sensors: distances to raw values, with the response and the noise of the real ones."""

from __future__ import annotations

import math

import numpy as np

from .geometry import Floats
from .noise import Noise
from .robot import Pose, RobotGeometry

RAYS = 5
"""Rays over the aperture of one sensor; its value is the mean of their responses."""
FLOOR = 10.0
"""Raw value where nothing is in range."""
TOP = 4095.0
"""Largest raw value."""
_END = 1e-9
"""How far beyond its ends, as a share of its length, an edge still stops a ray: corners have no slits."""


class InfraredModel:
    """What the infrared sensors of one robot model would read."""

    def __init__(self, geometry: RobotGeometry, rays: int = RAYS) -> None:
        """Prepares the rays in the robot's frame and the response table."""
        spread = np.linspace(-0.5, 0.5, rays) * geometry.infrared_aperture if rays > 1 else np.zeros(1)
        mounts = np.array(geometry.infrared_angles)
        angles = (mounts[:, None] + spread).ravel()
        self.rays = rays
        self.count = len(mounts)
        self.height = geometry.infrared_height
        self.reach = geometry.body_radius + geometry.infrared_range
        self._origins = (
            np.repeat(np.stack((np.cos(mounts), np.sin(mounts)), 1), rays, 0) * geometry.body_radius
        )
        self._directions = np.stack((np.cos(angles), np.sin(angles)), 1)
        self._both = np.concatenate((self._directions, self._origins))
        self._offset = _cross(self._origins, self._directions)[:, None]
        self._nothing = np.full(self.count * rays, np.inf)
        self._dark = np.full(self.count, FLOOR)
        table = np.array(geometry.infrared_response)
        self._distances, self._values = table[:, 0].copy(), table[:, 1].copy()
        self._relative = table[:, 2].copy()

    def world_rays(self, pose: Pose) -> tuple[Floats, Floats]:
        """Origins and unit directions (sensors * rays, 2) in the world frame; rays of one sensor together."""
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        turn = np.array(((cosine, sine), (-sine, cosine)))
        return self._origins @ turn + np.array((pose.x, pose.y)), self._directions @ turn

    def distances(self, pose: Pose, segments: Floats) -> Floats:
        """Distances (sensors * rays,) m along the rays to segments (n, 4) m, world frame; inf: none.

        The segments are brought into the robot's frame, where the rays never change.
        """
        count = len(segments)
        if not count:
            return self._nothing
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        start_x, start_y = segments[:, 0] - pose.x, segments[:, 1] - pose.y
        along_x, along_y = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
        # rows (y, -x) of each vector in the robot's frame, so that a product with a ray is a cross product
        edges = np.empty((2, 2 * count))
        edges[0, :count] = cosine * along_y - sine * along_x
        edges[1, :count] = -cosine * along_x - sine * along_y
        edges[0, count:] = cosine * start_y - sine * start_x
        edges[1, count:] = -cosine * start_x - sine * start_y
        products = self._both @ edges
        rays = len(self._directions)
        start_cross_along = start_x * along_y - start_y * along_x
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / products[:rays, :count]
            distance = (start_cross_along - products[rays:, :count]) * inverse
            share = (-products[:rays, count:] - self._offset) * inverse
            hit = (distance >= 0.0) & (share >= -_END) & (share <= 1.0 + _END)
        distance[~hit] = np.inf
        nearest: Floats = distance.min(axis=1)
        return nearest

    def values(self, distances: Floats) -> Floats:
        """Noise-free raw values (sensors,) for distances (sensors * rays,) m."""
        response = np.interp(distances, self._distances, self._values, right=FLOOR)
        means: Floats = response.reshape(self.count, self.rays).sum(axis=1) / self.rays
        return means

    def read(self, pose: Pose, segments: Floats) -> Floats:
        """Noise-free raw values (sensors,) at a pose among segments (n, 4) m, at least all in reach."""
        return self.values(self.distances(pose, segments)) if len(segments) else self._dark

    def deviation_table(self, noise: Noise) -> tuple[Floats, Floats]:
        """Raw values, rising, and the standard deviation of the noise at each."""
        values = np.concatenate(((FLOOR,), self._values[::-1]))
        deviations = np.concatenate(
            ((noise.infrared_floor,), (self._values * self._relative)[::-1] * noise.infrared)
        )
        return values, deviations


def _cross(a: Floats, b: Floats) -> Floats:
    result: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return result
