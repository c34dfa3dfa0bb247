"""Infrared: distances to raw values, with the response and the noise of the real sensors."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ..geometry import Edge, Floats
from ..noise.random_streams import normal
from ..robot import Pose, RobotGeometry
from .rays import Caster
from .sensor import Motion, Mounting, Sensor

RAYS = 5
"""Rays over the aperture of one sensor; its value is the mean of their responses."""
FLOOR = 10.0
"""Raw value where nothing is in range."""
TOP = 4095.0
"""Largest raw value."""
RECESS = 0.005
"""How far (m) behind the rim an edge still stops a ray, at distance 0: a shell pressed at a wall by a hair
has its sensors in it, and they must not look through to the far side."""
_END = 1e-9
"""How far beyond its ends, as a share of its length, an edge still stops a ray: corners have no slits."""


class Infrared(Sensor):
    """(8,) raw values, 0 to 4095. Noise: normal, its size by raw value as in the response, or the floor's."""

    def __init__(self, mounting: Mounting) -> None:
        """Prepares the response, and what is high enough for the rays to meet."""
        geometry, noise = mounting.geometry, mounting.noise
        self._own, self._surroundings = mounting.own, mounting.surroundings
        self._model = infrared_model(geometry)
        self._fixed_edges = self._surroundings.plan_above(geometry.infrared_height).edges_near
        self._by_casting = self._surroundings.rays != "auto"
        self._noisy = noise.infrared > 0.0 or noise.infrared_floor > 0.0
        self._deviations = self._model.deviations(noise.infrared, noise.infrared_floor)
        self._rows = mounting.streams.rows("infrared", normal, len(geometry.infrared_angles))

    def measure(self, motion: Motion) -> tuple[float, ...]:
        """The raw values at the pose."""
        values = self.values(motion.pose)
        return self._deviations.disturbed(values, self._rows.row()) if self._noisy else tuple(values)

    def values(self, pose: Pose) -> list[float]:
        """Noise-free raw values at a pose."""
        model, around = self._model, self._surroundings
        moving = [] if around.alone else around.moving_edges(self._own, pose, model.reach, model.height)
        if not self._by_casting:
            fixed = self._fixed_edges(pose.x, pose.y, model.reach)
            return model.read(pose, fixed + moving if moving else fixed)
        distances = model.cast(pose, around.fixed.caster)
        if moving:
            others = model.distances(pose, moving)
            distances = [min(pair) for pair in zip(distances, others, strict=True)]
        return model.values(distances)


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
        self.range = geometry.infrared_range
        self.reach = geometry.body_radius + geometry.infrared_range
        self.dark = [FLOOR] * self.count
        self._origins: Floats = (
            np.repeat(np.stack((np.cos(mounts), np.sin(mounts)), 1), rays, 0) * geometry.body_radius
        )
        self._directions: Floats = np.stack((np.cos(angles), np.sin(angles)), 1)
        self._sensors = self._by_sensor()
        self._nothing = [self.range] * (self.count * rays)
        columns = zip(*geometry.infrared_response, strict=True)
        self._distances, self._values, self._relative = (list[float](column) for column in columns)
        self._slopes: list[float] = [
            (value - before) / (far - near)
            for (near, far), (before, value) in zip(
                pairwise(self._distances), pairwise(self._values), strict=True
            )
        ]

    def _by_sensor(self) -> list[tuple[float, float, list[tuple[int, float, float, float]]]]:
        """For each sensor its place, and for each of its rays: number, direction, cross product of both."""
        offsets = self._origins[:, 0] * self._directions[:, 1] - self._origins[:, 1] * self._directions[:, 0]
        rays = [
            (number, x, y, offset)
            for number, ((x, y), offset) in enumerate(
                zip(self._directions.tolist(), offsets.tolist(), strict=True)
            )
        ]
        return [
            (*self._origins[first].tolist(), rays[first : first + self.rays])
            for first in range(0, len(rays), self.rays)
        ]

    def world_rays(self, pose: Pose) -> tuple[Floats, Floats]:
        """Origins and unit directions (sensors * rays, 2) in the world frame; rays of one sensor together."""
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        turn = np.array(((cosine, sine), (-sine, cosine)))
        return self._origins @ turn + np.array((pose.x, pose.y)), self._directions @ turn

    def read(self, pose: Pose, edges: Iterable[Edge]) -> list[float]:
        """Noise-free raw values, one a sensor, at a pose among edges, at least all those in reach."""
        distances = self.distances(pose, edges)
        return self.dark if distances is self._nothing else self.values(distances)

    def distances(self, pose: Pose, edges: Iterable[Edge]) -> list[float]:
        """Distances (m) from the rim, sensors * rays of them, along the rays to the edges; at most the range.

        The few edges in reach are brought into the robot's frame, where the rays never change. In plain
        Python, since calls of numpy for so few numbers cost more than they save.
        """
        cosine, sine = math.cos(pose.heading), math.sin(pose.heading)
        reach2, range2 = self.reach**2, self.range**2
        found = self._nothing
        for x0, y0, along_x, along_y, length2 in edges:
            start_x, start_y = x0 - pose.x, y0 - pose.y
            share = -(start_x * along_x + start_y * along_y) / length2
            share = 0.0 if share < 0.0 else 1.0 if share > 1.0 else share
            if (start_x + share * along_x) ** 2 + (start_y + share * along_y) ** 2 >= reach2:
                continue
            if found is self._nothing:
                found = found.copy()
            x, y = cosine * start_x + sine * start_y, cosine * start_y - sine * start_x
            ahead, left = cosine * along_x + sine * along_y, cosine * along_y - sine * along_x
            start_cross_along, too_far = x * left - y * ahead, range2 * length2
            for mount_x, mount_y, rays in self._sensors:
                # the sensor's distance from the edge's line, times the edge's length
                across = start_cross_along - mount_x * left + mount_y * ahead
                if across * across > too_far:
                    continue
                for number, ray_x, ray_y, offset in rays:
                    ray_cross_along = ray_x * left - ray_y * ahead
                    if ray_cross_along == 0.0:
                        continue
                    distance = across / ray_cross_along
                    if (
                        -RECESS <= distance < found[number]
                        and -_END <= (x * ray_y - y * ray_x - offset) / ray_cross_along <= 1.0 + _END
                    ):
                        found[number] = distance
        return found

    def cast(self, pose: Pose, caster: Caster) -> list[float]:
        """The same distances as `distances`, by what casts the camera's rays (Embree: single precision)."""
        origins, directions = self.world_rays(pose)
        starts, ways = np.empty((len(origins), 3)), np.zeros((len(origins), 3))
        starts[:, :2], starts[:, 2] = origins - RECESS * directions, self.height
        ways[:, :2] = directions
        found, _ = caster.cast(starts, ways)
        limited: list[float] = np.minimum(found - RECESS, self.range).tolist()
        return limited

    def values(self, distances: Sequence[float]) -> list[float]:
        """Noise-free raw values, one a sensor, for distances (m), sensors * rays of them."""
        table, values, slopes, limit, rays = (
            self._distances,
            self._values,
            self._slopes,
            self.range,
            self.rays,
        )
        nothing = self._nothing[:rays]
        means = []
        for first in range(0, len(distances), rays):
            own = distances[first : first + rays]
            if own == nothing:
                means.append(FLOOR)
                continue
            total = 0.0
            for distance in own:
                if distance >= limit:
                    total += FLOOR
                elif distance <= 0.0:
                    total += values[0]
                else:
                    row = bisect_right(table, distance) - 1
                    total += values[row] + slopes[row] * (distance - table[row])
            means.append(total / rays)
        return means

    def deviations(self, factor: float, floor: float) -> Deviations:
        """The noise: at each raw value of the response, `factor` times its share of that value.

        floor: the standard deviation (raw units) where nothing is in range.
        """
        values, relative = reversed(self._values), reversed(self._relative)
        rows = [(value, value * share * factor) for value, share in zip(values, relative, strict=True)]
        return Deviations([(FLOOR, floor), *rows])


