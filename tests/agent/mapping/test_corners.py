from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent
from tolman.agent.events import (
    ArcAdded,
    BehaviorFinished,
    CornerReached,
    Event,
    LocalMapBuilt,
    LoopClosed,
    NodeCommitted,
    NodeCreated,
    WallMet,
)
from tolman.agent.goals import ExploreLocally, Follow, FollowFrom, LocalSamples, ReacquireCorner
from tolman.agent.mapping.base import ArcKey
from tolman.agent.mapping.corners import Mapper, MappingConfig
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.plugins.testing import ScriptedRobot, event_of
from tolman.world.robot import wrap_angle

from ..puppets import Puppet

QUARTER = 0.5 * math.pi
SQUARE = [("concave", 1.0, QUARTER)] * 4


class WallPuppet(Puppet):
    name = "wall-following"
    Goal = Follow


class ExplorationPuppet(Puppet):
    name = "local-exploration"
    Goal = ExploreLocally


class CorrectionPuppet(Puppet):
    name = "position-correction"
    Goal = ReacquireCorner


class Drive:
    """A mapper whose behaviors are puppets, and the boundary it is told to have met."""

    def __init__(self, **settings: Any) -> None:
        self.wall, self.exploration, self.correction = WallPuppet(), ExplorationPuppet(), CorrectionPuppet()
        self.agent = Agent(ScriptedRobot(), [self.wall, self.exploration, self.correction])
        self.heard: list[Event] = []
        self.agent.bus.subscribe(Event, self.heard.append)
        self.commits: list[int] = []
        self.states: list[str] = []
        self.map = HybridMap()
        self.corners: list[int] = []
        self.mapper = Mapper(self.agent, self.map, self, MappingConfig(**settings))
        self.side = self.mapper.config.side
        self.heading = 0.0

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        return LocalMap.build(samples.positions, entry_heading=entry_heading)

    def commit(self, node: int, corner: CornerReached) -> None:
        self.commits.append(node)
        self.corners.append(corner.number)
        self.states.append(json.dumps(self.mapper.state()))

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        raise AssertionError("it takes nothing back")

    def begin(self) -> None:
        self.mapper.start()
        self.agent.tick()

    def phase(self) -> str:
        return self.mapper.phase.name

    def starts(self) -> list[FollowFrom]:
        return [goal.start for goal in self.wall.goals]

    def tell(self, event: Event) -> None:
        self.agent.bus.publish(event)
        self.agent.tick()
        self.agent.tick()

    def corner(self, kind: str, length: float, turn: float) -> None:
        """Follows a wall to its end, then turns there and follows enough of the next to know it."""
        self.reach(kind, length, turn)
        if self.mapper.listening:
            self.meet(turn)

    def reach(self, kind: str, length: float, turn: float) -> None:
        now = self.agent.context.time
        odometry = self.agent.odometry
        odometry.x += length * math.cos(self.heading)
        odometry.y += length * math.sin(self.heading)
        self.tell(
            CornerReached(
                time=now, side=self.side, kind=kind, path_length=length, heading=self.heading, turn=turn
            )
        )

    def meet(self, turn: float) -> None:
        self.heading = wrap_angle(self.heading + turn)
        self.tell(WallMet(time=self.agent.context.time, side=self.side, heading=self.heading))

    def explored(self, samples: Any) -> None:
        finished = BehaviorFinished(time=0.0, behavior="local-exploration", succeeded=True, result=samples)
        self.tell(finished)

    def returned(self, corner: CornerReached | None = None) -> None:
        succeeded = corner is not None
        self.tell(
            BehaviorFinished(time=0.0, behavior="position-correction", succeeded=succeeded, result=corner)
        )

    def drive(self, corners: Iterable[tuple[str, float, float]]) -> None:
        for corner in corners:
            self.corner(*corner)


def samples(count: int = 60) -> LocalSamples:
    places = np.random.default_rng(0).uniform(-0.1, 0.1, (count, 2))
    return LocalSamples(places, np.zeros((0, 2)), np.zeros((0, 4, 16, 16)), 10, 2)


