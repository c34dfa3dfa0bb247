"""Runs a mission in a simulated world, with an agent for each of the world's robots."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...agent.errors import MissionError
from ...agent.missions.journal import Journal
from ...agent.missions.mission import Mission, MissionRunner
from ...agent.missions.steps import Explore
from ...maps.errors import MapError
from ...maps.hybrid_map import HybridMap
from ...maps.meta import MapMeta
from ...maps.storage.map_file import read_truth
from ...plugins.discovery import isolating
from ...world import World
from ...world.robot import Pose
from .assembly import make_world
from .mission_requests import MissionReport, MissionRequest
from .mission_site import RobotSite
from .record_run import recorded
from .requests import MapRequest, Progress
from .settings import load_settings

JOURNAL = "journal"
"""What attachments of a recording are called that are a resumed mission's journal, before their ending."""
_KEPT = re.compile(r"\.state|\.\d+\.tolman")
"""Endings of what stands beside a journal."""


class MissionSession:
    """A world, an agent for each of its robots, and a mission on the first."""

    def __init__(
        self, request: MissionRequest, world: World, settings: dict[str, Any], sandbox: Path | None = None
    ) -> None:
        """Everything but the mission. sandbox: a folder that takes what `Save` writes, for a replay."""
        self.request, self.world, self.settings, self.sandbox = request, world, settings, sandbox
        self.sites = [RobotSite(self, index) for index in range(len(world.robots))]
        if request.map is not None:
            self.sites[0].load(str(request.map))

    def output(self, path: str) -> Path:
        """Where `Save` writes what it is to write at `path`."""
        if self.sandbox is None:
            return Path(path)
        self.sandbox.mkdir(exist_ok=True)
        return self.sandbox / sha256(path.encode()).hexdigest()

    def input(self, path: str) -> Path:
        """Where `Load` finds what stands at `path`."""
        written = self.output(path)
        return written if written.exists() else Path(path)

    def meta(self, side: str) -> MapMeta:
        """What a map made here says about itself."""
        request, world = self.request, self.world
        return MapMeta(
            world=world.spec.name,
            world_digest=world.spec.digest,
            profile=request.profile,
            side=side,
            seed=request.seed,
            noise=request.noise,
            versions={"tolman": version("tolman")},
            geometry=world.robots[0].geometry.name,
            scalars={"noise_scale": request.noise_scale, "robot_model": request.model},
        )

    def map_request(self, step: Explore) -> MapRequest:
        """The step as a request for a mapping."""
        request = self.request
        return MapRequest(
            seed=request.seed,
            noise=request.noise,
            profile=request.profile,
            world=self.world.spec.name,
            output=Path("unused.tolman"),
            side=step.side,
            global_only=request.global_only,
            max_nodes=step.max_nodes,
            strategy=step.strategy,
            islands=step.islands,
        )

    # --- after a restart ---------------------------------------------------------------------------------

    def keep(self) -> None:
        """Writes beside the journal all that `restore` needs; called before each line of the journal."""
        journal = self.request.journal
        if journal is None:
            return
        for index, site in enumerate(self.sites):
            if site.map is not None:
                site.map.save(_beside(journal, f".{index}.tolman"), force=True)
        state = {
            "world": dict(self.world.state()),
            "sites": [{**site.state(), "has_map": site.map is not None} for site in self.sites],
        }
        partial = _beside(journal, ".partial")
        partial.write_text(json.dumps(state), encoding="utf-8")
        os.replace(partial, _beside(journal, ".state"))

    def restore(self) -> None:
        """Goes back to what `keep` wrote last, if it ever did. Raises: MissionError, MapError."""
        journal = self.request.journal
        if journal is None or not _beside(journal, ".state").exists():
            return
        path = _beside(journal, ".state")
        try:
            state = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as fault:
            raise MissionError(f"{path}: damaged ({fault}); begin anew without --resume") from fault
        self.world.restore(state["world"])
        for index, (site, kept) in enumerate(zip(self.sites, state["sites"], strict=True)):
            known = HybridMap.load(_beside(journal, f".{index}.tolman")) if kept["has_map"] else None
            site.restore(kept, known)

    # --- running -----------------------------------------------------------------------------------------

    def run(self, mission: Mission, journal: Journal, progress: Callable[[Progress], None]) -> MissionReport:
        """Ticks until the mission has ended; cancels it when its time is up or the user interrupts."""
        site, world, limit = self.sites[0], self.world, self.request.max_time
        runner = MissionRunner(mission, site.agent, site, journal)
        runner.start()
        told = -1.0
        try:
            while not runner.ended:
                for each in self.sites:
                    each.agent.tick()
                if limit is not None and world.time >= limit:
                    runner.stop(f"not done within {limit:g} s")
                world.step()
                if world.time - told >= 1.0:
                    told = world.time
                    nodes = site.map.graph.number_of_nodes() if site.map is not None else 0
                    progress(Progress(told, nodes, runner.doing))
        except KeyboardInterrupt:
            runner.stop("interrupted")
        for each in self.sites:
            each.agent.tick()  # so that the wheels rest and the last events are heard
            each.agent.close()
        return MissionReport(
            mission=mission.name,
            status=runner.status.value,
            reason=runner.reason,
            steps_done=len(journal),
            sim_time_s=world.time,
            collisions=world.collisions(),
            seed=self.request.seed,
        )


def run_mission(
    request: MissionRequest, progress: Callable[[Progress], None] = lambda progress: None
) -> MissionReport:
    """Runs a mission file and reports.

    Raises: MissionError, WorldError, MapError, SessionError, PluginError for a request that cannot be met.
    """
    mission = Mission.load(request.mission)
    settings = load_settings(request.config)
    if request.isolate:
        settings["behaviors"] = isolating(settings.get("behaviors"), request.plugins)
    world = make_world(request, request.world or _world_of(request), settings, _start(request))
    try:
        session = MissionSession(request, world, settings)
        before = _attachments(request)
        journal = Journal(request.journal, mission=mission.name, resume=request.resume, before=session.keep)
        if request.resume and len(journal):
            session.restore()
        agent, *others = [site.agent for site in session.sites]
        with recorded(request.record, "mission", request, agent, world, before, others):
            return session.run(mission, journal, progress)
    finally:
        world.close()


def _world_of(request: MissionRequest) -> str:
    if request.map is None:
        raise MissionError("say in which world the mission runs (--world), or give a map (--map)")
    return HybridMap.load(request.map).meta.world


def _start(request: MissionRequest) -> Pose | str | None:
    if request.map is None:
        return request.start
    run = read_truth(request.map).run
    if "pose" not in run:
        raise MapError(f"{request.map}: the file does not say where its robot was")
    return Pose(*run["pose"])


def _attachments(request: MissionRequest) -> dict[str, bytes]:
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
