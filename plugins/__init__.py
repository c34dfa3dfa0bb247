"""Finds, checks, writes and tests plugins: behaviors and mediators from anywhere."""

from .discovery import Catalog, build_behaviors, discover, load_behaviors, load_mediator
from .errors import BrokenPluginError, DuplicatePluginError, PluginError, UnknownPluginError
from .loading import Plugin, plugins_in

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