def mapped(**settings: Any) -> Drive:
    drive = Drive(local_maps=False, **settings)
    drive.begin()
    return drive


def test_it_begins_by_looking_for_a_wall_on_its_side() -> None:
    drive = mapped(side="left")
    assert drive.wall.goals == [Follow("left", FollowFrom.SEARCH)]


def test_a_square_closes_after_one_round_and_two_confirming_corners() -> None:
    drive = mapped()
    drive.drive(SQUARE * 2)
    assert drive.mapper.reason == "loop closed"
    assert len(drive.mapper.loop.trace.corners) == 7
    assert drive.map.nodes() == [0, 1, 2, 3]
    closed = event_of(drive.heard, LoopClosed)
    assert (closed.node, closed.met) == (0, 5)
    lengths = {(a, b): d["distance"] for a, b, kind, d in drive.map.graph.edges(keys=True, data=True)}
    ring = [(0, 1), (1, 2), (2, 3), (3, 0)]
    assert set(lengths) == {*ring, *((b, a) for a, b in ring)}
    assert all(length == pytest.approx(1.0) for length in lengths.values())
    assert not drive.agent.is_active("wall-following")


def test_nodes_and_arcs_say_what_was_met() -> None:
    drive = mapped()
    drive.drive([("concave", 0.7, QUARTER), ("convex", 1.2, -QUARTER), ("concave", 0.4, QUARTER)])
    data = drive.map.graph.nodes
    assert [data[node]["corner"] for node in range(3)] == ["concave", "convex", "concave"]
    assert [data[node]["turn"] for node in range(3)] == pytest.approx([QUARTER, -QUARTER, QUARTER])
    assert [data[node]["entry_heading"] for node in range(3)] == pytest.approx([0.0, QUARTER, 0.0])
    forth, back = drive.map.arc(0, 1, "right"), drive.map.arc(1, 0, "left")
    assert (forth.distance, forth.side) == (1.2, "right")
    assert (back.distance, back.side) == (1.2, "left")
    assert [event.node for event in drive.heard if isinstance(event, NodeCreated)] == [0, 1, 2]
    assert [event.target for event in drive.heard if isinstance(event, ArcAdded)] == [1, 2]


def test_the_loop_may_close_at_a_later_node_than_the_first() -> None:
    drive = mapped()
    drive.drive([("convex", 0.3, -QUARTER), ("concave", 0.45, QUARTER), *(SQUARE * 2)])
    assert drive.mapper.reason == "loop closed"
    assert event_of(drive.heard, LoopClosed).node > 0


def test_a_place_that_only_looked_like_a_known_one_becomes_nodes_after_all() -> None:
    drive = mapped()
    drive.drive([*SQUARE, ("concave", 1.0, QUARTER)])
    assert drive.phase() == "CONFIRM"
    drive.corner("convex", 0.3, -QUARTER)
    assert drive.phase() == "FOLLOW"
    assert not drive.mapper.done
    assert drive.map.nodes() == [0, 1, 2, 3, 4, 5]
    assert drive.commits == [0, 1, 2, 3, 4, 5]
    assert drive.corners == [1, 2, 3, 4, 5, 6]
    assert drive.map.arc(3, 4, "right").distance == pytest.approx(1.0)
    assert drive.map.arc(4, 5, "right").distance == pytest.approx(0.3)
    assert [drive.map.graph.nodes[node]["corner"] for node in (4, 5)] == ["concave", "convex"]


def test_it_ends_at_the_most_nodes_it_was_told() -> None:
    drive = mapped(max_nodes=2)
    drive.drive(SQUARE)
    assert drive.mapper.reason == "max nodes"
    assert drive.map.nodes() == [0, 1]


