"""What this package raises and warns of: one line each that says what, where and what would do."""

from __future__ import annotations


class WorldError(ValueError):
    """Anything that is wrong with a world, its description or what is asked of it."""


class UnknownWorldError(WorldError, LookupError):
    """No built-in world and no file has this name."""


class WorldFileError(WorldError):
    """A world file that cannot be read; the message names file, line and key."""


class WorldWarning(UserWarning):
    """Something in a file of another program that has no counterpart here and was left out."""


class PlacementError(WorldError):
    """A robot cannot stand there: it would overlap a wall or another body, or be outside."""


class SimulationError(WorldError, RuntimeError):
    """The simulation cannot go on: a robot tipped or flew off, or its state is not finite."""


class EngineMissingError(WorldError, ImportError):
    """The simulation engine, or a system library that it needs, is not installed."""
