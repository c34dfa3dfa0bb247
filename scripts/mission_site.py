"""One robot of a mission's world: here is done what the steps ask of mapper, navigator and files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..agent import Agent
from ..agent.errors import MissionError
from ..agent.events import CornerReached, NodeCreated
from ..agent.goals import LocalSamples
from ..agent.mission_steps import Explore
from ..agent.mission_tasks import Outcome
from ..maps.hybrid_map import HybridMap
from ..maps.local_map import LocalMap
from ..maps.map_file import RUN, MapFile, read_truth
from ..world.robot import Pose
from .profiles import AnyMapper, AnyNavigator, find_profile, make_mapper, make_navigator
from .truth import node_truth, run_truth
from .wiring import make_agent

if TYPE_CHECKING:
    from .mission_session import MissionSession


@dataclass(slots=True)
class Mapping:
    """A mapping under way, as a mission's job."""

    agent: Agent
    mapper: AnyMapper
    close: Callable[[], None]
    closed: bool = False

    @property
    def outcome(self) -> Outcome | None:
        """Done when the mapper is."""
        if not self.mapper.done:
            return None
        self._close()
        return Outcome(True, self.mapper.reason, self.mapper.reason)

    def cancel(self) -> None:
        """Stops the behaviors a mapper uses."""
        for name in ("wall-following", "local-exploration", "position-correction"):
            if name in self.agent.behaviors:
                self.agent.stop(name)
        self._close()

    def _close(self) -> None:
        if not self.closed:
            self.closed = True
            self.close()


@dataclass(slots=True)
class Trip:
    """A trip under way, as a mission's job."""

    site: RobotSite
    navigator: AnyNavigator

    @property
    def outcome(self) -> Outcome | None:
        """Done when the navigator is."""
        if not self.navigator.done:
            return None
        return Outcome(self.navigator.reached, self.navigator.node, self.navigator.reason)

    def cancel(self) -> None:
        """Stops between two nodes: the robot does not know any more at which node it is."""
        self.site.agent.stop("go-to-node")
        self.site.navigator = None
        self.site.whereabouts = "it was stopped between two nodes"


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
        self.navigator: AnyNavigator | None = None
        self.whereabouts = "no map was made or loaded"
        self.truth: dict[int, Pose] = {}
        self._met: dict[float, Pose] = {}
        self.agent.bus.subscribe(CornerReached, self._on_corner)
        self.agent.bus.subscribe(NodeCreated, self._on_node)

    # --- Site ------------------------------------------------------------------------------------------

    def explore(self, step: Explore) -> Mapping:
        """Maps from where the robot stands, into a new map."""
        request = self.session.map_request(step)
        profile = find_profile(request.profile)
        hybrid_map = HybridMap(self.session.meta(step.side))
        mapper = make_mapper(profile, request, self.agent, hybrid_map, self._build, lambda node, met_at: None)
        self.map, self.truth = hybrid_map, {}

        def close() -> None:
            current = mapper.current
            if current < 0:
                self.whereabouts = "the mapping found no node"
                return
            closed = mapper.reason == "loop closed"
            hybrid_map.meta = replace(
                hybrid_map.meta, current_node=current, arrival=step.side, loop_closed=closed
            )
            self._stand_at(current, step.side)

        mapper.begin()
        return Mapping(self.agent, mapper, close)

    def go_to(self, node: int | str) -> Trip:
        """Sets out from the node where the robot is. Raises: MapError, MissionError."""
        goal = self._map().find(node)
        if self.navigator is None:
            raise MissionError(f"the robot does not know where it is: {self.whereabouts}")
        self.navigator.go(goal)
        return Trip(self, self.navigator)

    def save(self, path: str) -> None:
        """Writes the map with the truth beside it, as `tolman map` does. Raises: MapError."""
        hybrid_map = self._map()
        if self.navigator is not None:
            hybrid_map.meta = replace(hybrid_map.meta, current_node=self.navigator.node)
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
        self.map = hybrid_map
        self.truth = {node: Pose(*record["pose"]) for node, record in truth.nodes.items()}
        meta = hybrid_map.meta
        if meta.current_node is None:
            self.navigator, self.whereabouts = None, f"{path} does not say where its robot was"
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

    # --- after a restart ---------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """What a restart needs besides the map, as JSON."""
        navigator = self.navigator
        standing = navigator is not None and not self.agent.is_active("go-to-node")
        return {
            "odometry": self.agent.odometry.state(),
            "node": navigator.node if standing and navigator is not None else None,
            "truth": {str(node): [pose.x, pose.y, pose.heading] for node, pose in self.truth.items()},
        }

    def restore(self, state: dict[str, Any], hybrid_map: HybridMap | None) -> None:
        """Goes back to a `state`."""
        self.agent.odometry.restore(state["odometry"])
        self.map = hybrid_map
        self.truth = {int(node): Pose(*pose) for node, pose in state["truth"].items()}
        if state["node"] is None or hybrid_map is None:
            self.whereabouts = "it was between two nodes when the mission was interrupted"
        else:
            self._stand_at(int(state["node"]), hybrid_map.meta.side)

    # --- inside ----------------------------------------------------------------------------------------

    def _map(self) -> HybridMap:
        if self.map is None:
            raise MissionError("there is no map yet: explore, or load one")
        return self.map

    def _stand_at(self, node: int, arrival: str) -> None:
        profile = find_profile(self.session.request.profile)
        self.navigator = make_navigator(profile, self.agent, self._map(), node, arrival)

    def _build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        first = samples.panoramas[0] if len(samples.panoramas) else None
        return LocalMap.build(
            samples.positions,
            samples.panorama_positions,
            samples.panoramas,
            entry_heading=entry_heading,
            entry_panorama=first,
            config=find_profile(self.session.request.profile).local_map,
        )

    def _on_corner(self, event: CornerReached) -> None:
        pose = self.session.world.true_pose(self.index)
        self._met[event.time] = Pose(
            pose.x, pose.y, pose.heading - (self.agent.odometry.heading - event.heading)
        )

    def _on_node(self, event: NodeCreated) -> None:
        if event.met_at in self._met:
            self.truth[event.node] = self._met[event.met_at]
