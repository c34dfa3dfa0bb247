"""Assertions for tests of behaviors, whose failures say what was expected and what was there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import Any

from ...agent.behavior import Proposal
from ...agent.events import Event
from ...world.robot import EPUCK


def assert_valid(proposal: Any, max_speed: float = EPUCK.max_speed) -> Proposal:
    """The proposal is one: finite, within `max_speed` (steps/s), activation in [0, 1]. Returns it."""
    assert isinstance(proposal, Proposal), f"expected a Proposal, not {proposal!r}"
    command = proposal.command
    assert command.is_finite(), f"the command is not finite: {command!r}"
    assert abs(command.left) <= max_speed, f"left {command.left} steps/s is beyond {max_speed}"
    assert abs(command.right) <= max_speed, f"right {command.right} steps/s is beyond {max_speed}"
    assert 0.0 <= proposal.activation <= 1.0, f"activation {proposal.activation} is outside [0, 1]"
    return proposal


def assert_drives_forward(proposal: Proposal | None) -> None:
    """The robot's center would move ahead."""
    command = assert_valid(proposal).command
    assert command.left + command.right > 0.0, f"expected a way ahead, not {command!r}"


def assert_turns(proposal: Proposal | None, side: str) -> None:
    """The robot would turn to `side` ("left" or "right")."""
    command = assert_valid(proposal).command
    turn = command.right - command.left
    assert (turn > 0.0) if side == "left" else (turn < 0.0), f"expected a turn to the {side}, not {command!r}"


def assert_in_place(proposal: Proposal | None, tolerance: float = 1e-6) -> None:
    """The robot would stay where it is, turning or not."""
    command = assert_valid(proposal).command
    assert abs(command.left + command.right) <= tolerance, f"expected to stay in place, not {command!r}"


def assert_stands(proposal: Proposal | None) -> None:
    """The wheels would rest."""
    command = assert_valid(proposal).command
    assert command.left == command.right == 0.0, f"expected wheels at rest, not {command!r}"


def assert_states(seen: Iterable[Enum], *expected: Enum) -> None:
    """The states in the order in which they were entered are exactly these."""
    names = [state.name for state in seen]
    wanted = [state.name for state in expected]
    assert names == wanted, f"expected the states {' > '.join(wanted)}, saw {' > '.join(names)}"


def assert_event_order(events: Sequence[Event], *expected: type[Event]) -> None:
    """Events of these types occur in this order; others may come between."""
    rest = iter(events)
    for position, wanted in enumerate(expected):
        found = any(isinstance(event, wanted) for event in rest)
        names = ", ".join(type(event).__name__ for event in events) or "none"
        assert found, f"event {position + 1}, {wanted.__name__}, is missing in its place; there were: {names}"


def event_of(events: Iterable[Event], kind: type[Event]) -> Any:
    """The one event of that type. Fails if there is none or more than one."""
    found = [event for event in events if isinstance(event, kind)]
    assert len(found) == 1, f"expected one {kind.__name__}, there were {len(found)}"
    return found[0]
