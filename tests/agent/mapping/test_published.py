"""Mapping as published: nodes by algorithm 1, arcs by straight lines, loops closed by one view."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from tolman.agent import Agent
from tolman.agent.events import BehaviorFinished, CornerReached, LoopClosed
from tolman.agent.goals import LocalSamples
from tolman.agent.mapping.base import ArcKey
from tolman.agent.mapping.published import ThesisMapper, ThesisMappingConfig, ThesisPhase
from tolman.behaviors.local_exploration import LocalExploration
from tolman.behaviors.look_around import LookAroundBehavior
from tolman.behaviors.reactive_wall_following import ReactiveWallFollowing
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.local.local_map import LocalMap
from tolman.maps.meta import MapMeta
from tolman.world import open_world


def no_local_map(samples: LocalSamples, heading: float) -> LocalMap:
    raise AssertionError("no local map is to be built here")


class Sink:
    """Builds local maps as it is told to, and keeps nothing."""

    def __init__(self, build: Callable[[LocalSamples, float], LocalMap]) -> None:
        self.build = build

    def commit(self, node: int, corner: CornerReached) -> None:
        pass

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        raise AssertionError("it takes nothing back")


def explorer(
    config: ThesisMappingConfig,
    build: Callable[[LocalSamples, float], LocalMap] = no_local_map,
    noise: str = "none",
) -> tuple[ThesisMapper, Any]:
    world = open_world("env1", seed=3, noise=noise, engine="kinematic", start=config.side)
    behaviors = [
        ReactiveWallFollowing(),
        LookAroundBehavior(),
        LocalExploration(landmarks=False, compass=False),
    ]
    agent = Agent(world.robots[0], behaviors)
    mapper = ThesisMapper(agent, HybridMap(MapMeta(side=config.side)), Sink(build), config)
    mapper.start()
    return mapper, world


def run(mapper: ThesisMapper, world: Any, seconds: float) -> None:
    for _ in range(round(seconds / 0.032)):
        mapper.agent.tick()
        world.step()
        if mapper.done:
            return


@pytest.mark.parametrize("side", ["right", "left"])
def test_nodes_are_apart_in_place_and_heading_as_algorithm_1_asks(side: str) -> None:
    mapper, world = explorer(ThesisMappingConfig(side, local_maps=False, max_nodes=6))
    run(mapper, world, 200.0)
    assert mapper.reason == "max nodes"
    graph = mapper.map.graph
    for node in range(5):
        assert graph.edges[node, node + 1, side]["distance"] > 0.05
        turn = graph.nodes[node + 1]["entry_heading"] - graph.nodes[node]["entry_heading"]
        assert abs(math.remainder(turn, math.tau)) > math.radians(45.0)


def test_every_arc_leads_back_on_the_other_side_with_the_same_length() -> None:
    mapper, world = explorer(ThesisMappingConfig("right", local_maps=False, max_nodes=4))
    run(mapper, world, 200.0)
    graph = mapper.map.graph
    for a, b, kind, data in graph.edges(keys=True, data=True):
        other = "left" if kind == "right" else "right"
        assert graph.edges[b, a, other]["distance"] == data["distance"]


def test_without_local_maps_it_cannot_close_a_loop() -> None:
    mapper, world = explorer(ThesisMappingConfig("right", local_maps=False))
    run(mapper, world, 330.0)
    assert not mapper.done
    assert len(mapper.map.graph) > 14  # twice round


def test_taken_literally_algorithm_1_makes_nodes_in_mid_turn_and_so_more_of_them() -> None:
    counts = {}
    for settle in (None, math.radians(4.0)):
        mapper, world = explorer(ThesisMappingConfig("right", local_maps=False, settle=settle))
        run(mapper, world, 150.0)
        counts[settle] = len(mapper.map.graph)
    assert counts[None] > counts[math.radians(4.0)]


def local_map(view: float) -> LocalMap:
    """A local map all of whose views have the luminance `view`, but for a spread of 0.01.

    More views than units, so that no unit is one view's alone and D_a is not 0.
    """
    rng = np.random.default_rng(0)
    panoramas = np.clip(view + rng.normal(0.0, 0.01, (81, 4, 16, 16)), 0.0, 1.0)
    places = np.array([[0.02 * (k % 9), 0.02 * (k // 9)] for k in range(81)])
    return LocalMap.build(places, places, panoramas)


def test_the_loop_is_closed_at_node_0_where_the_view_is_like_one_of_its_own() -> None:
    config = ThesisMappingConfig("right", closing=2.0)
    mapper, world = explorer(config, lambda samples, heading: local_map(0.5))
    closed: list[LoopClosed] = []
    mapper.agent.bus.subscribe(LoopClosed, closed.append)
    run(mapper, world, 30.0)
    assert mapper.map.nodes() == [0]
    view = np.full((4, 16, 16), 0.5, dtype=np.float32)
    _look(mapper, view)
    assert mapper.reason == "loop closed"
    mapper.agent.bus.deliver()
    assert [event.node for event in closed] == [0]


def test_a_view_unlike_node_0s_makes_a_new_node_and_tells_how_unlike() -> None:
    mapper, world = explorer(ThesisMappingConfig("right", closing=2.0), lambda s, h: local_map(0.5))
    run(mapper, world, 30.0)
    _look(mapper, np.full((4, 16, 16), 0.9, dtype=np.float32))
    assert mapper.map.nodes() == [0, 1]
    assert mapper.ratios[1] > 2.0


def _look(mapper: ThesisMapper, view: Any) -> None:
    """Lets node 0 have its local map and a view come in, as if driven to the next node."""
    mapper.map.graph.nodes[0]["local_map"] = local_map(0.5)
    mapper.phase = ThesisPhase.LOOK
    time = mapper.agent.context.time
    finished = BehaviorFinished(time=time, behavior="look-around", succeeded=True, result=view)
    mapper.agent.bus.publish(finished)
    mapper.agent.bus.deliver()


def test_a_state_taken_and_given_back_goes_on_the_same() -> None:
    config = ThesisMappingConfig("right", local_maps=False)
    mapper, world = explorer(config)
    run(mapper, world, 60.0)
    other, _ = explorer(config)
    other.restore(mapper.state())
    assert other.state() == mapper.state()
