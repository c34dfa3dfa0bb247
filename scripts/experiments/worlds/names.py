"""Names of the worlds of experiments: a world, then what is done to it.

"env1", "env1 rotated", "epuck_world.wbt", "map.yaml x0.4"; "random 17" or "round 17": the room of that kind
drawn from that seed.
"""

from __future__ import annotations

RANDOM = "random"
NOISIER, NOISE_SCALE = "noisier", 1.5
"""The change that leaves a world as it is, and what all noise is multiplied by there."""


def split(name: str) -> tuple[str, str]:
    """The world's own name, and what is done to it ("" for nothing)."""
    base, _, change = name.partition(" ")
    return base, change


def noise_scale(name: str) -> float:
    """What the noise is multiplied by in the world of that name."""
    return NOISE_SCALE if split(name)[1] == NOISIER else 1.0
