"""One robot of a mission's world: here is done what the steps ask of mapper, navigator and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...agent import Agent
from ...agent.errors import MissionError
from ...agent.events import CornerReached, Event, LocalMapBuilt, NodeCreated, Stuck
from ...agent.goals import LocalSamples
from ...agent.listener import Outcome
from ...agent.mapping.base import AnyMapper, ArcKey
from ...agent.missions.steps import Explore
from ...agent.navigation.recovery import RecoveringNavigator
from ...maps.hybrid_map import HybridMap
from ...maps.local.local_map import LocalMap
from ...maps.storage.map_file import RUN, MapFile, read_truth
from ...world.robot import Pose
from .assembly import make_agent
from .profiles import find_profile, make_mapper, make_navigator
from .truth import node_truth, run_truth

if TYPE_CHECKING:
    from .mission_session import MissionSession


NO_CORNER_WITHIN = 30.0
"""Meters of driving without a corner after which a mapping is given up."""
_MAPPING = ("wall-following", "reactive-wall-following", "local-exploration", "position-correction")
"""The behaviors by which mappers drive."""


class Mapping:
    """A mapping under way, as a mission's job."""

    def __init__(self, site: RobotSite, mapper: AnyMapper, side: str) -> None:
        """Begins it."""
        self.site, self.mapper, self.side = site, mapper, side
        self._stuck = ""
        self._corner_at = site.agent.odometry.travelled
        bus = site.agent.bus
        self._subscriptions = [
            bus.subscribe(Stuck, self._on_stuck),
            bus.subscribe(CornerReached, self._on_corner),
            bus.subscribe(LocalMapBuilt, self._on_corner),
        ]
        mapper.start()

    @property
    def outcome(self) -> Outcome | None:
        """Done when the mapper is, or when it cannot go on."""
        travelled = self.site.agent.odometry.travelled - self._corner_at
        if not self.mapper.done and self._stuck:
            self.cancel(f"stuck: {self._stuck}")
            return Outcome(False, reason=self.mapper.reason)
        if not self.mapper.done and travelled > NO_CORNER_WITHIN:
            self.cancel(f"no corner within {NO_CORNER_WITHIN:.0f} m")
            return Outcome(False, reason=self.mapper.reason)
        if not self.mapper.done:
            return None
        self._close()
        return Outcome(True, self.mapper.reason, self.mapper.reason)

    def cancel(self, reason: str = "cancelled") -> None:
        """Stops where the robot is."""
        if not self.mapper.done:
            self.mapper.stop(reason)
        agent = self.site.agent
        for name in _MAPPING:
            if name in agent.behaviors and agent.is_active(name):
                agent.stop(name)
        self._close(standing=False)

    def _close(self, standing: bool = True) -> None:
        """Hands the map over, once. standing: whether the robot is at the mapper's node."""
        subscriptions, self._subscriptions = self._subscriptions, []
        for subscription in subscriptions:
            subscription.cancel()
        if subscriptions:
            self.site.mapped(self.mapper, self.side, standing)

    def _on_stuck(self, event: Stuck) -> None:
        if event.given_up:
            self._stuck = event.reason

    def _on_corner(self, event: Event) -> None:
        self._corner_at = self.site.agent.odometry.travelled


@dataclass(slots=True)
class Trip:
    """A trip under way, as a mission's job."""

    guide: RecoveringNavigator

    @property
    def outcome(self) -> Outcome | None:
        """Done when the guide is."""
        guide = self.guide
        return Outcome(guide.reached, guide.navigator.node, guide.reason) if guide.done else None

    def cancel(self) -> None:
        """Stops where the robot is; the next trip goes on from there."""
        self.guide.stop()


