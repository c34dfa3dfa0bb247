"""What profile `default` is to reach, as data (the table of targets that the project started from)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Three = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Target:
    """Limits in the three environments, in the figure's unit: of the mean, of the worst; None: no limit.

    least: of the mean from below. text: how it reads, when the numbers alone do not say it.
    """

    mean: Three | None = None
    worst: Three | None = None
    least: Three | None = None
    text: str = ""

    def describe(self, environment: int) -> str:
        """The limits for one environment (0 to 2) in a few characters."""
        if self.text:
            return self.text
        parts = []
        if self.least is not None and self.mean is not None:
            parts.append(f"mean {self.least[environment]:g} to {self.mean[environment]:g}")
        elif self.mean is not None:
            parts.append(f"mean ≤ {self.mean[environment]:g}")
        if self.worst is not None:
            parts.append(f"worst ≤ {self.worst[environment]:g}")
        return ", ".join(parts)

    def reached(self, environment: int, mean: float, worst: float) -> bool:
        """Whether a mean and a worst value keep within the limits."""
        return (
            (self.mean is None or mean <= self.mean[environment])
            and (self.worst is None or worst <= self.worst[environment])
            and (self.least is None or mean >= self.least[environment])
        )


def _all(value: float) -> Three:
    return (value, value, value)


TARGETS: Mapping[tuple[str, str], Target] = MappingProxyType(
    {
        ("4.2", "position error"): Target((1.0, 1.5, 1.5), _all(4.0)),
        ("4.2", "nodes"): Target((12.0, 25.0, 29.0), least=(8.0, 21.0, 25.0)),
        ("4.3", "path integration error"): Target(
            (85.4, 117.6, 127.4), least=(36.6, 50.4, 54.6), text="mean within 40 % of the published"
        ),
        ("4.5", "position error after exploring"): Target(_all(0.5), _all(1.5)),
        ("4.5", "heading error after exploring"): Target(_all(1.5), _all(5.0)),
        ("4.6", "position error"): Target((1.0, 1.5, 1.5), _all(4.0)),
        ("4.12", "position error at the end"): Target(_all(1.0), _all(3.0)),
        ("4.12", "growth a traversal"): Target(_all(0.1)),
        ("4.15", "position error at the end"): Target(_all(1.0), _all(3.0)),
        ("4.16", "position error after correction"): Target(_all(0.7)),
        ("4.16", "heading error on local entry"): Target(_all(1.0)),
        ("4.16", "heading error, 95th percentile"): Target(_all(3.0)),
    }
)
"""By table and figure."""
