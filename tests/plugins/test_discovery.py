from __future__ import annotations

from pathlib import Path

import pytest
from tolman.agent import ConfigError, PriorityMediator
from tolman.agent.arbitration.blend import BlendMediator
from tolman.plugins import (
    BrokenPluginError,
    DuplicatePluginError,
    PluginError,
    UnknownPluginError,
    build_behaviors,
    discover,
    load_behaviors,
    load_mediator,
    plugins_in,
)

SOURCE = '''
from dataclasses import dataclass
from enum import Enum
from tolman.agent import Behavior, Proposal
from tolman.behaviors.wander import Wander
from tolman.world.robot import WheelCommand

@dataclass(frozen=True, slots=True)
class CircleConfig:
    """speed: steps/s."""
    speed: float = 200.0

class Circle(Behavior):
    """Drives in a circle."""
    class States(Enum):
        ON = "on"
    name = "{name}"
    initial = States.ON
    Config = CircleConfig
    def on(self, percept, context):
        return Proposal(WheelCommand(self.config.speed, 0.5 * self.config.speed))

class Last:
    """Takes the last that proposes."""
    name = "{name}-mediator"
    def arbitrate(self, candidates, previous):
        ...
    def reset(self):
        ...
'''


def write(folder: Path, file: str, name: str) -> Path:
    path = folder / file
    path.write_text(SOURCE.format(name=name))
    return path


def test_the_built_in_behaviors_are_found_by_their_entry_points() -> None:
    assert set(load_behaviors(["obstacle-avoidance", "wander"])) == {"obstacle-avoidance", "wander"}


def test_a_folders_files_are_found_beside_the_built_in_ones(tmp_path: Path) -> None:
    write(tmp_path, "circle.py", "circle")
    classes = load_behaviors(["circle", "wander"], [tmp_path])
    assert classes["circle"].__name__ == "Circle"


def test_an_imported_behavior_is_not_taken_for_the_files_own(tmp_path: Path) -> None:
    path = write(tmp_path, "circle.py", "circle")
    assert [plugin.name for plugin in plugins_in(path)] == ["circle", "circle-mediator"]


def test_two_plugins_of_one_name_are_refused_with_both_origins(tmp_path: Path) -> None:
    write(tmp_path, "one.py", "circle")
    write(tmp_path, "two.py", "circle")
    with pytest.raises(DuplicatePluginError, match=r"named 'circle': .*one\.py and .*two\.py"):
        discover([tmp_path])


def test_a_plugin_cannot_take_a_built_in_ones_name(tmp_path: Path) -> None:
    write(tmp_path, "mine.py", "wander")
    with pytest.raises(DuplicatePluginError, match=r"tolman .* and file .*mine\.py"):
        discover([tmp_path])


def test_an_unknown_name_is_answered_with_the_nearest_and_the_known() -> None:
    with pytest.raises(UnknownPluginError, match=r"'wandr'; did you mean 'wander'\? known: .*wander"):
        load_behaviors(["wandr"])


def test_a_broken_file_stops_nobody_else_and_is_named_when_asked_for(tmp_path: Path) -> None:
    (tmp_path / "bad.py").write_text("import nothing_of_that_name\n")
    write(tmp_path, "circle.py", "circle")
    assert "circle" in load_behaviors(folders=[tmp_path])
    with pytest.raises(UnknownPluginError, match=r"could not be read: .*bad\.py.*nothing_of_that_name"):
        load_behaviors(["bad"], [tmp_path])


def test_a_class_that_breaks_the_contract_is_named(tmp_path: Path) -> None:
    path = tmp_path / "stateless.py"
    path.write_text(
        "from tolman.agent import Behavior\n"
        "class Stateless(Behavior):\n    name = 'stateless'\n    def on(self, p, c): ...\n"
    )
    with pytest.raises(BrokenPluginError, match=r"stateless\.py: stateless: declare `States`"):
        plugins_in(path)


def test_tests_and_private_files_of_a_folder_are_left_alone(tmp_path: Path) -> None:
    for file in ("test_x.py", "_x.py", "conftest.py"):
        (tmp_path / file).write_text("raise SystemExit(3)\n")
    assert discover([tmp_path]).broken == {}


def test_a_folder_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(PluginError, match="no such folder"):
        discover([tmp_path / "nowhere"])


def test_settings_reach_the_behavior(tmp_path: Path) -> None:
    write(tmp_path, "circle.py", "circle")
    built = build_behaviors(["circle"], [tmp_path], {"circle": {"speed": 50.0}})
    assert built["circle"].config.speed == 50.0


def test_a_wrong_setting_and_settings_for_nobody_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="unknown setting 'sped'"):
        build_behaviors(["wander"], configs={"wander": {"sped": 1.0}})
    with pytest.raises(UnknownPluginError, match="for 'circle', which is not loaded; loaded: wander"):
        build_behaviors(["wander"], configs={"circle": {}})


def test_mediators_are_found_by_name(tmp_path: Path) -> None:
    write(tmp_path, "circle.py", "circle")
    assert isinstance(load_mediator(), PriorityMediator)
    assert isinstance(load_mediator("blend"), BlendMediator)
    assert type(load_mediator("circle-mediator", [tmp_path])).__name__ == "Last"
    with pytest.raises(UnknownPluginError, match="unknown mediator 'x'; known: blend, priority, subsumption"):
        load_mediator("x")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("def f(:", "importing it raised SyntaxError"),
        ("import sys\nsys.exit(4)", "importing it raised SystemExit: 4"),
        ("class Shy:\n    name = 'shy'", "it defines no behavior and no mediator"),
        (SOURCE.replace("{name}", ""), "declare a `name`"),
        (
            SOURCE.replace("{name}", "circle").replace(
                "    Config = ", "    def on_reset(self):\n        raise KeyError('no')\n    Config = "
            ),
            "behavior circle: making one raised KeyError: 'no'",
        ),
    ],
)
def test_what_cannot_be_used_is_left_out_and_one_line_says_why(
    text: str, why: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "shy.py").write_text(text)
    assert set(build_behaviors(None, [tmp_path])) == set(discover().plugins())
    (line,) = [record.getMessage() for record in caplog.records]
    assert line.startswith("plugin left out: ")
    assert why in line
    assert "\n" not in line


def test_a_mediator_that_cannot_be_made_is_named_with_its_fault(tmp_path: Path) -> None:
    (tmp_path / "odd.py").write_text(
        "class Odd:\n    name = 'odd'\n    def __init__(self):\n        raise OSError('no')\n"
        "    def arbitrate(self, candidates, previous):\n        return None\n"
    )
    with pytest.raises(
        BrokenPluginError, match=r"mediator 'odd' of file .*odd.py: making one raised OSError"
    ):
        load_mediator("odd", [tmp_path])
