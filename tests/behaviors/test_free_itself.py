from __future__ import annotations

from enum import Enum

from tolman.agent import Agent, Behavior, Context, Proposal
from tolman.agent.events import BehaviorFinished, Event, Freed, Stuck
from tolman.behaviors.free_itself import FreeItself
from tolman.plugins.testing import ScriptedRobot, assert_event_order, percept
from tolman.world import open_world
from tolman.world.robot import Percept, Pose, WheelCommand


class Stubborn(Behavior):
    class States(Enum):
        ON = "on"

    name = "stubborn"
    priority = 10
    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal | None:
        return Proposal(WheelCommand(250.0, 250.0), reason="ahead")


def run(robot: ScriptedRobot, ticks: int) -> list[Event]:
    agent, heard = Agent(robot, [Stubborn(), FreeItself()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("stubborn")
    agent.start("free-itself")
    for _ in range(ticks):
        agent.tick()
    return heard


def stuck_events(heard: list[Event]) -> list[Stuck]:
    return [event for event in heard if isinstance(event, Stuck)]


def test_a_robot_whose_wheels_turn_at_a_wall_that_stays_is_worked_on_and_given_up() -> None:
    robot = ScriptedRobot([percept(front=0.004)])
    heard = run(robot, 1500)
    assert [event.given_up for event in stuck_events(heard)] == [False, False, False, True]
    assert "the wheels drove" in stuck_events(heard)[0].reason
    assert any(command.left < 0.0 and command.right < 0.0 for command in robot.commands)
    assert_event_order(heard, Stuck, Stuck, Stuck, Stuck, BehaviorFinished)


def test_driving_along_a_wall_or_in_the_open_is_not_suspected() -> None:
    assert stuck_events(run(ScriptedRobot([percept(right=0.022)]), 1500)) == []
    assert stuck_events(run(ScriptedRobot(), 1500)) == []


def test_a_wall_that_comes_nearer_is_not_suspected() -> None:
    approach = [percept(front=0.06 - 0.0003 * tick) for tick in range(180)]
    assert stuck_events(run(ScriptedRobot(approach), 180)) == []


def test_a_robot_that_lies_on_its_side_is_given_up() -> None:
    level = percept()
    lying = Percept(0, 0.0, level.infrared, (0.0, 0.0), (9.0, 0.0, 1.0))
    assert [event.reason for event in stuck_events(run(ScriptedRobot([lying]), 100))] == ["tipped over"]


def test_one_that_comes_loose_drives_on() -> None:
    world = open_world("env1", engine="kinematic", noise="none", start=Pose(0.65, 0.04, -1.5))
    agent, heard = Agent(world.robots[0], [Stubborn(), FreeItself()]), list[Event]()
    agent.bus.subscribe(Event, heard.append)
    agent.start("stubborn")
    agent.start("free-itself")
    before = world.true_pose()
    for _ in range(2000):
        agent.tick()
        world.step()
    assert_event_order(heard, Stuck, Freed)
    assert world.true_pose().distance_to(before) > 0.1