class RobotSite:
    """One robot's agent, its map and where it is in it: what a mission's steps work on.

    Knows the truth of where nodes are, to save it beside the map; the agent does not.
    """

    def __init__(self, session: MissionSession, index: int) -> None:
        """index: of the robot in the world."""
        request = session.request
        self.session, self.index = session, index
        self.agent = make_agent(request, session.world, session.settings, index)
        self.map: HybridMap | None = None
        self.guide: RecoveringNavigator | None = None
        self.whereabouts = "no map was made or loaded"
        self._mapping: Mapping | None = None
        self.truth: dict[int, Pose] = {}
        self._met: dict[int, Pose] = {}
        self.agent.bus.subscribe(CornerReached, self._on_corner)
        self.agent.bus.subscribe(NodeCreated, self._on_node)

    # --- Site ------------------------------------------------------------------------------------------

    def explore(self, step: Explore) -> Mapping:
        """Maps from where the robot stands, into a new map."""
        request = self.session.map_request(step)
        profile = find_profile(request.profile)
        hybrid_map = HybridMap(self.session.meta(step.side))
        mapper = make_mapper(profile, request, self.agent, hybrid_map, self)
        self.map, self.truth = hybrid_map, {}
        self._leave()
        self.whereabouts = "the mapping is not done"
        self._mapping = Mapping(self, mapper, step.side)
        return self._mapping

    def mapped(self, mapper: AnyMapper, side: str, standing: bool) -> None:
        """Takes over what a mapping made. standing: whether the robot is at the mapper's current node."""
        self._mapping = None
        hybrid_map, current = self._map(), mapper.current
        if current < 0:
            self.whereabouts = "the mapping found no node"
            if hybrid_map.nodes():
                self.whereabouts = "it was lost on a foray"
                self._stand_nowhere()
            return
        closed = mapper.reason == "loop closed"
        hybrid_map.meta = replace(hybrid_map.meta, current_node=current, arrival=side, loop_closed=closed)
        self._stand_at(current, side)
        if not standing and self.guide is not None:
            self.guide.lose()

    def go_to(self, node: int | str) -> Trip:
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
        self.guide.go(goal)
        return Trip(self.guide)

    def save(self, path: str) -> None:
        """Writes the map with the truth beside it, as `tolman map` does. Raises: MapError."""
        hybrid_map = self._map()
        if self._mapping is None:
            node = self.guide.node if self.guide is not None else None
            arrival = self.guide.navigator.arrival if self.guide is not None else None
            hybrid_map.meta = replace(hybrid_map.meta, current_node=node, arrival=arrival)
        graph = hybrid_map.graph
        pose = self.session.world.true_pose(self.index)
        truth: dict[Any, Any] = {
            node: node_truth(self.truth[node], ()) for node in graph if node in self.truth
        }
        truth[RUN] = {**run_truth(()), "pose": [pose.x, pose.y, pose.heading]}
        with MapFile.create(
            self.session.output(path), hybrid_map.meta, force=self.session.request.force
        ) as file:
            file.update(hybrid_map, list(graph), list(graph.edges(keys=True)), truth=truth)
            file.seal()

    def load(self, path: str) -> None:
        """Takes a saved map over; the robot is taken to stand where its robot was. Raises: MapError."""
        file = self.session.input(path)
        hybrid_map, truth = HybridMap.load(file), read_truth(file)
        self._leave()
        self.map = hybrid_map
        self.truth = {node: Pose(*record["pose"]) for node, record in truth.nodes.items()}
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
        if number not in self.truth:
            raise MissionError(f"nobody knows where node {number} truly is")
        self.session.world.place(self.truth[number], self.index)
        self._stand_at(number, self._map().meta.side)
        return number

    def robot(self, index: int) -> tuple[Agent, RobotSite]:
        """Another robot of the world. Raises: LookupError."""
        sites = self.session.sites
        if not 0 <= index < len(sites):
            raise LookupError(f"there is no robot {index}; the world has {len(sites)}")
        return sites[index].agent, sites[index]

    # --- sink of the mapper ------------------------------------------------------------------------------

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains a local map."""
        first = samples.panoramas[0] if len(samples.panoramas) else None
        return LocalMap.build(
            samples.positions,
            samples.panorama_positions,
            samples.panoramas,
            entry_heading=entry_heading,
            entry_panorama=first,
            config=find_profile(self.session.request.profile).local_map,
        )

    def commit(self, node: int, corner: CornerReached) -> None:
        """Nothing is kept before `Save`."""

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Nothing is kept before `Save`."""

    # --- after a restart ---------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What a restart needs besides the map, as JSON."""
        guide = self.guide
        return {
            "odometry": self.agent.odometry.state(),
            "node": None if guide is None else guide.node,
            "arrival": None if guide is None else guide.navigator.arrival,
            "near": [] if guide is None else list(guide.near),
            "truth": {str(node): [pose.x, pose.y, pose.heading] for node, pose in self.truth.items()},
        }

    def restore(self, state: dict[str, Any], hybrid_map: HybridMap | None) -> None:
        """Goes back to a `state`."""
        self.agent.odometry.restore(state["odometry"])
        self._leave()
        self.map = hybrid_map
        self.truth = {int(node): Pose(*pose) for node, pose in state["truth"].items()}
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
        profile = find_profile(self.session.request.profile)
        navigator = make_navigator(profile, self.agent, self._map(), node, arrival)
        self.guide = RecoveringNavigator(
            self.agent, self._map(), navigator, localizes=profile.navigator == "corners"
        )

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

    def _on_corner(self, event: CornerReached) -> None:
        pose = self.session.world.true_pose(self.index)
        self._met[event.number] = Pose(
            pose.x, pose.y, pose.heading - (self.agent.odometry.heading - event.heading)
        )

    def _on_node(self, event: NodeCreated) -> None:
        if event.met in self._met:
            self.truth[event.node] = self._met[event.met]
