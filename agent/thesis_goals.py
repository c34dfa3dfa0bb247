"""What profile `thesis` asks of behaviors that profile `default` does not."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LookAround:
    """Turn in place by `turn` (rad, counter-clockwise); then, if `views`, take a four-directional image.

    The image's views are ahead, left, behind and right of where the robot points after the turn; it ends
    pointing there again.
    """

    turn: float = 0.0
    views: bool = True
