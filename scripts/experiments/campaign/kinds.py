"""Kinds of runs, and which of them each table of the thesis is made of.

Seeds below FIRST_SEED are for tuning; reports use those from there. Half of the runs follow the right wall.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

ENVIRONMENTS = ("env1", "env2", "env3")
FIRST_SEED = 4000
REFERENCE, GLOBAL, LOCAL, UNCORRECTED, CORRECTED = "reference", "global", "local", "uncorrected", "corrected"
KINDS: Mapping[str, str] = MappingProxyType(
    {
        REFERENCE: "mapping without noise",
        GLOBAL: "mapping, no local maps",
        LOCAL: "mapping with local maps",
        UNCORRECTED: "five traversals, not corrected",
        CORRECTED: "five traversals, corrected, local maps driven",
    }
)
"""What each kind of run is called."""
NEEDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "table-4.2": (REFERENCE, GLOBAL),
        "table-4.3": (GLOBAL,),
        "table-4.5": (LOCAL,),
        "table-4.6": (REFERENCE, LOCAL),
        "table-4.10": (LOCAL,),
        "table-4.12": (LOCAL, UNCORRECTED),
        "table-4.14": (LOCAL, CORRECTED),
        "table-4.15": (LOCAL, CORRECTED),
        "table-4.16": (LOCAL, CORRECTED),
        "table-4.18": (LOCAL,),
    }
)
"""The kinds of runs that each table is made of."""
