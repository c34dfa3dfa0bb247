"""The figures of the thesis's chapter 4, as data, with what is known to be wrong with them.

One row a figure: its value in the environments 1, 2 and 3, in the unit the row names. None where the thesis
has no figure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

Values = tuple[float | None, float | None, float | None]


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure in the three environments; `doubt` says why it cannot be taken as it stands, if so."""

    values: Values
    unit: str
    doubt: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """A published table: what was measured over how many runs an environment, and its figures by name."""

    number: str
    title: str
    runs: int | None
    figures: Mapping[str, Figure]


def _cm(one: float | None, two: float | None, three: float | None, doubt: str = "") -> Figure:
    return Figure((one, two, three), "cm", doubt)


def _degrees(one: float | None, two: float | None, three: float | None) -> Figure:
    return Figure((one, two, three), "deg")


def _count(one: float, two: float, three: float) -> Figure:
    return Figure((one, two, three), "runs")


_TABLES = (
    Table(
        "4.2",
        "Global maps alone: distance once round",
        10,
        {
            "true loop": _cm(461, 909, 987),
            "distance, greatest": _cm(472, 920, 1005),
            "distance, least": _cm(448, 894, 979),
            "distance, mean": _cm(455, 915, 985),
            "distance, variance": _cm(
                10, 15, 14, "in cm, so it cannot be a variance; not the deviation either"
            ),
            "position error, least": _cm(5, 6, 6),
            "position error, greatest": _cm(12, 11, 18),
            "position error, mean": _cm(8, 9, 10),
        },
    ),
    Table(
        "4.3",
        "Path integration: error after one loop",
        10,
        {
            "position error, greatest": _cm(95, 124, 122),
            "position error, least": _cm(24, 25, 45),
            "position error, mean": _cm(61, 84, 91),
        },
    ),
    Table(
        "4.5",
        "Local maps: error after exploring one",
        6,
        {
            "local maps, mean": Figure((10, 23, 27), "nodes"),
            "position error, greatest": _cm(2.1, 1.8, 2.7),
            "position error, least": _cm(0.3, 0.2, 0.3),
            "position error, mean": _cm(0.6, 0.6, 1.0),
            "heading error, greatest": _degrees(20, 17, 23),
            "heading error, least": _degrees(3, 5, 2),
            "heading error, mean": _degrees(12, 9, 13),
        },
    ),
    Table(
        "4.6",
        "Global maps with local maps: distance once round",
        6,
        {
            "true loop": _cm(461, 909, 987),
            "distance, greatest": _cm(465, 922, 1004),
            "distance, least": _cm(450, 902, 977),
            "distance, mean": _cm(
                451, 910, 984, "environment 1 contradicts its own least and greatest error"
            ),
            "position error, least": _cm(4, 4, 7),
            "position error, greatest": _cm(11, 13, 17),
            "position error, mean": _cm(7, 8, 11),
        },
    ),
    Table(
        "4.12",
        "Five traversals, not corrected by views: distance error",
        None,
        {
            "true distance": Figure((23.05, 45.0, 49.35), "m", "environment 2: five times 9.09 m is 45.45 m"),
            "distance error, least": _cm(17, 25, 26),
            "distance error, greatest": _cm(41, 65, 71),
            "distance error, mean": _cm(32, 46, 49),
        },
    ),
    Table(
        "4.14",
        "Five traversals, corrected by views: runs completed",
        5,
        {"completed": _count(4, 3, 0)},
    ),
    Table(
        "4.15",
        "Five traversals, corrected by views: distance error of the runs completed",
        5,
        {
            "distance error, least": _cm(6, 4, None),
            "distance error, greatest": _cm(11, 8, None),
            "distance error, mean": _cm(7, 6, None),
        },
    ),
    Table(
        "4.16",
        "Position correction",
        5,
        {
            "before correction, mean": _cm(2.0, 2.1, None),
            "after correction, mean": _cm(1.0, 1.1, None),
            "heading error, mean": _degrees(18, 21, None),
        },
    ),
    Table(
        "4.18",
        "Loop closing at three thresholds (table 4.17), of six runs each",
        6,
        {
            "T1, wrong": _count(0, 0, 0),
            "T1, right": _count(1, 0, 0),
            "T1, missed": _count(5, 6, 6),
            "T2, wrong": _count(1, 1, 2),
            "T2, right": _count(4, 3, 2),
            "T2, missed": _count(1, 2, 2),
            "T3, wrong": _count(4, 5, 6),
            "T3, right": _count(2, 1, 0),
            "T3, missed": _count(0, 0, 0),
        },
    ),
)

PUBLISHED: Mapping[str, Table] = MappingProxyType({table.number: table for table in _TABLES})
"""Published tables that have a figure an environment, by number."""

SOM_TRAINING: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "metric, iterations, greatest": (2890, 4345),
        "metric, iterations, least": (1850, 3640),
        "metric, iterations, mean": (2308, 4460),
        "metric, time, mean (s)": (2.0, 4.0),
        "perceptual, iterations, greatest": (1241, 1609),
        "perceptual, iterations, least": (816, 1235),
        "perceptual, time, mean (s)": (390.0, 480.0),
    }
)
"""Table 4.10: (configuration 1, configuration 2). A metric mean exceeds its greatest."""
