from __future__ import annotations

import math
from pathlib import Path

import pytest
from tolman.agent.errors import MissionError
from tolman.agent.missions.dry_run import dry_run
from tolman.agent.missions.mission import Mission
from tolman.agent.missions.steps import Do, GoTo, OnFailure, Repeat, Save, Say, Wait

PYTHON = """
from tolman.agent.missions.steps import *
from tolman.agent.events import LoopClosed

def mission():
    yield Explore(side="left", wait=False)
    event = yield Until(LoopClosed, timeout=600)
    yield Say(f"closed at {event.node}")
    for node in (yield Nodes()):
        yield GoTo(node)
    yield Save("a.tolman")
"""


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_a_dry_run_lists_the_steps_and_does_nothing(tmp_path: Path) -> None:
    plan = dry_run(Mission.load(write(tmp_path, "m.py", PYTHON)))
    assert plan.lines == [
        "Explore(side='left', wait=False)",
        "Until(event=LoopClosed, timeout=600)",
        "Say(text='closed at ?')",
        "Nodes()",
        "GoTo(node=0)",
        "GoTo(node=1)",
        "GoTo(node=2)",
        "Save(path='a.tolman')",
    ]
    assert plan.problems == []


def test_a_dry_run_shows_branches_and_loops() -> None:
    plan = dry_run(Mission.of("m", Repeat(OnFailure(GoTo(1), otherwise=Save("x")), times=3)))
    assert plan.lines == ["3 times", "  try", "    GoTo(node=1)", "  otherwise", "    Save(path='x')"]


def not_a_step():  # type: ignore[no-untyped-def]
    yield 5


def test_a_dry_run_finds_what_would_go_wrong() -> None:
    plan = dry_run(Mission.of("m", GoTo(9), Do("fory"), not_a_step), nodes=[0, 1], behaviors=["foray"])
    assert plan.problems == [
        "GoTo(node=9): the map has no node 9",
        "Do(behavior='fory'): there is no such behavior",
        "a mission yields steps such as GoTo(5), not 5",
    ]


def test_a_dry_run_finds_what_a_script_does_wrong() -> None:
    def endless():  # type: ignore[no-untyped-def]
        yield endless

    def not_a_number():  # type: ignore[no-untyped-def]
        yield Wait(math.nan)

    assert dry_run(Mission("m", endless)).problems == ["more than 50 steps within one another"]
    assert dry_run(Mission("m", not_a_number)).problems == [
        "Wait: seconds: give a finite number of seconds, 0 or more, not nan"
    ]


def test_a_script_that_never_yields_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tolman.agent.missions.files.HANG", 0.1)
    monkeypatch.setattr("tolman.agent.missions.dry_run.HANG", 0.1)

    def mission():  # type: ignore[no-untyped-def]
        while True:
            pass
        yield

    assert "still running after 0.1 s" in dry_run(Mission("m", mission)).problems[0]
    with pytest.raises(MissionError, match=r"m\.py: reading it raised .* still running after 0\.1 s"):
        Mission.load(write(tmp_path, "m.py", "while True: pass"))


def test_a_dry_run_of_an_endless_mission_ends() -> None:
    def mission():  # type: ignore[no-untyped-def]
        while True:
            yield Say("x")

    plan = dry_run(Mission("m", mission))
    assert "only the first 500 steps" in plan.lines[-1]
