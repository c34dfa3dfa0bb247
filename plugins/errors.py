"""What can go wrong with plugins, as exceptions with one common base."""

from __future__ import annotations


class PluginError(Exception):
    """Base of every error about plugins."""


class UnknownPluginError(PluginError, LookupError):
    """A name that no plugin has; the message gives the known ones and the nearest."""


class DuplicatePluginError(PluginError, ValueError):
    """Two plugins claim one name."""


class BrokenPluginError(PluginError, ImportError):
    """A plugin that cannot be imported or is not what it says it is."""


class IsolationError(PluginError, RuntimeError):
    """A plugin's subprocess ended, hangs, or sends what it must not."""
