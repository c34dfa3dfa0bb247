"""One robot of a mission's world: what the steps ask of mapper, navigator and files is done here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...agent import Agent
from ...agent.errors import MissionError
from ...agent.listener import Outcome
from ...agent.navigation.recovery import RecoveringNavigator
from ...maps.hybrid_map import HybridMap
from ...maps.storage.map_file import MapFile, read_truth
from .assembly import make_navigator
from .mapping import Mapping
from .requests import MapRequest
from .trip import Trip
from .truth import map_truth, poses_of

if TYPE_CHECKING:
    from .requests import MissionRequest
    from .stage import Stage


@dataclass(frozen=True, slots=True)
class Files:
    """What a mission's `Save` and `Load` work on. sandbox: takes all that is saved, for a replay."""

    force: bool = False
    sandbox: Path | None = None

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


class _Job:
    """A mapping or a trip under way, as a mission's step asks after it."""

    def __init__(self, job: Mapping | Trip, ended: Callable[[bool], None]) -> None:
        """ended: called once, when it is over; with False if it was cancelled."""
        self._job, self._ended, self._over = job, ended, False

    @property
    def outcome(self) -> Outcome | None:
        """None while it is under way. Asked once a tick."""
        if self._job.watch():
            self._end(True)
        return self._job.outcome

    def cancel(self, reason: str = "cancelled") -> None:
        """Stops where the robot is."""
        self._job.cancel(reason)
        self._end(False)

    def _end(self, by_itself: bool) -> None:
        if not self._over:
            self._over = True
            self._ended(by_itself)


