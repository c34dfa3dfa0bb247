"""The test kit: a behavior alone, step by step, without physics."""

from ..trial import FAR, ScriptedRobot, Trial, percept
from .assertions import (
    assert_drives_forward,
    assert_event_order,
    assert_in_place,
    assert_stands,
    assert_states,
    assert_turns,
    assert_valid,
    event_of,
)

__all__ = [
    "FAR",
    "ScriptedRobot",
    "Trial",
    "assert_drives_forward",
    "assert_event_order",
    "assert_in_place",
    "assert_stands",
    "assert_states",
    "assert_turns",
    "assert_valid",
    "event_of",
    "percept",
]
