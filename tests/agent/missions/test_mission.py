from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from tolman.agent import Agent
from tolman.agent.errors import StepFailedError
from tolman.agent.events import Event, Lost, MissionEnded, NodeReached, Said, StepEnded
from tolman.agent.goals import Foray
from tolman.agent.listener import Outcome
from tolman.agent.missions.journal import Journal
from tolman.agent.missions.mission import Mission, MissionRunner, Status
from tolman.agent.missions.steps import (
    As,
    Do,
    Explore,
    ForEachNode,
    GoTo,
    Nodes,
    OnFailure,
    Place,
    Race,
    Repeat,
    Save,
    Say,
    Together,
    Until,
    Wait,
    Within,
)
from tolman.behaviors.foray import ForayBehavior
from tolman.plugins.testing import ScriptedRobot, percept

Script = Generator[Any, Any, Any]


class FakeJob:
    def __init__(self, ticks: int, outcome: Outcome) -> None:
        self.ticks, self.end, self.cancelled = ticks, outcome, False

    @property
    def outcome(self) -> Outcome | None:
        self.ticks -= 1
        return self.end if self.ticks < 0 else None

    def cancel(self) -> None:
        self.cancelled = True


class FakeSite:
    """Trips take as many ticks as the node's number; nodes 13 and beyond cannot be reached."""

    def __init__(self) -> None:
        self.log: list[str] = []
        self.jobs: list[FakeJob] = []

    def _job(self, ticks: int, outcome: Outcome) -> FakeJob:
        self.jobs.append(FakeJob(ticks, outcome))
        return self.jobs[-1]

    def explore(self, side: str, strategy: str, max_nodes: int | None, islands: bool) -> FakeJob:
        self.log.append(f"explore {side}")
        return self._job(3, Outcome(True, "loop closed"))

    def go_to(self, node: int | str) -> FakeJob:
        self.log.append(f"go to {node}")
        if node == 99:
            raise LookupError("there is no node 99")
        if int(node) >= 13:
            return self._job(2, Outcome(False, reason="lost the wall"))
        return self._job(int(node), Outcome(True, node))

    def save(self, path: str) -> None:
        self.log.append(f"save {path}")

    def load(self, path: str) -> None:
        self.log.append(f"load {path}")

    def nodes(self) -> list[int]:
        return [1, 2, 3]

    def place(self, node: int | str) -> int:
        self.log.append(f"place {node}")
        return int(node)

    def robot(self, index: int) -> tuple[Agent, FakeSite]:
        if index != 1:
            raise LookupError(f"there is no robot {index}")
        return Agent(ScriptedRobot(), []), self


class Rig:
    def __init__(self, mission: Mission, journal: Journal | None = None) -> None:
        self.agent = Agent(ScriptedRobot([percept()]), [ForayBehavior()])
        self.site = FakeSite()
        self.heard = list[Event]()
        self.agent.bus.subscribe(Event, self.heard.append)
        self.runner = MissionRunner(mission, self.agent, self.site, journal)
        self.runner.start()

    @property
    def result(self) -> Any:
        assert self.runner.outcome is not None
        return self.runner.outcome.result

    def run(self, ticks: int = 500) -> Rig:
        for _ in range(ticks):
            self.agent.tick()
            if self.runner.done:
                self.agent.tick()
                break
        return self


def run(*steps: Any) -> Rig:
    return Rig(Mission.of("test", *steps)).run()


def test_steps_are_done_in_order_and_the_script_gets_their_results() -> None:
    seen = []

    def mission() -> Script:
        seen.append((yield Explore(side="left")))
        for node in (yield Nodes()):
            seen.append((yield GoTo(node)))
        yield Save("a.tolman")
        return "home"

    rig = Rig(Mission("m", mission)).run()
    assert seen == ["loop closed", 1, 2, 3]
    assert rig.site.log == ["explore left", "go to 1", "go to 2", "go to 3", "save a.tolman"]
    assert (rig.runner.status, rig.result) == (Status.DONE, "home")
    ended = [event for event in rig.heard if isinstance(event, MissionEnded)]
    assert [event.status for event in ended] == ["done"]


def test_a_failed_step_is_raised_in_the_script_which_may_go_on() -> None:
    def mission() -> Script:
        try:
            yield GoTo(13)
        except StepFailedError as failed:
            yield Say(failed.reason)

    rig = Rig(Mission("m", mission)).run()
    assert [event.text for event in rig.heard if isinstance(event, Said)] == ["lost the wall"]
    assert rig.runner.status is Status.DONE


