"""A simulation as people use it: maps in memory and in files, behaviors of one's own, and how a run ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Any

import pytest
from tolman.agent import Behavior, Context, Proposal
from tolman.agent.events import Event
from tolman.agent.missions.mission import Mission
from tolman.agent.missions.steps import Do, Explore, Say
from tolman.files.interrupts import UserInterrupt
from tolman.maps import HybridMap
from tolman.scripts.session.mapping import Mapping
from tolman.scripts.session.requests import GoRequest, MapRequest, MissionRequest, RunSettings, SessionError
from tolman.scripts.session.simulation import Simulation, go_to, map_world, run_mission
from tolman.scripts.session.stage import Stage
from tolman.world.physics.kinematic import KinematicWorld
from tolman.world.robot import STOP, Percept, Pose, WheelCommand

QUICK: dict[str, Any] = {"engine": "kinematic"}


class Straight(Behavior):
    """Drives straight on, or does what it is given instead."""

    class States(Enum):
        """ON: the only one."""

        ON = "on"

    name = "straight"
    priority = 90
    initial = States.ON

    def on(self, percept: Percept, context: Context) -> Proposal:
        """Ahead."""
        return Proposal(WheelCommand(300.0, 300.0), reason="straight on")


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> list[WheelCommand]:
    """All commands that robots of the kinematic twin are given."""
    given: list[WheelCommand] = []
    made = KinematicWorld.__init__

    def init(world: KinematicWorld, *arguments: Any, **options: Any) -> None:
        made(world, *arguments, **options)
        for robot in world.robots:
            monkeypatch.setattr(robot, "act", _noting(robot.act, given), raising=False)

    monkeypatch.setattr(KinematicWorld, "__init__", init)
    return given


def _noting(act: Callable[[WheelCommand], None], given: list[WheelCommand]) -> Callable[[WheelCommand], None]:
    def noted(command: WheelCommand) -> None:
        given.append(command)
        act(command)

    return noted


def test_a_map_can_be_made_in_memory_and_a_trip_driven_over_it() -> None:
    with Simulation("env1", seed=3, noise="encoder", **QUICK) as simulation:
        report = simulation.map(global_only=True)
        assert (report.nodes, report.loop_correct) == (10, True)
        assert report.map.graph.number_of_nodes() == 10
        assert "map" not in report.to_json()
        trip = simulation.go(report.map, to=6)
        assert (trip.reached, trip.path[-1]) == (True, 6)
        assert trip.position_error_m is not None
        assert trip.position_error_m < 0.02
        assert simulation.go(report.map, to=7).path == (6, 7)
        assert simulation.go(report.map, to=2, lost=True).reached


def test_a_map_in_a_file_is_the_one_that_the_command_makes(tmp_path: Path) -> None:
    with Simulation("env1", seed=3, start="right", **QUICK) as simulation:
        simulation.map(tmp_path / "a", global_only=True, max_nodes=3)
    map_world(MapRequest(world="env1", output=tmp_path / "b", seed=3, global_only=True, max_nodes=3, **QUICK))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    with Simulation("env1", seed=3, start="right", **QUICK) as simulation:
        report = simulation.map(tmp_path / "a", global_only=True, resume=True)
    assert (report.nodes, report.loop_correct) == (10, True)


def test_a_mission_of_one_s_own_runs_on_it() -> None:
    mission = Mission.of("short", Explore(max_nodes=2), Say("done"))
    with Simulation("env1", **QUICK) as simulation:
        report = simulation.mission(mission, global_only=True)
    assert (report.status, report.steps_done) == ("done", 2)


def test_it_is_stepped_by_hand_with_a_behavior_of_one_s_own() -> None:
    with Simulation("env1", behaviors=[Straight()], **QUICK) as simulation:
        before = simulation.world.true_pose()
        simulation.agent.start("straight")
        while simulation.time < 1.0:
            simulation.step()
        assert simulation.agent.driver == "straight"
        assert simulation.world.true_pose().distance_to(before) > 0.02


def test_it_says_what_it_is() -> None:
    with Simulation("env1", seed=3, **QUICK) as simulation:
        assert repr(simulation) == "Simulation('env1', seed=3, profile='default', time=0.000 s)"
        simulation.step()
        assert "time=0.032 s" in repr(simulation)


def test_settings_that_there_are_not_are_refused() -> None:
    with pytest.raises(TypeError, match="sed"):
        Simulation("env1", sed=3)


def test_a_map_that_says_not_where_its_robot_is_needs_a_node() -> None:
    with Simulation("env1", **QUICK) as simulation, pytest.raises(SessionError, match="name the node"):
        simulation.go(HybridMap(), to=0)


def test_only_a_run_from_its_start_can_be_recorded(tmp_path: Path) -> None:
    with Simulation("env1", **QUICK) as simulation:
        simulation.step()
        with pytest.raises(SessionError, match="only a run from its start"):
            simulation.map(record=tmp_path / "run")
    assert not (tmp_path / "run").exists()


# --- the last command of every run is zero ---------------------------------------------------------------


def test_after_a_run_that_met_its_limit_the_wheels_stand_still(
    commands: list[WheelCommand], tmp_path: Path
) -> None:
    map_world(MapRequest(world="env1", output=tmp_path / "m", global_only=True, max_time=3.0, **QUICK))
    assert commands[-3] != STOP  # once before behaviors are stopped, once after
    assert commands[-1] == STOP


@pytest.mark.parametrize("fault", [RuntimeError("broken"), KeyboardInterrupt(), SystemExit(3)])
@pytest.mark.parametrize("phase", ["step", "update", "event"])
def test_whatever_ends_a_run_the_wheels_stand_still(
    commands: list[WheelCommand], phase: str, fault: BaseException
) -> None:
    with pytest.raises(type(fault)):
        drive_into(fault, phase, commands)
    assert commands[-1] == STOP


def drive_into(fault: BaseException, phase: str, commands: list[WheelCommand]) -> None:
    """Drives straight on until the world, a tick listener or a handler of events raises the fault."""

    def fail(*_: Any) -> None:
        raise fault

    with Simulation("env1", behaviors=[Straight()], **QUICK) as simulation:
        agent = simulation.agent
        agent.start("straight")
        simulation.step()
        simulation.step()
        assert commands[-1] != STOP
        if phase == "step":
            simulation.world.step = fail  # type: ignore[method-assign]
        elif phase == "update":
            agent.attach(type("Failing", (), {"update": fail})())
        else:
            agent.bus.subscribe(Event, fail)
            agent.start("straight")
        simulation.run(lambda: False, limit=5.0)


@pytest.mark.parametrize("method", ["begin", "watch", "commit", "finish", "report"])
def test_so_they_do_when_a_mapping_fails(
    commands: list[WheelCommand], method: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fail(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Mapping, method, fail)
    with pytest.raises(KeyboardInterrupt):
        map_world(MapRequest(world="env1", output=tmp_path / "m", global_only=True, max_nodes=2, **QUICK))
    assert commands[-1] == STOP


def test_so_they_do_when_a_mission_is_interrupted(
    commands: list[WheelCommand], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "mission.yaml"
    path.write_text("steps: [do: wander]")
    step = KinematicWorld.step

    def interrupted(world: KinematicWorld) -> None:
        if world.time > 1.0:
            monkeypatch.setattr(KinematicWorld, "step", step)
            raise KeyboardInterrupt
        step(world)

    monkeypatch.setattr(KinematicWorld, "step", interrupted)
    report = run_mission(MissionRequest(mission=path, world="env1", **QUICK))
    assert (report.status, report.reason) == ("cancelled", "interrupted")
    assert commands[-1] == STOP


def test_a_world_whose_agent_cannot_be_made_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []
    monkeypatch.setattr(KinematicWorld, "close", lambda world: closed.append(True))
    with pytest.raises(SessionError, match="unknown profile"):
        Simulation("env1", profile="none", **QUICK)
    assert closed == [True]


# --- no run drives for ever ------------------------------------------------------------------------------

ROOM = "tolman-world: 1\nroom: {size: [1, 1]}\nstarts: {right: [5, 5, 0]}\n"


def test_a_start_outside_of_all_walls_is_refused(tmp_path: Path) -> None:
    world = tmp_path / "outside.yaml"
    world.write_text(ROOM)
    with pytest.raises(SessionError, match=r"a start at \(5, 5\) is outside of all walls"):
        map_world(MapRequest(world=str(world), output=tmp_path / "m", **QUICK))
    assert not (tmp_path / "m").exists()
    with Simulation(world, start=Pose(0.5, 0.5, 0.0), **QUICK) as simulation:
        simulation.step()


def test_a_robot_that_leaves_all_walls_ends_its_run_with_a_reason(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    outside = iter([False] * 3 + [True] * 9)
    monkeypatch.setattr(Stage, "_outside", lambda stage, robot, margin: next(outside))
    report = map_world(MapRequest(world="env1", output=tmp_path / "m", global_only=True, **QUICK))
    assert report.reason.startswith("the robot left all walls: it is at (")
    assert report.sim_time_s < 5.0


def test_a_trip_that_takes_too_long_is_given_up(tmp_path: Path) -> None:
    path = tmp_path / "m.tolman"
    map_world(MapRequest(world="env1", output=path, global_only=True, **QUICK))
    report = go_to(GoRequest(map=path, to=5, origin=0, max_time=4.0, **QUICK))
    assert (report.reached, report.lost, report.reason) == (False, True, "max time")
    assert report.sim_time_s == pytest.approx(4.0, abs=0.1)


def test_settings_can_be_given_as_one_value() -> None:
    with Simulation("env1", RunSettings(seed=4, engine="kinematic"), noise="none") as simulation:
        assert (simulation.settings.seed, simulation.settings.noise) == (4, "none")


def test_a_behavior_s_goal_can_be_waited_for_in_a_mission_on_it() -> None:
    mission = Mission.of("do", Do("look-around"))
    with Simulation("env1", **QUICK) as simulation:
        assert simulation.mission(mission).status in ("done", "failed")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_a_run_between_two_ticks_with_wheels_at_rest(
    commands: list[WheelCommand], number: signal.Signals
) -> None:
    def interrupting() -> bool:
        if len(commands) == 5:
            os.kill(os.getpid(), number)
        return False

    def drive() -> None:
        with Simulation("env1", **QUICK) as simulation:
            simulation.agent.start("wander")
            simulation.run(interrupting)

    with pytest.raises(UserInterrupt) as caught:
        drive()
    assert caught.value.number == number
    assert len(commands) == 5 + 2
    assert commands[4] != STOP
    assert commands[-1] == STOP


def test_wheels_rest_though_behaviors_break_when_they_are_stopped() -> None:
    class Bad(Straight):
        """Breaks when it is stopped."""

        def on_stop(self, context: Context) -> None:
            """Raises."""
            raise GeneratorExit

    with Simulation("env1", behaviors=[Bad()], **QUICK) as simulation:
        robot = simulation.world.robots[0]
        simulation.agent.start("straight")
        for _ in range(3):
            simulation.step()
    assert robot._command == STOP  # type: ignore[attr-defined]
