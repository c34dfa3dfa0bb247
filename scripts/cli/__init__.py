"""The command line: `main` is the command `tolman`."""

from .program import main

__all__ = ["main"]