def test_a_failed_step_that_nobody_minds_fails_the_mission_with_its_reason() -> None:
    rig = run(GoTo(13), Save("never"))
    assert rig.runner.status is Status.FAILED
    assert rig.runner.reason == "go to node 13: lost the wall"
    assert rig.site.log == ["go to 13"]


def test_a_step_that_cannot_even_begin_fails_like_any_other() -> None:
    rig = run(OnFailure(GoTo(99), otherwise=Save("plan b")))
    assert rig.runner.status is Status.DONE
    assert rig.site.log == ["go to 99", "save plan b"]


def test_why_a_step_cannot_begin_is_told_in_words() -> None:
    assert run(GoTo(99)).runner.reason == "go to node 99: there is no node 99"
    assert run((GoTo(1), GoTo(99))).runner.reason == "2 steps: go to node 99: there is no node 99"


def test_what_say_tells_is_kept_for_whoever_shows_it() -> None:
    assert run(Say("one"), As(1, Say("two"))).runner.said == ["one", "two"]


def test_a_script_that_yields_itself_fails_the_mission() -> None:
    def mission() -> Script:
        yield mission

    rig = Rig(Mission("m", mission)).run()
    assert "more than 50 steps within one another" in rig.runner.reason


def test_on_failure_retries_and_then_does_something_else() -> None:
    rig = run(OnFailure(GoTo(13), otherwise=GoTo(1), retries=2))
    assert rig.site.log == ["go to 13"] * 3 + ["go to 1"]
    reason = run(OnFailure(GoTo(13), retries=1)).runner.reason
    assert reason == "try, at most 2 times: go to node 13: lost the wall"


def test_the_first_to_succeed_wins_a_race_and_the_others_are_cancelled() -> None:
    def mission() -> Script:
        return (yield Race(GoTo(9), GoTo(13), GoTo(4)))

    rig = Rig(Mission("m", mission)).run()
    assert rig.result == (2, 4)
    assert [job.cancelled for job in rig.site.jobs] == [True, False, False]


def test_a_race_that_nobody_wins_fails_with_all_reasons() -> None:
    assert "lost the wall; lost the wall" in run(Race(GoTo(13), GoTo(14))).runner.reason


def test_together_waits_for_all_and_the_first_failure_ends_it() -> None:
    rig = run(Together(GoTo(2), GoTo(5)))
    assert rig.result == [2, 5]
    rig = run(Together(GoTo(13), GoTo(9)))
    assert rig.runner.status is Status.FAILED
    assert rig.site.jobs[1].cancelled


def test_another_robot_does_its_part() -> None:
    assert run(As(1, (Place(3), GoTo(4)))).site.log == ["place 3", "go to 4"]
    assert "there is no robot 7" in run(As(7, GoTo(1))).runner.reason


def test_repeat_for_each_node_and_nested_scripts() -> None:
    def patrol() -> Script:
        yield GoTo(1)
        yield GoTo(2)

    rig = run(Repeat(patrol, times=2), ForEachNode(lambda node: Say(f"at {node}")))
    assert rig.site.log == ["go to 1", "go to 2"] * 2
    assert [event.text for event in rig.heard if isinstance(event, Said)] == ["at 1", "at 2", "at 3"]


def test_until_gives_the_first_event_that_fits() -> None:
    def mission() -> Script:
        return (yield Until(NodeReached, where={"node": 7}))

    rig = Rig(Mission("m", mission))
    rig.agent.tick()
    rig.agent.bus.publish(NodeReached(time=0.0, node=3))
    rig.agent.tick()
    rig.agent.bus.publish(NodeReached(time=0.5, node=7))
    rig.run()
    assert rig.result == NodeReached(time=0.5, node=7)


def test_until_fails_when_its_time_is_over() -> None:
    rig = run(Until(Lost, timeout=1.0))
    assert rig.runner.reason == "wait for Lost: no Lost within 1 s"
    assert rig.agent.context.time == pytest.approx(1.0, abs=0.07)


def test_wait_lets_simulated_time_pass() -> None:
    assert run(Wait(3.2)).agent.context.time == pytest.approx(3.2, abs=0.07)


