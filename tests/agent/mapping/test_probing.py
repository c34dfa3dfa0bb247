from __future__ import annotations

import pytest
from tolman.agent import Agent, Outcome
from tolman.agent.estimation.wall_segments import WallSegmentMeter
from tolman.agent.events import CornerReached
from tolman.agent.mapping.probing import WallProbe
from tolman.world.robot import EPUCK

from ..puppets import finish, goals, puppets

BEND = CornerReached(time=0.0, side="right", kind="bend", path_length=1.0, heading=0.3, turn=0.0)


def probed() -> tuple[Agent, WallProbe, list[Outcome]]:
    agent, ends = puppets("go-to-node"), list[Outcome]()
    probe = WallProbe(agent, "right", WallSegmentMeter(agent.odometry, EPUCK.track), ends.append)
    probe.probe(BEND)
    return agent, probe, ends


def test_it_drives_the_wall_back_and_here_again() -> None:
    agent, _, _ = probed()
    there, back = goals(agent, "go-to-node")[-1].legs
    assert (there.side, back.side) == ("left", "right")
    assert there.distance == back.distance == pytest.approx(0.6)


def test_what_odometry_turned_on_the_way_is_the_wheels() -> None:
    agent, probe, ends = probed()
    agent.odometry.heading = BEND.heading + 0.1
    finish(agent, "go-to-node")
    assert ends == [Outcome(True, BEND, "")]
    assert probe.meter.mismatch.value < 0.0
    assert agent.odometry.mismatch == probe.meter.mismatch.value


def test_a_wall_that_cannot_be_driven_twice_teaches_nothing() -> None:
    agent, probe, ends = probed()
    finish(agent, "go-to-node", succeeded=False, reason="no wall")
    assert ends == [Outcome(False, BEND, "no wall")]
    assert probe.meter.mismatch.value == 0.0


def test_stopped_it_does_not_take_another_s_drive_for_its_own() -> None:
    agent, probe, ends = probed()
    probe.stop()
    finish(agent, "go-to-node")
    assert ends == []
