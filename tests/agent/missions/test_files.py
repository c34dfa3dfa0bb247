from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tolman.agent.errors import MissionError
from tolman.agent.events import LoopClosed
from tolman.agent.missions.mission import Mission
from tolman.agent.missions.steps import (
    Do,
    Explore,
    Fail,
    ForEachNode,
    GoTo,
    OnFailure,
    Race,
    Repeat,
    Save,
    Say,
    Step,
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
  - within: {seconds: 30, steps: {do: {behavior: foray, goal: {turn: 1.5}}}}
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
    assert steps[5] == Within(30, Do("foray", {"turn": 1.5}))
    assert steps[6] == Save("a.tolman")


def test_a_python_mission_is_its_generator_function(tmp_path: Path) -> None:
    mission = Mission.load(write(tmp_path, "m.py", PYTHON))
    assert mission.name == "m"
    assert next(mission.body()) == Explore(side="left", wait=False)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("go_too: 5", r"steps: unknown step 'go_too'; did you mean 'go_to'\? known: "),
        ("go_to:", r"steps\.go_to: 'node' is missing: give a node's number or name"),
        ("go_to: [1]", r"steps\.go_to: give a node's number or name, not a list"),
        ("{go_to: 5, wait: 1}", r"a step is one key with its value"),
        ("explore: {sid: left}", r"steps\.explore\.sid: unknown key; did you mean 'side'\?"),
        ("explore: {max_nodes: many}", r"max_nodes: give a whole number, 1 or more, not 'many'"),
        ("explore: {max_nodes: 0}", r"max_nodes: give a whole number, 1 or more, not '0'"),
        ("explore: {side: left, side: right}", r"steps\.explore\.side: this key appears twice"),
        ("explore: up", r"steps\.explore: give one of right, left, not 'up'"),
        ("explore: {islands: 3}", r"islands: give true or false, not '3'"),
        ("until: LoopClose", r"until: 'LoopClose' is none of .*; did you mean 'LoopClosed'\?"),
        ("until: {event: LoopClosed, timeout: .nan}", r"until\.timeout: expected a finite number"),
        (
            "until: {event: LoopClosed, where: {colour: red}}",
            r"until: LoopClosed has no field 'colour'; known: ",
        ),
        ("until: {event: LoopClosed, where: 3}", r"where: give fields and their values, not '3'"),
        ("wait: long", r"steps\.wait: give a finite number of seconds, 0 or more, not 'long'"),
        ("wait: -1", r"give a finite number of seconds, 0 or more, not '-1'"),
        ("wait: .inf", r"expected a finite number, found '\.inf'"),
        ("wait: 1e999", r"'1e999' is too large"),
        ("wait: true", r"give a finite number of seconds, 0 or more, not 'true'"),
        ("race: []", r"an empty list of steps"),
        ("repeat: {times: 1.5, steps: {wait: 1}}", r"repeat\.times: give a whole number, 0 or more"),
        ("repeat: {times: 2}", r"repeat: 'steps' is missing: give a step"),
        ("within: {seconds: .nan, steps: {wait: 1}}", r"within\.seconds: expected a finite number"),
        ("do: {behavior: foray, goal: 7}", r"do\.goal: give the goal's fields"),
        ("for_each_node: [{go_two: $node}]", r"for_each_node\[0\]: unknown step"),
        ("[{wait: 1}, &a {wait: 2}, *a]", r"aliases \(\*a\) are not allowed"),
        ("&a [{repeat: {times: 2, steps: *a}}]", r"aliases \(\*a\) are not allowed"),
        ("[" * 100 + "]" * 100, r"nested deeper than 64 levels"),
        ("save: ''", r"steps\.save: give a file, not ''"),
        ("7", r"unknown step '7'"),
        ("", r"a step is one key"),
    ],
)
def test_a_wrong_entry_is_refused_with_file_line_and_place(tmp_path: Path, entry: str, said: str) -> None:
    path = write(tmp_path, "m.yaml", f"mission: x\nsteps:\n  {entry}\n")
    with pytest.raises(MissionError, match=rf"m\.yaml:[23]: {said}" if said[0] == "s" else said) as caught:
        Mission.load(path)
    assert "\n" not in str(caught.value)


def test_a_goal_is_given_by_its_fields(tmp_path: Path) -> None:
    text = "steps: [do: {behavior: a, goal: {turn: 1}}]"
    assert list(Mission.load(write(tmp_path, "m.yaml", text)).body()) == [Do("a", {"turn": 1})]


def test_a_text_is_taken_as_it_is_written(tmp_path: Path) -> None:
    path = write(
        tmp_path, "m.yaml", "steps: [say: 2020-13-45, say: 5, fail: yes, go_to: '5', go_to: kitchen]"
    )
    steps = [Say("2020-13-45"), Say("5"), Fail("yes"), GoTo("5"), GoTo("kitchen")]
    assert list(Mission.load(path).body()) == steps


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Wait(math.nan), r"Wait: seconds: give a finite number of seconds, 0 or more, not nan"),
        (lambda: Within(math.inf, Wait(1)), "Within: seconds: give a finite number of seconds"),
        (lambda: Explore(max_nodes=0), "Explore: max_nodes: give a whole number, 1 or more, not 0"),
        (lambda: Until(LoopClosed, where={"colour": 1}), "LoopClosed has no field 'colour'"),
        (lambda: Repeat(5), "Repeat: body: give a step"),  # type: ignore[arg-type]
        (lambda: Race(), "Race: bodies: give at least one step"),
        (lambda: GoTo(None), "GoTo: node: give a node's number or name, not None"),  # type: ignore[arg-type]
    ],
)
def test_a_step_made_in_python_is_checked_alike(make: Callable[[], Step], said: str) -> None:
    with pytest.raises(MissionError, match=said):
        make()


def test_numbers_of_numpy_are_numbers() -> None:
    nodes: Any = np.array([5])
    assert GoTo(nodes[0]) == GoTo(5)
    assert Wait(nodes[0] * 0.5) == Wait(2.5)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.yaml", "steps: [", "a.yaml:2: not valid YAML"),
        ("a.yaml", "- go_to: 5", "give `steps:`"),
        ("a.yaml", "stepps: []\nsteps: [nodes]", "stepps: unknown key; did you mean 'steps'"),
        ("a.py", "import nothing_of_that_name", "reading it raised ModuleNotFoundError"),
        ("a.py", "def mission(): return 5", "define a generator function"),
        ("a.py", "def mission(robot):\n    yield", "must take no arguments"),
        ("a.yaml", "", "give `steps:`"),
        ("a.yaml", "steps: [say: a]\nsteps: [say: b]", "a.yaml:2: steps: this key appears twice"),
        ("a.yaml", "mission: x", "the key 'steps' is missing"),
        ("a.txt", "", "ends in .py"),
    ],
)
def test_a_file_that_is_no_mission_is_refused(tmp_path: Path, name: str, text: str, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        Mission.load(write(tmp_path, name, text))


def test_a_missing_file_is_named() -> None:
    with pytest.raises(MissionError, match=r"nowhere\.yaml: there is no such file"):
        Mission.load("nowhere.yaml")
