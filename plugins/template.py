"""Writes a new plugin with its test: `tolman plugins new NAME`."""

from __future__ import annotations

import keyword
import re
from pathlib import Path

from ..files.writing import write_text
from .discovery import discover
from .errors import DuplicatePluginError, PluginError

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")

BEHAVIOR = '''\
"""{Title}: drives ahead and turns left where something is near."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from tolman.agent import Behavior, Context, Proposal, Transition
from tolman.world.robot import LEFT_FRONT, RIGHT_FRONT, Percept, WheelCommand


@dataclass(frozen=True, slots=True)
class {Class}Config:
    """Settings. speed: steps/s. clearance: m from the rim at which it turns."""

    speed: float = 200.0
    clearance: float = 0.03


class {Class}(Behavior):
    """Drives ahead until something is near, then turns left until there is room."""

    class States(Enum):
        """AHEAD: driving. TURNING: turning left in place."""

        AHEAD = "ahead"
        TURNING = "turning"

    name = "{name}"
    priority = 15
    initial = States.AHEAD
    transitions = (
        Transition("blocked", States.AHEAD, States.TURNING),
        Transition("freed", States.TURNING, States.AHEAD),
    )
    Config = {Class}Config

    def ahead(self, percept: Percept, context: Context) -> Proposal | None:
        """Drives; called once a tick (32 ms) while in the state AHEAD."""
        if self.is_blocked(percept, context):
            self.fire("blocked")
            return self.turning(percept, context)
        return Proposal(WheelCommand(self.config.speed, self.config.speed), reason="room ahead")

    def turning(self, percept: Percept, context: Context) -> Proposal | None:
        """Turns until there is room."""
        if not self.is_blocked(percept, context):
            self.fire("freed")
            return self.ahead(percept, context)
        return Proposal(WheelCommand(-self.config.speed, self.config.speed), reason="something is near")

    def is_blocked(self, percept: Percept, context: Context) -> bool:
        """Whether one of the two front sensors sees something nearer than the clearance."""
        nearest = max(percept.infrared[RIGHT_FRONT], percept.infrared[LEFT_FRONT])
        return bool(context.geometry.infrared_distance(nearest) < self.config.clearance)
'''

TEST = """\
from __future__ import annotations

from pathlib import Path

from tolman.plugins import load_behaviors
from tolman.plugins.check import check_behavior
from tolman.plugins.testing import (
    Trial,
    assert_drives_forward,
    assert_in_place,
    assert_states,
    assert_turns,
    percept,
)

{Class} = load_behaviors(["{name}"], [Path(__file__).parent])["{name}"]


def test_it_drives_ahead_where_there_is_room() -> None:
    assert_drives_forward(Trial({Class}()).step())


def test_it_turns_left_in_place_where_something_is_near() -> None:
    proposal = Trial({Class}()).step(percept(front=0.02))
    assert_turns(proposal, "left")
    assert_in_place(proposal)


def test_it_goes_on_when_there_is_room_again() -> None:
    trial = Trial({Class}())
    trial.run([percept(), percept(front=0.02), percept()])
    states = {Class}.States
    assert_states(trial.states, states.AHEAD, states.TURNING, states.AHEAD)
    assert_drives_forward(trial.proposals[-1])


def test_it_conforms() -> None:
    report = check_behavior({Class})
    assert report.passed, report.text()
"""


def write_plugin(name: str, folder: Path) -> tuple[Path, Path]:
    """Writes the behavior and its test into `folder` (made if missing); returns both paths.

    Raises: PluginError for a name that is none or a folder that is a package, DuplicatePluginError if a
    plugin has the name or a file is there.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise PluginError(f"{name!r} cannot name a behavior: use lower case and dashes, as in turn-back")
    if name in discover().plugins():
        raise DuplicatePluginError(f"there is a behavior named {name!r} already: take another name")
    stem = name.replace("-", "_")
    words = name.split("-")
    replacements = {
        "{name}": name,
        "{Class}": "".join(word.capitalize() for word in words),
        "{Title}": " ".join(words).capitalize(),
    }
    if (folder / "__init__.py").exists():
        raise PluginError(
            f"{folder} is a Python package, not a folder for plugins: name another with --folder"
        )
    paths = (folder / f"{stem}.py", folder / f"test_{stem}.py")
    for path in paths:
        if path.exists():
            raise DuplicatePluginError(f"{path} exists: take another name or folder")
    folder.mkdir(parents=True, exist_ok=True)
    for path, text in zip(paths, (BEHAVIOR, TEST), strict=True):
        for key, value in replacements.items():
            text = text.replace(key, value)
        write_text(path, text)
    return paths
