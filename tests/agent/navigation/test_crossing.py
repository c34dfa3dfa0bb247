from __future__ import annotations

import pytest
from tolman.agent import Agent, Outcome
from tolman.agent.events import CornerReached, WallMet
from tolman.agent.goals import Crossing, FollowFrom
from tolman.agent.navigation.crossing import CrossingDrive, CrossingGates, Stage

from ..puppets import finish, goals, puppets

GOAL = Crossing(0.3, 1.2, 0.8, -0.9, 0.25)


class Drive:
    """A crossing on puppets, its ends and where it landed."""

    def __init__(self) -> None:
        self.agent: Agent = puppets("wall-following", "foray")
        self.ends: list[Outcome] = []
        self.landed: list[float] = []
        self.drive = CrossingDrive(self.agent, "right", self.ends.append, self.landed.append)
        self.drive.begin(GOAL, FollowFrom.CONCAVE, 1.5)
        self.agent.tick()

    def corner(self, length: float, kind: str = "concave") -> None:
        time = self.agent.context.time + 1.0
        self.agent.bus.publish(
            CornerReached(time=time, side="right", kind=kind, path_length=length, heading=0.4, turn=1.5)
        )
        self.agent.tick()


def test_it_goes_along_the_wall_across_and_along_the_next_to_its_corner() -> None:
    drive = Drive()
    assert goals(drive.agent, "wall-following")[-1].reach == 0.3
    finish(drive.agent, "wall-following", 0.0)
    assert goals(drive.agent, "foray")[-1].turn == pytest.approx(1.2)
    finish(drive.agent, "foray", 0.82)
    assert drive.landed == [0.82]
    drive.agent.bus.publish(WallMet(time=drive.agent.context.time + 0.5, side="right", heading=0.3))
    drive.agent.tick()
    drive.corner(0.1, "bend")
    drive.corner(0.15)
    (end,) = drive.ends
    driven, corner = end.result
    assert end.succeeded
    assert (driven.distance, driven.join) == (0.82, pytest.approx(0.25))
    assert driven.wall == pytest.approx(0.3 - 1.2)
    assert corner.kind == "concave"
    assert not drive.agent.is_active("wall-following")


def test_a_corner_before_it_leaves_the_wall_fails_it() -> None:
    drive = Drive()
    drive.corner(0.1, "convex")
    assert drive.ends == [Outcome(False, None, "met a convex corner before 0.30 m")]
    assert drive.drive.stage is Stage.IDLE


def test_where_no_wall_is_met_it_fails_for_that_reason() -> None:
    drive = Drive()
    finish(drive.agent, "wall-following", 0.0)
    finish(drive.agent, "foray", 2.0, succeeded=False, reason="no wall")
    assert [(end.succeeded, end.reason) for end in drive.ends] == [(False, "no wall")]


def test_released_the_robot_goes_on_along_the_wall_and_nobody_is_told() -> None:
    drive = Drive()
    drive.drive.release()
    assert drive.agent.is_active("wall-following")
    drive.corner(0.4)
    assert drive.ends == []


def test_stopped_the_robot_stands() -> None:
    drive = Drive()
    drive.drive.stop()
    assert not drive.agent.is_active("wall-following")
    assert drive.ends == []


@pytest.mark.parametrize(
    ("driven", "said"),
    [
        (Crossing(0.3, 1.2, 0.82, -0.95, 0.27), ""),
        (Crossing(0.3, 1.2, 1.1, -0.9, 0.25), "a wall after 1.10 m, not 0.80 m"),
        (Crossing(0.3, 1.2, 0.8, -0.9 + 0.6, 0.25), "stands 34 deg off"),
        (Crossing(0.3, 1.2, 0.8, -0.9, 0.6), "its corner after 0.60 m, not 0.25 m"),
    ],
)
def test_what_does_not_fit_is_said_in_words(driven: Crossing, said: str) -> None:
    misfit = CrossingGates().misfit(GOAL, driven)
    assert said in misfit
    assert bool(misfit) == bool(said)