@lru_cache(maxsize=8)
def infrared_model(geometry: RobotGeometry) -> InfraredModel:
    """The model of this robot's sensors; it never changes, so robots share it."""
    return InfraredModel(geometry)


class Deviations:
    """Standard deviations of the noise by raw value, linear between rows."""

    def __init__(self, rows: Sequence[tuple[float, float]]) -> None:
        """rows: (raw value, standard deviation), values rising."""
        self._values = [value for value, _ in rows]
        self._deviations = [deviation for _, deviation in rows]
        self._slopes = [(high - low) / (above - below) for (below, low), (above, high) in pairwise(rows)]

    def disturbed(self, raw: Sequence[float], draws: Sequence[float]) -> tuple[float, ...]:
        """Raw values with noise, for draws of a standard normal distribution; 0 to TOP."""
        values, deviations, slopes = self._values, self._deviations, self._slopes
        lowest, last = values[0], len(slopes) - 1
        disturbed = []
        for value, draw in zip(raw, draws, strict=True):
            if value <= lowest:
                noisy = value + deviations[0] * draw
            else:
                row = bisect_right(values, value) - 1
                row = last if row > last else row
                noisy = value + (deviations[row] + slopes[row] * (value - values[row])) * draw
            disturbed.append(0.0 if noisy < 0.0 else TOP if noisy > TOP else noisy)
        return tuple(disturbed)
