from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from tolman.agent.missions.dry_run import dry_run
from tolman.agent.missions.mission import Mission

from tools.draw_behaviors import page

DOCS = Path(__file__).parents[2] / "docs"
PYTHON = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
YAML = re.compile(r"^```yaml\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("code", PYTHON.findall((DOCS / "plugins-testing.md").read_text()))
def test_every_example_of_the_test_kit_runs(code: str) -> None:
    exec(compile(code, "plugins-testing.md", "exec"), {"__name__": "example"})


def test_the_two_missions_of_the_docs_say_the_same(tmp_path: Path) -> None:
    text = (DOCS / "missions.md").read_text()
    plans = []
    for suffix, pattern in ((".py", PYTHON), (".yaml", YAML)):
        path = tmp_path / f"mission{suffix}"
        path.write_text(pattern.findall(text)[0])
        plans.append(dry_run(Mission.load(path)))
    assert plans[0].problems == plans[1].problems == []
    assert plans[0].lines[:2] == plans[1].lines[:2] == ["Explore(side='left')", "Save(path='a.tolman')"]


def test_the_step_of_the_docs_is_one(tmp_path: Path) -> None:
    example = sys.modules["example"] = ModuleType("example")  # where the types of its fields are looked up
    exec(compile(PYTHON.findall((DOCS / "missions.md").read_text())[1], "missions.md", "exec"), vars(example))
    path = tmp_path / "m.yaml"
    path.write_text("steps: [count_ticks: 5]")
    plan = dry_run(Mission.load(path, further=[example.CountTicks]))
    assert (plan.lines, plan.problems) == (["CountTicks(ticks=5)"], [])


def test_every_step_is_in_the_docs() -> None:
    from tolman.agent.missions import steps as mission_steps

    text = (DOCS / "missions.md").read_text()
    steps = [name for name, value in vars(mission_steps).items() if isinstance(value, type)]
    kinds = [name for name in steps if issubclass(getattr(mission_steps, name), mission_steps.Step)]
    assert [name for name in kinds if name != "Step" and f"`{name}(" not in text] == []


def test_the_page_of_behaviors_is_what_their_classes_say() -> None:
    assert (DOCS / "behaviors.md").read_text() == page(), "python -m tools.draw_behaviors docs/behaviors.md"
