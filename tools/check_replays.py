"""Records mapping runs under DART and replays each: all must be identical to the bit.

Run with `python -m tools.check_replays [RUNS]` (20). Sides alternate, every second run is in another
world, every fourth builds local maps. Prints a line a run; the exit status is 1 if any replay differs.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tolman.scripts.session.replay import replay
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.simulation import map_world

WORLDS = ("env1", "env2")
LOCAL = 4
"""Every so many runs local maps are built."""


def request_of(index: int, folder: Path) -> MapRequest:
    """The `index`-th run; its index is its seed."""
    local = index % LOCAL == 0
    return MapRequest(
        seed=index,
        world=WORLDS[0] if local else WORLDS[index % 2],
        output=folder / f"{index}.tolman",
        side=("right", "left")[(index // 2 + index // LOCAL) % 2],
        global_only=not local,
        record=folder / f"{index}.mcap",
    )


def check(index: int) -> bool:
    """Records and replays one run, says how it went, and returns whether the replay was identical."""
    with TemporaryDirectory() as folder:
        request = request_of(index, Path(folder))
        assert request.record is not None
        mapped = map_world(request)
        report = replay(request.record)
    kind = "global only" if request.global_only else f"{mapped.local_maps} local maps"
    what = f"run {index}: {request.world}, {request.side}, {kind}, {mapped.nodes} nodes, {mapped.reason}"
    found = f", {report.difference.text()}" if report.difference is not None else ""
    how = "identical" if report.identical else "DIFFERENT"
    print(f"{what}: {report.ticks} of {report.recorded} ticks {how}{found}", flush=True)
    return report.identical


def main(runs: int) -> int:
    """Checks that many runs."""
    same = sum(check(index) for index in range(runs))
    print(f"{same} of {runs} replays identical to the bit")
    return 0 if same == runs else 1


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 20))
