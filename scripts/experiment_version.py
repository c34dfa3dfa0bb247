"""Names the code that computes results, so that what another version computed is not taken up."""

from __future__ import annotations

import hashlib
from importlib import resources
from importlib.metadata import version

_COMPUTING = ("tolman.world", "tolman.maps", "tolman.agent", "tolman.behaviors", "tolman.scripts")
_MAPPING = (
    "experiment_mapping.py",
    "experiment_probes.py",
    "mapping_run.py",
    "profiles.py",
    "wiring.py",
)
"""Of the scripts only those that mappings depend on: a new layout of the report costs no new runs."""
TRAVERSALS = ("experiment_traversal.py",)
"""What traversals depend on besides."""


def code_version(scripts: tuple[str, ...] = ()) -> str:
    """The package's version and a digest of the source that mappings, and `scripts`, depend on."""
    digest = hashlib.sha256()
    for package in _COMPUTING:
        for entry in sorted(resources.files(package).iterdir(), key=lambda entry: entry.name):
            counts = entry.name in (*_MAPPING, *scripts) if package == "tolman.scripts" else True
            if counts and entry.name.endswith((".py", ".yaml")):
                digest.update(f"{package}/{entry.name}\n".encode())
                digest.update(entry.read_bytes())
    return f"{version('tolman')}+{digest.hexdigest()[:12]}"
