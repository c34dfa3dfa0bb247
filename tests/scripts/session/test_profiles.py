"""Profiles are data: what they name is built, and what a user asks for comes on top."""

import math
from dataclasses import fields, replace
from typing import Any

import pytest
from tolman.agent.mapping.corners import Mapper
from tolman.agent.mapping.published import ThesisMapper, ThesisMappingConfig
from tolman.agent.navigation.corners import Navigator
from tolman.agent.navigation.published import ThesisNavigator
from tolman.maps.hybrid_map import HybridMap
from tolman.scripts.cli.options import PROFILES as OFFERED
from tolman.scripts.session.assembly import make_mapper, make_navigator
from tolman.scripts.session.profiles import (
    PROFILES,
    REMEDIES,
    find_profile,
)
from tolman.scripts.session.requests import MapRequest, SessionError
from tolman.scripts.session.simulation import Simulation


def test_the_command_line_offers_the_profiles_there_are() -> None:
    assert set(OFFERED) == set(PROFILES)


def test_an_unknown_profile_is_refused_with_the_nearest() -> None:
    with pytest.raises(SessionError, match="did you mean 'thesis'"):
        find_profile("thesiss")


def test_settings_asked_for_come_on_top_of_the_profiles() -> None:
    asked = {"local-exploration": {"compass": True}, "wander": {}}
    merged = find_profile("thesis").behavior_settings(asked)
    assert merged["local-exploration"] == {
        "landmarks": False,
        "compass": True,
        "panorama_interval": 0.04,
        "turn_speed": 300.0,
    }
    assert find_profile("thesis").behavior_settings(None)["local-exploration"]["compass"] is False


@pytest.mark.parametrize("remedy", sorted(REMEDIES))
def test_a_profile_can_do_without_each_remedy_and_stays_as_it_is_otherwise(remedy: str) -> None:
    whole, without = find_profile("default"), find_profile(f"default without {remedy}")
    assert replace(without, name="default") != whole
    changed = [f.name for f in fields(whole) if getattr(whole, f.name) != getattr(without, f.name)]
    assert set(changed) <= {"name", "behaviors", "mapping", "learn_mismatch", "reflexes"}
    with Simulation("env1", profile=without, engine="kinematic") as simulation:
        assert isinstance(
            make_navigator(simulation.profile, simulation.agent, HybridMap(), 0, None), Navigator
        )


def test_there_is_no_profile_without_what_it_does_not_have() -> None:
    with pytest.raises(SessionError, match="unknown profile 'default without luck'"):
        find_profile("default without luck")


class Nowhere:
    """A sink of which nothing is asked."""

    def build(self, samples: Any, entry_heading: float) -> Any:
        raise AssertionError("no local map is to be built here")

    def commit(self, node: int, corner: Any) -> None:
        raise AssertionError("no node is to be made here")

    def rest(self, nodes: Any, arcs: Any) -> None:
        raise AssertionError("nothing is to be taken back here")


@pytest.mark.parametrize(
    ("name", "mapper", "navigator"),
    [("default", Mapper, Navigator), ("thesis", ThesisMapper, ThesisNavigator)],
)
def test_a_profile_names_its_mapper_and_navigator(name: str, mapper: type, navigator: type) -> None:
    hybrid = HybridMap()
    hybrid.add_node()
    with Simulation("env1", profile=name, engine="kinematic") as simulation:
        request = simulation.request(MapRequest, world="env1")
        assert isinstance(
            make_mapper(simulation.profile, request, simulation.agent, hybrid, Nowhere()), mapper
        )
        assert isinstance(make_navigator(simulation.profile, simulation.agent, hybrid, 0, None), navigator)


def test_profile_thesis_explores_by_path_integration_alone() -> None:
    with Simulation("env1", profile="thesis", engine="kinematic") as simulation:
        config = simulation.agent.behavior("local-exploration").config
    assert not config.landmarks
    assert not config.compass


def test_profile_thesis_has_the_published_thresholds() -> None:
    profile = find_profile("thesis")
    assert profile.closing == 1.0  # D_a, the best of the three
    config = ThesisMappingConfig()
    assert (math.degrees(config.angle), config.distance) == pytest.approx((45.0, 0.05))
