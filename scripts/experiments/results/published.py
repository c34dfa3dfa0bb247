"""The figures of the thesis's chapter 4, as data: of each, its value in the environments 1, 2 and 3.

Lengths are in cm but where the name says otherwise, headings in degrees. None where the thesis has no figure.
Comments say what is known to be wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Values = tuple[float | None, float | None, float | None]


@dataclass(frozen=True, slots=True)
class Table:
    """A published table. runs: an environment, None where the thesis does not say."""

    runs: int | None
    figures: Mapping[str, Values]


PUBLISHED: Mapping[str, Table] = MappingProxyType(
    {
        "4.2": Table(
            10,
            {
                "true loop": (461, 909, 987),
                "distance, greatest": (472, 920, 1005),
                "distance, least": (448, 894, 979),
                "distance, mean": (455, 915, 985),
                # In cm, so it cannot be a variance; it is not the deviation either.
                "distance, variance": (10, 15, 14),
                "position error, least": (5, 6, 6),
                "position error, greatest": (12, 11, 18),
                "position error, mean": (8, 9, 10),
            },
        ),
        "4.3": Table(
            10,
            {
                "position error, greatest": (95, 124, 122),
                "position error, least": (24, 25, 45),
                "position error, mean": (61, 84, 91),
            },
        ),
        "4.5": Table(
            6,
            {
                "local maps, mean": (10, 23, 27),
                "position error, greatest": (2.1, 1.8, 2.7),
                "position error, least": (0.3, 0.2, 0.3),
                "position error, mean": (0.6, 0.6, 1.0),
                "heading error, greatest": (20, 17, 23),
                "heading error, least": (3, 5, 2),
                "heading error, mean": (12, 9, 13),
            },
        ),
        "4.6": Table(
            6,
            {
                "true loop": (461, 909, 987),
                "distance, greatest": (465, 922, 1004),
                "distance, least": (450, 902, 977),
                # Environment 1 contradicts its own least and greatest error.
                "distance, mean": (451, 910, 984),
                "position error, least": (4, 4, 7),
                "position error, greatest": (11, 13, 17),
                "position error, mean": (7, 8, 11),
            },
        ),
        "4.12": Table(
            None,
            {
                # Environment 2: five times 9.09 m is 45.45 m.
                "true distance (m)": (23.05, 45.0, 49.35),
                "distance error, least": (17, 25, 26),
                "distance error, greatest": (41, 65, 71),
                "distance error, mean": (32, 46, 49),
            },
        ),
        "4.14": Table(5, {"completed": (4, 3, 0)}),
        "4.15": Table(
            5,
            {
                "distance error, least": (6, 4, None),
                "distance error, greatest": (11, 8, None),
                "distance error, mean": (7, 6, None),
            },
        ),
        "4.16": Table(
            5,
            {
                "before correction, mean": (2.0, 2.1, None),
                "after correction, mean": (1.0, 1.1, None),
                "heading error, mean": (18, 21, None),
            },
        ),
        # Loop closing at three thresholds (table 4.17).
        "4.18": Table(
            6,
            {
                "T1, wrong": (0, 0, 0),
                "T1, right": (1, 0, 0),
                "T1, missed": (5, 6, 6),
                "T2, wrong": (1, 1, 2),
                "T2, right": (4, 3, 2),
                "T2, missed": (1, 2, 2),
                "T3, wrong": (4, 5, 6),
                "T3, right": (2, 1, 0),
                "T3, missed": (0, 0, 0),
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
