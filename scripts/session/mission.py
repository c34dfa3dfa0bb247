"""A mission as a job of a session: run on the first robot, and kept beside its journal for a restart."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...agent.codec import encode
from ...agent.containment import describe
from ...agent.errors import CodecError, MissionError
from ...agent.missions.journal import Journal
from ...agent.missions.mission import Mission, MissionRunner
from ...files.reading import read_text
from ...maps.errors import MapError
from ...maps.hybrid_map import HybridMap
from ..plain import report_values

if TYPE_CHECKING:
    from .requests import MissionRequest
    from .site import RobotSite
    from .stage import Stage

JOURNAL = "journal"
"""What attachments of a recording are called that are a resumed mission's journal, before their ending."""
MAX_STATE = 10_000_000
"""Bytes of the largest state that is read."""
_KEPT = re.compile(r"\.state|\.\d+\.tolman")
"""Endings of what stands beside a journal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionReport:
    """How a mission ended. status: done, failed or cancelled. said, result: what it told and returned."""

    mission: str
    status: str
    reason: str
    steps_done: int
    sim_time_s: float
    collisions: int
    seed: int
    said: tuple[str, ...] = ()
    result: Any = None

    def to_json(self) -> dict[str, Any]:
        """The fields as a dict of JSON values."""
        return report_values(self)


class MissionJob:
    """A mission on the first robot of a session: `drive` it, or `begin`, `watch` and `report`.

    Knows where its journal is, and keeps beside it what a restart needs.
    """

    def __init__(
        self,
        stage: Stage,
        sites: Sequence[RobotSite],
        mission: Mission,
        journal: Path | None = None,
        resume: bool = False,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        """journal: where done steps are kept; resume: go on from there. say: is told what the mission says.

        Raises: MissionError, MapError.
        """
        self.stage, self.sites, self.mission = stage, sites, mission
        self._path, self._say = journal, say
        self.journal = Journal(journal, mission=mission.name, resume=resume, before=self.keep)
        if resume and len(self.journal):
            self._restore()

    # --- running -----------------------------------------------------------------------------------------

    def begin(self) -> None:
        """Starts the mission; its steps are resumed in the agent's ticks."""
        site = self.sites[0]
        self.runner = MissionRunner(self.mission, site.agent, site, self.journal, self._say)
        self.runner.start()

    def watch(self) -> bool:
        """Whether it is over."""
        return self.runner.done

    def cancel(self, reason: str = "cancelled") -> None:
        """Ends it now: stops what its steps started, runs its `finally` blocks."""
        self.runner.stop(reason)

    def drive(self, max_time: float | None = None) -> MissionReport:
        """Runs it to its end; cancels it at the simulated time `max_time` (s) or when the user interrupts."""
        self.begin()
        limit = float("inf") if max_time is None else max_time
        try:
            if not self.stage.run(self.watch, limit=limit, doing=self._doing):
                self.cancel(self.stage.trouble or f"not done within {limit:g} s")
        except KeyboardInterrupt:
            self.cancel("interrupted")
        self.stage.halt()
        return self.report()

    def _doing(self) -> tuple[int, str]:
        hybrid_map = self.sites[0].map
        return 0 if hybrid_map is None else hybrid_map.graph.number_of_nodes(), self.runner.doing

    def report(self) -> MissionReport:
        """How it stands or ended."""
        outcome = self.runner.outcome
        return MissionReport(
            mission=self.mission.name,
            status=self.runner.status.value,
            reason=self.runner.reason,
            steps_done=len(self.journal),
            sim_time_s=self.stage.time,
            collisions=self.stage.world.collisions(),
            seed=self.stage.settings.seed,
            said=tuple(self.runner.said),
            result=None if outcome is None else _as_json(outcome.result),
        )

    # --- after a restart ---------------------------------------------------------------------------------

    def keep(self) -> None:
        """Writes beside the journal all that a restart needs; called before each line of the journal."""
        journal = self._path
        if journal is None:
            return
        for index, site in enumerate(self.sites):
            if site.map is not None:
                site.map.save(_beside(journal, f".{index}.tolman"), force=True)
        state = {
            "world": dict(self.stage.world.state()),
            "sites": [{**site.state(), "has_map": site.map is not None} for site in self.sites],
        }
        partial = _beside(journal, ".partial")
        partial.write_text(json.dumps(state), encoding="utf-8")
        os.replace(partial, _beside(journal, ".state"))

    def _restore(self) -> None:
        """Goes back to what `keep` wrote last, if it ever did. Raises: MissionError, MapError."""
        journal = self._path
        if journal is None or not _beside(journal, ".state").exists():
            return
        path = _beside(journal, ".state")
        text = read_text(path, MAX_STATE, MissionError)
        try:
            state = json.loads(text)
            self.stage.world.restore(state["world"])
            for index, (site, kept) in enumerate(zip(self.sites, state["sites"], strict=True)):
                known = HybridMap.load(_beside(journal, f".{index}.tolman")) if kept["has_map"] else None
                site.restore(kept, known)
        except (TypeError, ValueError, LookupError, AttributeError, RecursionError) as fault:
            if isinstance(fault, MapError):
                raise
            problem = f"damaged ({describe(fault)})"
            raise MissionError(f"{path}: {problem}; begin again without --resume") from fault


def _as_json(result: Any) -> Any:
    """What a mission returned, in JSON's own types."""
    try:
        return _untagged(encode(result))
    except CodecError as fault:
        return f"cannot be told: {fault}"


def _untagged(value: Any) -> Any:
    if isinstance(value, dict) and "$tuple" in value:
        value = value["$tuple"]
    if isinstance(value, dict):
        return {name: _untagged(item) for name, item in value.items()}
    return [_untagged(item) for item in value] if isinstance(value, list) else value


def attachments(request: MissionRequest) -> dict[str, bytes]:
    """The files a mission begins with, by name: of one that is resumed also those beside its journal."""
    files = {"mission": request.mission, "map": request.map}
    kept = {name: path.read_bytes() for name, path in files.items() if path is not None}
    journal = request.journal
    if journal is not None and request.resume and journal.exists():
        kept[JOURNAL] = journal.read_bytes()
        for path in sorted(journal.parent.iterdir()):
            ending = path.name.removeprefix(journal.name)
            if ending != path.name and _KEPT.fullmatch(ending):
                kept[JOURNAL + ending] = path.read_bytes()
    return kept


def _beside(path: Path, ending: str) -> Path:
    return path.with_name(path.name + ending)
