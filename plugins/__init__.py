"""Finds, checks, writes and tests plugins: behaviors and mediators from anywhere."""

from .discovery import Catalog, Plugin, build_behaviors, discover, load_behaviors, load_mediator, plugins_in
from .errors import BrokenPluginError, DuplicatePluginError, PluginError, UnknownPluginError

__all__ = [
    "BrokenPluginError",
    "Catalog",
    "DuplicatePluginError",
    "Plugin",
    "PluginError",
    "UnknownPluginError",
    "build_behaviors",
    "discover",
    "load_behaviors",
    "load_mediator",
    "plugins_in",
]