def test_within_cancels_what_takes_too_long() -> None:
    rig = run(Within(0.1, GoTo(12)))
    assert rig.runner.reason.endswith("not done within 0.1 s")
    assert rig.site.jobs[0].cancelled
    assert run(Within(10.0, GoTo(12))).runner.status is Status.DONE


def test_do_runs_a_behavior_and_gives_its_result() -> None:
    rig = run(OnFailure(Do("foray", Foray(max_distance=0.05)), otherwise=Say("nothing found")))
    assert [event.text for event in rig.heard if isinstance(event, Said)] == ["nothing found"]
    assert not rig.agent.is_active("foray")


def test_an_unknown_behavior_or_a_wrong_goal_is_a_failed_step() -> None:
    assert "unknown behavior 'fory'" in run(Do("fory")).runner.reason
    assert "needs a Foray goal" in run(Do("foray", 3)).runner.reason


def test_cancelling_stops_everything_and_runs_finally_blocks() -> None:
    done = []

    def mission() -> Script:
        try:
            yield Together(GoTo(12), Do("foray", Foray()))
        finally:
            done.append("tidied")

    rig = Rig(Mission("m", mission))
    rig.run(5)
    assert rig.agent.is_active("foray")
    rig.runner.stop("user")
    rig.agent.tick()
    assert done == ["tidied"]
    assert rig.site.jobs[0].cancelled
    assert not rig.agent.is_active("foray")
    assert (rig.runner.status, rig.runner.reason) == (Status.CANCELLED, "user")
    assert any(isinstance(event, MissionEnded) for event in rig.heard)


def test_a_fault_in_the_script_fails_the_mission_not_the_agent() -> None:
    def mission() -> Script:
        yield Wait(0.1)
        raise KeyError("x")

    rig = Rig(Mission("m", mission)).run()
    assert rig.runner.reason == "KeyError: 'x'"


def test_what_is_no_step_fails_the_mission() -> None:
    assert "a mission yields steps such as GoTo(5), not 5" in run(5).runner.reason


def test_an_endless_loop_of_steps_without_time_does_not_hang() -> None:
    rig = Rig(Mission.of("m", Repeat(Say("x"))))
    rig.agent.tick()
    assert not rig.runner.done
    rig.runner.stop()


def three_trips() -> Script:
    total = 0
    for node in (1, 2):
        total += yield GoTo(node)
    try:
        yield GoTo(13)
    except StepFailedError:
        total += 100
    total += (yield Race(GoTo(5), GoTo(4)))[1]
    yield Repeat(GoTo(3), times=2)
    return total


@pytest.mark.parametrize("ticks", range(1, 40, 3))
def test_a_mission_goes_on_after_a_restart_from_the_last_completed_step(tmp_path: Path, ticks: int) -> None:
    path = tmp_path / "journal"
    first = Rig(Mission("trips", three_trips), Journal(path, mission="trips"))
    for _ in range(ticks):
        first.agent.tick()
    done = sum(isinstance(event, StepEnded) and "." not in event.path for event in first.heard)
    again = Rig(Mission("trips", three_trips), Journal(path, mission="trips", resume=True)).run()
    assert again.runner.status is Status.DONE
    assert again.result == 107
    expected = ["go to 1", "go to 2", "go to 13", "go to 5", "go to 4", "go to 3", "go to 3"]
    skipped = {0: 0, 1: 1, 2: 2, 3: 3, 4: 5}.get(done, 5)
    assert again.site.log in (expected[skipped:], expected[skipped + 1 :], [])


def test_the_journal_of_a_changed_mission_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    Rig(Mission.of("m", GoTo(1), GoTo(2)), Journal(path, mission="m")).run()
    rig = Rig(Mission.of("m", GoTo(2), GoTo(2)), Journal(path, mission="m", resume=True)).run()
    assert "the mission was changed since it was begun: step 1 was GoTo(node=1), now GoTo(node=2)" in (
        rig.runner.reason
    )


def test_a_torn_last_line_of_a_journal_is_dropped(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    Rig(Mission.of("m", GoTo(1), GoTo(2)), Journal(path, mission="m")).run()
    text = path.read_text()
    path.write_text(text[:-10])
    rig = Rig(Mission.of("m", GoTo(1), GoTo(2)), Journal(path, mission="m", resume=True)).run()
    assert rig.site.log == ["go to 2"]
    assert path.read_text() == text