class RobotSite:
    """One robot's agent, its map and where it is in it: what a mission's steps work on."""

    def __init__(
        self,
        stage: Stage,
        index: int,
        request: MissionRequest,
        files: Files,
        others: Sequence[RobotSite] = (),
    ) -> None:
        """index: of the robot in the world. others: the sites of all robots, this one's too."""
        self.stage, self.index, self.request, self.files = stage, index, request, files
        self.others = others
        self.agent, self.observer = stage.robot(index), stage.observers[index]
        self.map: HybridMap | None = None
        self.guide: RecoveringNavigator | None = None
        self.whereabouts = "no map was made or loaded"
        self._mapping: _Job | None = None

    # --- Site ------------------------------------------------------------------------------------------

    def explore(self, side: str, strategy: str, max_nodes: int | None, islands: bool) -> _Job:
        """Maps from where the robot stands, into a new map."""
        request = self.stage.request(
            MapRequest,
            world=self.stage.world.spec.name,
            side=side,
            global_only=self.request.global_only,
            max_nodes=max_nodes,
            strategy=strategy,
            islands=islands,
        )
        mapping = Mapping(self.stage, request, self.index)
        self._leave()
        self.map = mapping.map
        self.whereabouts = "the mapping is not done"
        self._mapping = job = _Job(mapping, lambda by_itself: self._mapped(mapping, by_itself))
        mapping.begin()
        return job

    def _mapped(self, mapping: Mapping, by_itself: bool) -> None:
        """Takes over what a mapping made; it is at the mapper's current node if that ended by itself."""
        self._mapping = None
        mapper = mapping.mapper
        standing = by_itself and mapper.done
        mapping.cancel("" if mapping.outcome is None else mapping.outcome.reason)
        if mapper.current < 0:
            self.whereabouts = "the mapping found no node"
            if mapping.map.nodes():
                self.whereabouts = "it was lost on a foray"
                self._stand_nowhere()
            return
        mapping.note_current(closed=mapping.loop_correct is not None or mapper.reason == "loop closed")
        self._stand_at(mapper.current, mapping.request.side)
        if not standing and self.guide is not None:
            self.guide.lose()

    def go_to(self, node: int | str) -> _Job:
        """Sets out from where the robot is; it finds that out first if need be.

        Raises: MapError, MissionError.
        """
        if self._mapping is not None and self._mapping.outcome is None:
            raise MissionError("the mapping is still under way: wait for its end before going anywhere")
        goal = self._map().find(node)
        if self.guide is None:
            raise MissionError(f"the robot does not know where it is: {self.whereabouts}")
        if self.guide.under_way:
            raise MissionError("the robot is on its way to another node already")
        trip = Trip(self.stage, self._map(), goal, self.index)
        trip.go_on(self.guide)
        return _Job(trip, lambda by_itself: trip.cancel())

    def save(self, path: str) -> None:
        """Writes the map with the truth beside it, as `tolman map` does. Raises: MapError."""
        hybrid_map = self._map()
        if self._mapping is None:
            node = self.guide.node if self.guide is not None else None
            arrival = self.guide.navigator.arrival if self.guide is not None else None
            hybrid_map.meta = replace(hybrid_map.meta, current_node=node, arrival=arrival)
        graph = hybrid_map.graph
        with MapFile.create(self.files.output(path), hybrid_map.meta, force=self.files.force) as file:
            truth = map_truth(self.observer, graph)
            file.update(hybrid_map, list(graph), list(graph.edges(keys=True)), truth=truth)

    def load(self, path: str) -> None:
        """Takes a saved map over; the robot is taken to stand where its robot was. Raises: MapError."""
        file = self.files.input(path)
        hybrid_map, truth = HybridMap.load(file), read_truth(file)
        self._leave()
        self.map, self.observer.nodes = hybrid_map, poses_of(truth)
        meta = hybrid_map.meta
        if meta.current_node is None:
            self.whereabouts = f"{path} does not say where its robot was"
            self._stand_nowhere()
        else:
            self._stand_at(meta.current_node, meta.arrival or meta.side)

    def nodes(self) -> list[int]:
        """The map's nodes. Raises: MissionError without a map."""
        return sorted(self._map().nodes())

    def place(self, node: int | str) -> int:
        """Puts the robot at a node's true place, where the map's file or this session knows it."""
        number = self._map().find(node)
        if number not in self.observer.nodes:
            raise MissionError(f"nobody knows where node {number} truly is")
        self.stage.world.place(self.observer.nodes[number], self.index)
        self._stand_at(number, self._map().meta.side)
        return number

    def robot(self, index: int) -> tuple[Agent, RobotSite]:
        """Another robot of the world. Raises: LookupError."""
        if not 0 <= index < len(self.others):
            raise LookupError(f"there is no robot {index}; the world has {len(self.others)}")
        return self.others[index].agent, self.others[index]

    # --- after a restart ---------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What a restart needs besides the map, as JSON."""
        guide = self.guide
        return {
            "odometry": self.agent.odometry.state(),
            "node": None if guide is None else guide.node,
            "arrival": None if guide is None else guide.navigator.arrival,
            "near": [] if guide is None else list(guide.near),
            **self.observer.state(),
        }

    def restore(self, state: dict[str, Any], hybrid_map: HybridMap | None) -> None:
        """Goes back to a `state`."""
        self.agent.odometry.restore(state["odometry"])
        self._leave()
        self.map = hybrid_map
        self.observer.restore(state)
        if hybrid_map is None:
            return
        if state["node"] is None:
            self._stand_nowhere(tuple(state["near"]))
        else:
            self._stand_at(int(state["node"]), state["arrival"] or hybrid_map.meta.side)

    # --- inside ----------------------------------------------------------------------------------------

    def _map(self) -> HybridMap:
        if self.map is None:
            raise MissionError("there is no map yet: explore, or load one")
        return self.map

    def _stand_at(self, node: int, arrival: str) -> None:
        """The robot stands at a node of the map there is now."""
        if self.guide is not None:
            self.guide.stand_at(node, arrival)
            return
        navigator = make_navigator(self.stage.profile, self.agent, self._map(), node, arrival)
        localizes = self.stage.profile.navigator == "corners"
        self.guide = RecoveringNavigator(self.agent, self._map(), navigator, localizes=localizes)

    def _stand_nowhere(self, near: tuple[int, ...] = ()) -> None:
        """The robot is somewhere in the map there is now. near: as for `RecoveringNavigator.lose`."""
        nodes = self.nodes()
        if nodes:
            self._stand_at(nodes[0], self._map().meta.side)
        if self.guide is not None:
            self.guide.lose(near)

    def _leave(self) -> None:
        """Puts the map away that there was."""
        if self.guide is not None:
            self.guide.close()
            self.guide = None


def sites_of(stage: Stage, request: MissionRequest, sandbox: Path | None = None) -> tuple[RobotSite, ...]:
    """A site for each robot of the world; the first has the request's map, if any. Raises: MapError."""
    sites: list[RobotSite] = []
    files = Files(request.force, sandbox)
    for index in range(len(stage.world.robots)):
        sites.append(RobotSite(stage, index, request, files, sites))
    if request.map is not None:
        sites[0].load(str(request.map))
    return tuple(sites)