def test_around_every_node_it_explores_trains_and_comes_back_to_the_corner() -> None:
    drive = Drive(strategy="alternate")
    drive.begin()
    drive.reach("concave", 0.4, QUARTER)
    assert not drive.agent.is_active("wall-following")
    explore = drive.exploration.goals[-1]
    assert isinstance(explore, ExploreLocally)
    assert explore.strategy == "rows"
    assert explore.walls[0][:2] == pytest.approx((-QUARTER, 0.057))
    drive.explored(samples())
    assert drive.map.local_map(0) is not None
    assert event_of(drive.heard, LocalMapBuilt).positions == 60
    assert isinstance(drive.correction.goals[-1], ReacquireCorner)
    assert drive.commits == []
    drive.returned()
    assert drive.commits == [0]
    drive.meet(QUARTER)
    drive.reach("convex", 0.8, -QUARTER)
    assert drive.exploration.goals[-1].strategy == "columns"
    drive.explored(samples())
    drive.returned()
    assert drive.starts() == [FollowFrom.SEARCH, FollowFrom.CONCAVE, FollowFrom.CONVEX]
    assert [event.node for event in drive.heard if isinstance(event, NodeCommitted)] == [0, 1]


def test_an_exploration_that_brought_nothing_leaves_the_node_without_a_local_map() -> None:
    drive = Drive()
    drive.begin()
    drive.reach("concave", 0.4, QUARTER)
    drive.explored(None)
    drive.returned()
    assert drive.commits == [0]
    assert drive.map.local_map(0) is None


def test_after_the_return_the_corner_is_where_it_was_heard_last() -> None:
    drive = Drive()
    drive.begin()
    drive.reach("concave", 0.4, QUARTER)
    drive.explored(samples())
    drive.returned(
        CornerReached(time=9.0, side="right", kind="concave", path_length=0.1, heading=0.2, turn=1.4)
    )
    assert drive.wall.goals[-1].turn == pytest.approx(1.4)
    drive.heading = 0.2
    drive.meet(QUARTER)
    assert drive.map.graph.nodes[0]["turn"] == pytest.approx(QUARTER)


def test_without_coming_back_to_the_corner_a_node_is_complete_when_it_is_explored() -> None:
    drive = Drive(come_back=False)
    drive.begin()
    drive.reach("concave", 0.4, QUARTER)
    drive.explored(samples())
    assert drive.commits == [0]
    assert not hasattr(drive.correction, "goals")


def test_a_corner_heard_while_exploring_is_not_a_node() -> None:
    drive = Drive()
    drive.begin()
    drive.reach("concave", 0.4, QUARTER)
    drive.reach("convex", 0.1, -QUARTER)
    assert drive.map.nodes() == [0]


def test_straight_walls_teach_the_wheels_mismatch() -> None:
    drive = mapped()
    drive.drive(SQUARE[:2])
    drive.heading = wrap_angle(drive.heading + 0.05)
    drive.reach("concave", 1.0, QUARTER)
    assert drive.mapper.meter.mismatch.value < 0.0
    assert drive.agent.odometry.mismatch == drive.mapper.meter.mismatch.value


def test_the_mismatch_is_not_learned_where_it_is_not_to_be() -> None:
    drive = mapped(learn_mismatch=False)
    drive.drive(SQUARE[:2])
    drive.heading = wrap_angle(drive.heading + 0.05)
    drive.reach("concave", 1.0, QUARTER)
    assert drive.agent.odometry.mismatch == 0.0


def without_times(state: str) -> Any:
    values = json.loads(state)
    for event in (values["corner"], values["met"], values["wall"]):
        event.pop("time")
    return values


def test_a_mapping_goes_on_from_a_state_as_if_it_had_not_stopped() -> None:
    room = [("concave", 1.0, QUARTER), ("convex", 0.5, -QUARTER), *SQUARE[:1], ("concave", 0.7, QUARTER)]
    whole = mapped()
    whole.drive(room)
    stopped = mapped()
    stopped.drive(room[:2])
    stopped.reach(*room[2])
    resumed = Drive(local_maps=False)
    resumed.map.graph = stopped.map.graph.copy()
    resumed.mapper.restore(json.loads(stopped.states[-1]))
    resumed.heading = stopped.heading
    resumed.mapper.start()
    resumed.agent.tick()
    assert resumed.wall.goals[-1] == stopped.wall.goals[-1]
    resumed.meet(room[2][2])
    resumed.corner(*room[3])
    assert without_times(resumed.states[-1]) == without_times(whole.states[-1])
    assert sorted(resumed.map.arcs(), key=repr) == sorted(whole.map.arcs(), key=repr)
