"""Study `variants`: do the targets hold in rooms turned, mirrored, scaled or imported, and with more noise?

Each map is driven by runs of its own: a map a seed, then its five traversals without and with local maps.
"""

from __future__ import annotations

from ..campaign.campaign import Job
from ..campaign.kinds import ENVIRONMENTS
from ..results.scores import SCORES, Runs, driven, kept, runs_table, with_failures
from ..worlds.named import CHANGES
from ..worlds.names import NOISE_SCALE, split
from .study import Asked, MapAndDrive, Results, Study, mappings_of

RUNS = 2
"""Runs a world where not asked otherwise: one a side."""


def worlds(asked: Asked) -> list[str]:
    """The variants of the environments, and the imported worlds."""
    return [f"{world} {change}" for change in CHANGES for world in asked.environments] + list(asked.imported)


def _mappings(asked: Asked) -> dict[str, list[Job]]:
    """Imported worlds get no local maps, to save time."""
    return {
        world: mappings_of(world, asked, RUNS, local_maps=world not in asked.imported)
        for world in worlds(asked)
    }


_DRIVES = MapAndDrive(_mappings, lambda world: (False, True))


def _kept(world: str, runs: Runs) -> str:
    """Held against the published figures of the world's environment, or of the third for other worlds."""
    base = split(world)[0]
    beyond = kept(runs, ENVIRONMENTS.index(base) if base in ENVIRONMENTS else 2)
    return ("**no**: " + ", ".join(beyond) if beyond else "yes") if runs.maps else ""


def _report(asked: Asked, results: Results) -> str:
    found = _DRIVES.found(asked, results)
    text = (
        f"The whole chain with profile `default`, {asked.runs or RUNS} runs a world (seeds from "
        f"{asked.first_seed}, the sides in turn): mapping with local maps, then five traversals of each "
        "map without and with local maps driven (imported worlds: without local maps). *rotated*: by 17 "
        f"degrees; *smaller*, *larger*: by 20 %; *noisier*: all noise {NOISE_SCALE:g} times the preset. "
        "Cells: mean (worst) over runs, nodes or places; the last columns count completed runs of five "
        "traversals. *Kept*: every mean is within the target plus a third of its margin over the "
        "published figure, every loop closed rightly (or called ambiguous), no run lost."
    )
    columns = {
        "not corrected": lambda world, runs: driven(runs.uncorrected),
        "corrected": lambda world, runs: driven(runs.corrected),
        "kept": _kept,
    }
    table = runs_table("world", found, [score.name for score in SCORES], columns)
    return with_failures([text, table], found)


VARIANTS = Study(
    "variants", "Variants of the environments, and imported worlds", _DRIVES.stages, _report, _DRIVES.values
)
