"""Names the code that computes results, so that what another version computed is not taken up."""

from __future__ import annotations

import hashlib
from importlib import resources
from importlib.metadata import version

_COMPUTING = ("tolman.world", "tolman.maps", "tolman.agent", "tolman.behaviors", "tolman.scripts")
_SCRIPTS = (
    "experiment_mapping.py",
    "experiment_probes.py",
    "experiment_traversal.py",
    "mapping_run.py",
    "profiles.py",
    "wiring.py",
)
"""Of the scripts only those that a run's figures depend on: a new layout of the report costs no new runs."""


def code_version() -> str:
    """The package's version and a digest of the source that runs depend on, worlds included."""
    digest = hashlib.sha256()
    for package in _COMPUTING:
        for entry in sorted(resources.files(package).iterdir(), key=lambda entry: entry.name):
            counts = entry.name in _SCRIPTS if package == "tolman.scripts" else True
            if counts and entry.name.endswith((".py", ".yaml")):
                digest.update(f"{package}/{entry.name}\n".encode())
                digest.update(entry.read_bytes())
    return f"{version('tolman')}+{digest.hexdigest()[:12]}"
