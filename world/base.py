"""What every world offers, whatever computes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, Self

from .robot import Pose, Robot
from .spec import WorldSpec


class World(Protocol):
    """A simulated world with its robots. Ground truth is reached only here, never through a `Robot`."""

    @property
    def spec(self) -> WorldSpec:
        """The description the world was built from."""

    @property
    def seed(self) -> int:
        """The seed that all noise of this run comes from."""

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""

    @property
    def robots(self) -> Sequence[Robot]:
        """The robots, in the order in which they were placed; the first is the explorer."""

    def step(self) -> None:
        """Lets one control tick (32 ms) pass and samples the sensors.

        Raises: SimulationError when a robot tips, leaves the world or its state is not finite.
        """

    def true_pose(self, robot: int = 0) -> Pose:
        """Where a robot really is, in the world's frame (m, rad)."""

    def collisions(self, robot: int = 0) -> int:
        """Ticks so far in which a robot's shell touched something."""

    def clearance(self, x: float, y: float) -> float:
        """Distance (m) from a point to the nearest static shape; negative inside one."""

    def place(self, pose: Pose, robot: int = 0) -> None:
        """Puts a robot somewhere else, at rest; its encoders go on counting from where they were.

        Raises: PlacementError when it would overlap a wall or another body.
        """

    def state(self) -> Mapping[str, Any]:
        """All that changes as time passes, as plain numbers, strings, lists and dicts (JSON can hold it)."""

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a state: what follows is the same to the bit.

        Raises: WorldError when the state belongs to another world or another kind of world.
        """

    def close(self) -> None:
        """Frees what the simulation holds. Stepping afterwards raises WorldError."""

    def __enter__(self) -> Self:
        """The world itself, which `with` closes at its end."""

    def __exit__(self, *_: object) -> None:
        """Closes the world."""
