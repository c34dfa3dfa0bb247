"""The two sides by which walls are followed, and by which arcs are named."""

from __future__ import annotations


def other_side(side: str) -> str:
    """The side by which one comes back: "left" for "right" and the other way round."""
    return "left" if side == "right" else "right"
