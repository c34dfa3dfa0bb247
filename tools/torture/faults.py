"""What a campaign must not find."""

from __future__ import annotations

from collections import Counter

FAULTS = (
    "does not open",
    "nodes lost",
    "resumed to other bytes",
    "hangs",
    "crashes",
    "ended the campaign",
    "over the memory limit",
    "nodes matched wrongly",
    "matched across worlds",
    "too few nodes matched",
    "merged to something else",
)


def faults(result: Counter[str]) -> list[str]:
    """The entries of a result that must be zero but are not."""
    prefixes = ("silently wrong", "crafted and loaded", "another exception", "more than one line", "unclear")
    return [name for name, times in result.items() if times and (name in FAULTS or name.startswith(prefixes))]
