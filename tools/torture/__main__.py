"""Stresses map files: `python -m tools.torture kills|mutations|commands|full|readonly|plugins|pairs|all`.

Exit status 1 on a fault. POSIX only.

kills: a process that maps is killed (SIGKILL) at random moments; what it had reported as saved must be there.
mutations: damaged and crafted files; each must be refused with one line or load what it truly held.
full: the disk runs full; one clear error, and the last good state stays.
readonly: the folder cannot be written; one clear error, the map in it can be read.
commands: files crafted under checksums that hold, through load, info, validate, recover, export, plot; each
must be refused with one line or be well-formed.
plugins: missions with plugins that misbehave, in the process and isolated; each must be contained or end the
run in one line, with wheels at rest and the map intact.
pairs: maps of one world from different starts and sides; their nodes must be matched, other worlds' refused.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from .commands import commands
from .disks import full, readonly
from .faults import faults
from .kills import kills
from .mutations import mutations
from .pairs import pairs
from .plugins import plugins


def main() -> int:
    """Runs the campaigns named on the command line and prints what happened."""
    parser = argparse.ArgumentParser(prog="torture", description=__doc__)
    names = ["kills", "mutations", "commands", "full", "readonly", "pairs", "plugins", "all"]
    parser.add_argument("campaign", choices=names)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--mutations", type=int, default=10_000)
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--local-maps", type=int, default=2, help="maps of the pairs that have local maps")
    parser.add_argument("--every", type=int, default=1, help="take one of so many faults of plugins")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        campaigns: dict[str, Callable[[], Counter[str]]] = {
            "kills": lambda: kills(options.kills, options.seed, Path(name)),
            "mutations": lambda: mutations(options.mutations, options.seed, Path(name)),
            "commands": lambda: commands(options.mutations, options.seed, Path(name)),
            "full": lambda: full(Path(name)),
            "readonly": lambda: readonly(Path(name)),
            "plugins": lambda: plugins(Path(name) / "plugins", options.every),
            "pairs": lambda: pairs(Path(name), options.pairs, options.seed, options.local_maps),
        }
        for campaign, run in campaigns.items():
            if options.campaign in (campaign, "all"):
                result = run()
                for text, times in sorted(result.items()):
                    print(f"{campaign}: {text}: {times}")
                wrong += faults(result)
    if wrong:
        print(f"faults: {', '.join(wrong)}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
