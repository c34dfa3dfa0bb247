"""A simulation: a world with a robot that maps it, finds its way in it, or does what one's own behaviors say.

    with Simulation("env1", seed=3) as simulation:
        report = simulation.map("env1.tolman")           # or simulation.map(): in memory, as report.map
        simulation.go(report.map, to=5)

    with Simulation("env1", behaviors=[Shy()]) as simulation:
        simulation.agent.start("shy")
        while simulation.time < 10:
            simulation.step()

`map_world`, `go_to` and `run_mission` do what the command line's `map`, `go` and `run` ask for. For anything
else make the jobs (`Mapping`, `Trip`, `MissionJob`) on a simulation; let them drive, or step by hand.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...agent import Behavior
from ...agent.missions.mission import Mission
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import read_truth
from ...world import WorldSpec
from ...world.robot import Pose
from .assembly import make_world
from .map_files import MapWriter
from .mapping import Mapping, MapReport
from .mission import MissionJob, MissionReport, attachments
from .profiles import Profile
from .recording import recorded
from .requests import (
    GoRequest,
    MapRequest,
    MissionRequest,
    Progress,
    RunSettings,
    SessionError,
    start_of_mission,
    start_of_trip,
    world_of_trip,
)
from .settings import load_settings
from .site import sites_of
from .stage import Stage
from .trip import GoReport, Trip
from .truth import poses_of

ShowProgress = Callable[[Progress], None]
Watch = Callable[[Stage], None]
"""Is given a session before anything runs, to look on."""


def _silent(progress: Progress) -> None:
    """Tells nobody."""


class Simulation(Stage):
    """A simulated world and its robots, open until `close` or the end of its `with` block.

    The fields of `RunSettings` say what it is made with: seed, noise, profile, plugins, ... `agent` is the
    first robot's. `step` lets one control tick pass, `run` many; `map`, `go` and `mission` do a whole job.
    Whatever ends it, the last command to the wheels is zero.
    """

    def __init__(
        self,
        world: str | Path | WorldSpec,
        settings: RunSettings | None = None,
        *,
        start: Pose | str | None = None,
        behaviors: Iterable[Behavior] = (),
        profile: Profile | str | None = None,
        progress: ShowProgress = _silent,
        watch: Watch | None = None,
        **fields: Any,
    ) -> None:
        """Opens a world: a name, a file or a description.

        settings, fields: what it is made with, as `RunSettings` or one by one.
        start: a pose or the name of a start; None for the world's first.
        behaviors: more behaviors for the robot, besides those that are found.
        profile: a name, or a profile of your own.
        progress: called with how far a job is.
        watch: called with the simulation when it is open, to look on.

        Raises: WorldError, PluginError, ConfigError, SessionError.
        """
        settings = replace(settings or RunSettings(), **fields)
        if profile is not None:
            settings = replace(settings, profile=profile if isinstance(profile, str) else profile.name)
        options = load_settings(settings.config)
        place = str(world) if isinstance(world, Path) else world
        own = profile if isinstance(profile, Profile) else None
        opened = make_world(settings, place, options.get("noise", {}), start)
        super().__init__(opened, settings, options, profile=own, behaviors=behaviors, progress=progress)
        if watch is not None:
            watch(self)

    def map(self, path: Path | str | None = None, **fields: Any) -> MapReport:
        """Maps from where the robot stands, and reports; the report has the map.

        path: the map file, where every node is saved as soon as it is complete; None keeps it in memory.
        fields: those of `MapRequest`, such as side, max_nodes, global_only, islands, resume, force, record.

        Raises: MapError, SessionError; SimulationError for a robot that tips or flies off.
        """
        output = None if path is None else Path(path)
        name = self.world.spec.name
        return self.carry_out(self.request(MapRequest, **{"world": name, "output": output, **fields}))

    def carry_out(self, request: MapRequest) -> MapReport:
        """Maps as a request says that has this session's settings. Raises: as `map`."""
        path = request.output
        before = unfinished(path) if path is not None and request.record and request.resume else {}
        writer: contextlib.AbstractContextManager[MapWriter | None] = contextlib.nullcontext()
        if path is not None:
            writer = MapWriter.open(path, request, self.map_meta(request))
        with writer as kept:
            mapping = Mapping(self, request, writer=kept)
            with recorded(request.record, "map", request, self, before):
                return mapping.drive()

    def go(
        self,
        hybrid_map: HybridMap | Path | str,
        to: int | str,
        *,
        node: int | str | None = None,
        lost: bool = False,
        max_time: float | None = None,
    ) -> GoReport:
        """Drives to a node of a map, by number or name, and reports.

        node: where the robot stands; None for where the map says that it is.
        lost: it is told neither, and has to find out.
        max_time: simulated s after which it gives up.

        Raises: MapError, SessionError.
        """
        truth = self.observers[0].nodes
        if not isinstance(hybrid_map, HybridMap):
            truth = poses_of(read_truth(Path(hybrid_map)))
            hybrid_map = HybridMap.load(hybrid_map)
        meta = hybrid_map.meta
        arrival = meta.side if lost or node is not None else meta.arrival or meta.side
        at = meta.current_node if node is None else hybrid_map.find(node)
        if at is None and not lost:
            raise SessionError("the map does not say where its robot is: name the node, or let it be lost")
        trip = Trip(self, hybrid_map, hybrid_map.find(to))
        limit = math.inf if max_time is None else self.time + max_time
        report = trip.drive(None if lost else at, arrival, truth, limit)
        if report.reached:
            hybrid_map.meta = replace(meta, current_node=trip.goal, arrival=trip.arrival)
        return report

    def mission(self, mission: Mission | Path | str, **fields: Any) -> MissionReport:
        """Runs a mission, from a file or of one's own, and reports.

        fields: those of `MissionRequest`, such as map, global_only, max_time. Raises: MissionError, MapError.
        """
        loaded = mission if isinstance(mission, Mission) else Mission.load(mission)
        path = Path(loaded.name if isinstance(mission, Mission) else mission)
        request = self.request(MissionRequest, **{"mission": path, **fields})
        return MissionJob(self, sites_of(self, request), loaded).drive(request.max_time)


