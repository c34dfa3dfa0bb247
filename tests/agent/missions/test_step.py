from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from tolman.agent import Agent
from tolman.agent.errors import MissionError
from tolman.agent.listener import Outcome
from tolman.agent.missions.dry_run import dry_run
from tolman.agent.missions.forms import Count
from tolman.agent.missions.journal import Journal
from tolman.agent.missions.mission import Mission, MissionRunner
from tolman.agent.missions.step import Plan, Run, Step, Task
from tolman.agent.missions.steps import STEPS, Repeat, Say
from tolman.plugins.testing import ScriptedRobot, percept


@dataclass(frozen=True, slots=True)
class CountTicks(Step):
    """Let ticks pass. Result: how many did."""

    ticks: Count
    says, word, single = "count {ticks} ticks", "count_ticks", "ticks"

    def begin(self, run: Run, path: str) -> Task:
        """Begins to count."""
        polled: list[float] = []

        def poll(time: float) -> Outcome | None:
            polled.append(time)
            return Outcome(True, len(polled)) if len(polled) >= self.ticks else None

        return Task(poll)

    def rehearse(self, plan: Plan, depth: int) -> Any:
        """Too many take too long."""
        if self.ticks > 1000:
            plan.problems.append("that takes too long")
        return self.ticks


def run(mission: Mission, journal: Journal | None = None) -> MissionRunner:
    agent = Agent(ScriptedRobot([percept()]), [])
    runner = MissionRunner(mission, agent, None, journal)  # type: ignore[arg-type]
    runner.start()
    for _ in range(200):
        agent.tick()
    assert runner.outcome is not None
    return runner


def test_a_step_of_ones_own_is_one_class(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("steps: [repeat: {times: 2, steps: [count_ticks: 5]}]")
    mission = Mission.load(path, further=[CountTicks])
    assert list(mission.body()) == [Repeat(CountTicks(5), times=2)]
    assert dry_run(mission).lines == ["2 times", "  CountTicks(ticks=5)"]
    outcome = run(mission, Journal(tmp_path / "journal", mission="m")).outcome
    assert outcome == Outcome(True, 5)
    assert run(mission, Journal(tmp_path / "journal", mission="m", resume=True)).outcome == outcome


def test_its_values_are_checked_and_its_dry_run_tells_what_it_wants(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("steps: [count_ticks: -1]")
    with pytest.raises(MissionError, match=r"count_ticks: give a whole number, 0 or more, not '-1'"):
        Mission.load(path, further=[CountTicks])
    assert dry_run(Mission.of("m", CountTicks(2000))).problems == ["that takes too long"]


def test_only_steps_that_somebody_names_are_known_in_files(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("steps: [count_ticks: 1]")
    with pytest.raises(MissionError, match="unknown step 'count_ticks'"):
        Mission.load(path)


def test_every_step_has_a_word_and_says_what_it_does() -> None:
    assert len({cls.word for cls in STEPS}) == len(STEPS) == 19
    assert all(cls.__doc__ and (cls.says or "words" in vars(cls)) for cls in STEPS)


def test_a_text_with_braces_is_told_as_it_is() -> None:
    assert Say("{x} {0}").words == "say '{x} {0}'"
