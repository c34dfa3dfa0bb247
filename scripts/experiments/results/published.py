"""The figures of the thesis's chapter 4, as data, for the environments 1, 2 and 3.

Lengths are in cm but where the name says otherwise, headings in degrees. Comments say what is
known to be wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Values = tuple[float | None, float | None, float | None]
"""In the three environments; None where the thesis has no figure."""
NONE: Values = (None, None, None)


@dataclass(frozen=True, slots=True)
class Figure:
    """A published figure; a single value counts as its mean."""

    mean: Values = NONE
    least: Values = NONE
    greatest: Values = NONE


@dataclass(frozen=True, slots=True)
class Table:
    """A published table: figures by name. runs: an environment, None where the thesis does not say."""

    runs: int | None
    figures: Mapping[str, Figure]


_TRUE_LOOP = Figure((461, 909, 987))
PUBLISHED: Mapping[str, Table] = MappingProxyType(
    {
        "4.2": Table(
            10,
            {
                "true loop": _TRUE_LOOP,
                "distance": Figure((455, 915, 985), (448, 894, 979), (472, 920, 1005)),
                # In cm, so it cannot be a variance; it is not the deviation either.
                "distance, variance": Figure((10, 15, 14)),
                "position error": Figure((8, 9, 10), (5, 6, 6), (12, 11, 18)),
            },
        ),
        "4.3": Table(10, {"position error": Figure((61, 84, 91), (24, 25, 45), (95, 124, 122))}),
        "4.5": Table(
            6,
            {
                "local maps": Figure((10, 23, 27)),
                "position error": Figure((0.6, 0.6, 1.0), (0.3, 0.2, 0.3), (2.1, 1.8, 2.7)),
                "heading error": Figure((12, 9, 13), (3, 5, 2), (20, 17, 23)),
            },
        ),
        "4.6": Table(
            6,
            {
                "true loop": _TRUE_LOOP,
                # Environment 1: the mean contradicts its own least and greatest error.
                "distance": Figure((451, 910, 984), (450, 902, 977), (465, 922, 1004)),
                "position error": Figure((7, 8, 11), (4, 4, 7), (11, 13, 17)),
            },
        ),
        "4.12": Table(
            None,
            {
                # Environment 2: five times 9.09 m is 45.45 m.
                "true distance (m)": Figure((23.05, 45.0, 49.35)),
                "distance error": Figure((32, 46, 49), (17, 25, 26), (41, 65, 71)),
            },
        ),
        "4.14": Table(5, {"completed": Figure((4, 3, 0))}),
        "4.15": Table(5, {"distance error": Figure((7, 6, None), (6, 4, None), (11, 8, None))}),
        "4.16": Table(
            5,
            {
                "before correction": Figure((2.0, 2.1, None)),
                "after correction": Figure((1.0, 1.1, None)),
                "heading error": Figure((18, 21, None)),
            },
        ),
        # Loop closing at three thresholds (table 4.17).
        "4.18": Table(
            6,
            {
                "T1, wrong": Figure((0, 0, 0)),
                "T1, right": Figure((1, 0, 0)),
                "T1, missed": Figure((5, 6, 6)),
                "T2, wrong": Figure((1, 1, 2)),
                "T2, right": Figure((4, 3, 2)),
                "T2, missed": Figure((1, 2, 2)),
                "T3, wrong": Figure((4, 5, 6)),
                "T3, right": Figure((2, 1, 0)),
                "T3, missed": Figure((0, 0, 0)),
            },
        ),
    }
)
"""Published tables that have a figure an environment, by number."""

SOM_TRAINING: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "metric, iterations, greatest": (2890, 4345),
        "metric, iterations, least": (1850, 3640),
        "metric, iterations, mean": (2308, 4460),  # configuration 2's mean exceeds its greatest
        "metric, time, mean (s)": (2.0, 4.0),
        "perceptual, iterations, greatest": (1241, 1609),
        "perceptual, iterations, least": (816, 1235),
        "perceptual, time, mean (s)": (390.0, 480.0),
    }
)
"""Table 4.10: (configuration 1, configuration 2)."""