def map_world(request: MapRequest, progress: ShowProgress = _silent, watch: Watch | None = None) -> MapReport:
    """Maps a world as `tolman map` does, saving as it goes, and reports.

    Raises: WorldError, MapError, SessionError, PluginError for a request that cannot be met; before the run.
    """
    start = request.start or request.side
    with Simulation(
        request.world, settings_of(request), start=start, progress=progress, watch=watch
    ) as simulation:
        return simulation.carry_out(request)


def go_to(request: GoRequest, progress: ShowProgress = _silent, watch: Watch | None = None) -> GoReport:
    """Drives to a node of a map as `tolman go` does, and reports.

    Raises: MapError, WorldError, SessionError, PluginError for a request that cannot be met; before the trip.
    """
    hybrid_map, truth = HybridMap.load(request.map), read_truth(request.map)
    goal = hybrid_map.find(request.to)
    world = world_of_trip(request, hybrid_map.meta)
    start = start_of_trip(request, hybrid_map, truth)
    with Simulation(
        world, settings_of(request), start=start.pose, progress=progress, watch=watch
    ) as simulation:
        trip = Trip(simulation, hybrid_map, goal)
        limit = math.inf if request.max_time is None else request.max_time
        with recorded(request.record, "go", request, simulation, {"map": request.map.read_bytes()}):
            report = trip.drive(start.node, start.arrival, poses_of(truth), limit)
        if request.learn:
            trip.learn(request.map)
        return report


def run_mission(
    request: MissionRequest,
    progress: ShowProgress = _silent,
    say: Callable[[str], None] = lambda text: None,
    watch: Watch | None = None,
) -> MissionReport:
    """Runs a mission file as `tolman run` does, and reports. say: is told what the mission says.

    Raises: MissionError, WorldError, MapError, SessionError, PluginError for a request that cannot be met.
    """
    mission = Mission.load(request.mission)
    world, start = start_of_mission(request)
    with Simulation(world, settings_of(request), start=start, progress=progress, watch=watch) as simulation:
        sites = sites_of(simulation, request)
        before = attachments(request)
        job = MissionJob(simulation, sites, mission, request.journal, request.resume, say)
        with recorded(request.record, "mission", request, simulation, before):
            return job.drive(request.max_time)


def settings_of(request: RunSettings) -> RunSettings:
    """The settings in a request, by themselves."""
    return RunSettings(**{name: getattr(request, name) for name in RunSettings.__dataclass_fields__})


def unfinished(path: Path) -> dict[str, bytes]:
    """A map file as it is and what a killed writer left beside it, by name: what a mapping goes on from."""
    beside = {"map": path, "map-wal": path.with_name(f"{path.name}-wal")}
    return {name: file.read_bytes() for name, file in beside.items() if file.is_file()}
