from __future__ import annotations

from pathlib import Path

import pytest
from tolman.agent.errors import MissionError
from tolman.agent.events import LoopClosed
from tolman.agent.maneuvers import Foray
from tolman.agent.missions.dry_run import dry_run
from tolman.agent.missions.files import read_steps
from tolman.agent.missions.mission import Mission
from tolman.agent.missions.steps import (
    Do,
    Explore,
    ForEachNode,
    GoTo,
    OnFailure,
    Race,
    Repeat,
    Save,
    Say,
    Until,
    Wait,
    Within,
)

YAML = """
mission: patrol
about: once around
steps:
  - explore: {side: left, wait: false}
  - until: {event: LoopClosed, timeout: 600}
  - for_each_node:
      - on_failure: {do: {go_to: $node}, otherwise: {say: "node $node is out of reach"}}
  - repeat: {times: 2, steps: [{go_to: 0}, {wait: 1}]}
  - race: [{go_to: 5}, {wait: 60.5}]
  - within: {seconds: 30, steps: {do: {behavior: foray, goal: {Foray: {turn: 1.5}}}}}
  - save: a.tolman
"""

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


def test_a_yaml_mission_says_the_same_as_steps_do(tmp_path: Path) -> None:
    mission = Mission.load(write(tmp_path, "m.yaml", YAML))
    assert mission.name == "patrol"
    steps = list(mission.body())
    assert steps[0] == Explore(side="left", wait=False)
    assert steps[1] == Until(LoopClosed, timeout=600)
    assert isinstance(steps[2], ForEachNode)
    assert steps[2].body(4) == OnFailure(GoTo(4), otherwise=Say("node 4 is out of reach"))
    assert steps[3] == Repeat((GoTo(0), Wait(1)), times=2)
    assert steps[4] == Race(GoTo(5), Wait(60.5))
    assert steps[5] == Within(30, Do("foray", Foray(turn=1.5)))
    assert steps[6] == Save("a.tolman")


def test_a_python_mission_is_its_generator_function(tmp_path: Path) -> None:
    mission = Mission.load(write(tmp_path, "m.py", PYTHON))
    assert mission.name == "m"
    assert next(mission.body()) == Explore(side="left", wait=False)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"go_too": 5}, r"steps: unknown step 'go_too'; did you mean go_to\? known: "),
        ({"go_to": None}, r"steps\.go_to: give a node's number or name, not None"),
        ({"go_to": 5, "wait": 1}, r"a step is one key with its value"),
        ({"explore": {"sid": "left"}}, r"steps\.explore: unknown key 'sid'; known: side"),
        ({"explore": "up"}, r"side is right or left, not 'up'"),
        ({"until": "LoopClose"}, r"unknown event 'LoopClose'; did you mean LoopClosed\?"),
        ({"wait": "long"}, r"give a number of seconds, not 'long'"),
        ({"race": []}, r"an empty list of steps"),
        ({"repeat": {"times": 1.5, "steps": {"wait": 1}}}, r"repeat\.times: give a whole number"),
        ({"do": {"behavior": "foray", "goal": {"Forray": {}}}}, r"do\.goal: give a kind of goal"),
        ({"do": {"behavior": "foray", "goal": {"Foray": {"trun": 1}}}}, r"steps\.do: TypeError"),
        ({"for_each_node": [{"go_two": "$node"}]}, r"for_each_node\[1\]: unknown step"),
        (7, r"a step is one key"),
    ],
)
def test_a_wrong_entry_is_refused_with_its_place(entry: object, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        read_steps(entry, "steps")


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.yaml", "steps: [", "not YAML"),
        ("a.yaml", "- go_to: 5", "give `steps:`"),
        ("a.yaml", "stepps: []\nsteps: [nodes]", "unknown key 'stepps'"),
        ("a.py", "import nothing_of_that_name", "reading it raised ModuleNotFoundError"),
        ("a.py", "def mission(): return 5", "define a generator function"),
        ("a.py", "def mission(robot):\n    yield", "must take no arguments"),
        ("a.txt", "", "ends in .py"),
    ],
)
def test_a_file_that_is_no_mission_is_refused(tmp_path: Path, name: str, text: str, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        Mission.load(write(tmp_path, name, text))


def test_a_missing_file_is_named() -> None:
    with pytest.raises(MissionError, match=r"nowhere\.yaml: there is no such mission file"):
        Mission.load("nowhere.yaml")


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


def test_a_dry_run_of_an_endless_mission_ends() -> None:
    def mission():  # type: ignore[no-untyped-def]
        while True:
            yield Say("x")

    plan = dry_run(Mission("m", mission))
    assert "only the first 500 steps" in plan.lines[-1]
