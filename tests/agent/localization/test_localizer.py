from __future__ import annotations

import math

import pytest
from tolman.agent import Agent, Outcome
from tolman.agent.events import CornerReached, Event, Localized, Lost, WallMet
from tolman.agent.localization.corner_filter import LocalizationConfig
from tolman.agent.localization.localizer import Localizer
from tolman.maps.hybrid_map import HybridMap
from tolman.maps.meta import MapMeta
from tolman.plugins.testing import event_of

from ..puppets import finish, goals, puppets

QUARTER = 0.5 * math.pi
LENGTHS = (1.0, 0.7, 1.3, 0.4, 0.9, 1.1)


def room() -> HybridMap:
    """Concave corners whose distances tell them apart."""
    found = HybridMap(MapMeta(side="right"))
    for _ in LENGTHS:
        found.add_node(corner="concave", turn=QUARTER)
    for node, length in enumerate(LENGTHS):
        found.add_arc(node, (node + 1) % len(LENGTHS), "right", length)
    return found


class Search:
    """A localizer on puppets, and what the agent heard."""

    def __init__(self, config: LocalizationConfig = LocalizationConfig()) -> None:  # noqa: B008  frozen
        self.agent: Agent = puppets("wall-following", "foray")
        self.heard: list[Event] = []
        self.agent.bus.subscribe(Event, self.heard.append)
        self.ends: list[Outcome] = []
        self.localizer = Localizer(self.agent, room(), config, on_end=self.ends.append)
        self.localizer.start()

    def corner(self, length: float, turn: float = QUARTER) -> None:
        time = self.agent.context.time + 1.0
        corner = CornerReached(
            time=time, side="right", kind="concave", path_length=length, heading=0.0, turn=turn
        )
        self.agent.bus.publish(corner)
        self.agent.tick()
        self.agent.bus.publish(WallMet(time=time, side="right", heading=turn))
        self.agent.tick()


def test_it_follows_the_wall_until_the_corners_met_leave_one_node() -> None:
    search = Search()
    for length in (0.2, *LENGTHS[:4]):
        if not search.localizer.done:
            search.corner(length)
    node = search.localizer.node
    assert node is not None
    assert search.ends == [Outcome(True, node, "localized")]
    assert event_of(search.heard, Localized).node == node
    assert not search.agent.is_active("wall-following")


def test_while_it_finds_out_it_tells_how_likely_each_node_is() -> None:
    search = Search()
    assert sum(search.agent.belief().values()) == pytest.approx(1.0)
    search.corner(0.2)
    search.corner(LENGTHS[2])
    belief = search.agent.belief()
    assert belief.keys() == set(range(len(LENGTHS)))
    assert max(belief, key=belief.__getitem__) == 3
    search.localizer.stop()
    assert search.agent.belief() == {}


def test_stopped_it_hears_no_more_and_tells_nobody() -> None:
    search = Search()
    search.corner(0.2)
    search.localizer.stop()
    for length in LENGTHS:
        search.corner(length)
    assert search.localizer.done
    assert (search.localizer.node, search.localizer.reason) == (None, "cancelled")
    assert search.ends == []
    assert not search.agent.is_active("wall-following")


def test_from_a_round_obstacle_that_is_not_on_the_map_it_crosses_to_another_wall() -> None:
    search = Search()
    search.agent.context.turn = 0.0
    search.localizer._turned = -10.0
    search.agent.tick()
    assert len(goals(search.agent, "foray")) == 1
    finish(search.agent, "foray", 0.5)
    assert len(goals(search.agent, "wall-following")) == 2
    assert not search.localizer.done


@pytest.mark.parametrize("forays", [0, 1])
def test_after_as_many_crossings_as_it_may_make_it_is_lost(forays: int) -> None:
    search = Search(LocalizationConfig(forays=forays))
    for _ in range(forays):
        search.localizer._turned = -10.0
        search.agent.tick()
        finish(search.agent, "foray", 0.5)
    search.localizer._turned = -10.0
    search.agent.tick()
    search.agent.tick()
    assert search.ends == [Outcome(False, None, "an obstacle that is not on the map")]
    assert event_of(search.heard, Lost).reason == "an obstacle that is not on the map"
