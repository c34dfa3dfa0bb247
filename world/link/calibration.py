"""What was measured of one robot: its infrared sensors' gains and offsets, its track. A YAML file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from ...files.reading import read_text
from ...files.writing import write_bytes
from ...files.yaml_nodes import parse_yaml
from ..errors import WorldError
from ..robot import RobotGeometry

LIMIT = 1 << 16
"""Bytes of a file of calibrations."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """gains, offsets: by infrared sensor, see `freed`. track: true over published track."""

    gains: tuple[float, ...] = (1.0,) * 8
    offsets: tuple[float, ...] = (0.0,) * 8
    track: float = 1.0

    def freed(self, raw: tuple[float, ...]) -> tuple[float, ...]:
        """The raw values that the published response would have given, 0 to 4095."""
        return tuple(
            min(4095.0, max(0.0, (value - offset) / gain))
            for value, offset, gain in zip(raw, self.offsets, self.gains, strict=True)
        )

    def geometry(self, published: RobotGeometry) -> RobotGeometry:
        """The robot's sizes with the track that was measured."""
        return replace(published, track=published.track * self.track)

    def save(self, path: Path, force: bool = False) -> None:
        """Writes the file. Raises: FileError."""
        rows = {"gains": self.gains, "offsets": self.offsets}
        text = "".join(
            f"{name}: [{', '.join(f'{each:.4f}' for each in row)}]\n" for name, row in rows.items()
        )
        write_bytes(path, f"{text}track: {self.track:.5f}\n".encode(), replace=force)


def load_calibration(path: Path) -> Calibration:
    """Reads a file that `save` wrote, or an owner. Raises: WorldError naming file, line and key."""
    document = parse_yaml(read_text(path, LIMIT, WorldError), str(path), WorldError)
    entries = document.mapping(("gains", "offsets", "track"))
    limits = {"gains": (0.1, 10.0), "offsets": (-4095.0, 4095.0)}
    rows = {name: entries[name].numbers(8, *limits[name]) for name in limits if name in entries}
    track = entries["track"].number(0.5, 2.0) if "track" in entries else 1.0
    return Calibration(**rows, track=track)
