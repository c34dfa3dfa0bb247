"""Reads a recording back as a timeline: what happened, who drove, and why."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ...files.messages import printable, quoted
from ...world.robot import CONTROL_PERIOD
from .reader import RecordedTick, Recording

CUT_OFF = "the recording is cut off here"
_QUIET = ("time",)


def timeline(recording: Recording, *, changes_only: bool = False) -> Iterator[str]:
    """One line an event, then how long each behavior drove. changes_only: changes of control alone.

    A change of control is told with who wanted what: `wander (0.30: driving a leg)`. The world's further
    robots follow, each after a line with its number.
    """
    yield from _told(recording.ticks, changes_only)
    for index, ticks in enumerate(recording.others, start=1):
        yield f"robot {index}:"
        yield from _told(ticks, changes_only)
    if not recording.complete:
        yield CUT_OFF


def _told(recorded: Sequence[RecordedTick], changes_only: bool) -> Iterator[str]:
    for tick in recorded:
        for text in tick.events:
            event = json.loads(text)
            if not changes_only or event.get("$") == "ControlChanged":
                yield printable(_line(event, tick.percept.time))
    yield from _shares(recorded)


def _line(event: Mapping[str, Any], now: float) -> str:
    try:
        return f"{float(event.get('time', now)):9.3f} s  {describe_event(event)}"
    except (TypeError, ValueError, LookupError, AttributeError):  # of a recording that holds anything
        return f"{now:9.3f} s  an event that cannot be told: {quoted(event)}"


def describe_event(event: Mapping[str, Any]) -> str:
    """A recorded event in words."""
    kind = str(event.get("$", "event"))
    if kind == "ControlChanged":
        return _control(event)
    if kind == "BehaviorFaulted":
        end = ", disabled" if event.get("disabled") else ""
        return f"{event['behavior']} STOPPED in state {event['state']}: {event['fault']}{end}"
    if kind == "BehaviorStarted":
        return f"{event['behavior']} started" + _with("goal", event.get("goal"))
    if kind == "BehaviorFinished":
        how = "done" if event.get("succeeded") else "FAILED"
        return f"{event['behavior']} {how}: {event.get('reason')}"
    if kind == "StepStarted":
        return f"step {event['path']}: {event['step']}"
    if kind == "StepEnded":
        how = "done" if event.get("succeeded") else f"FAILED: {event.get('reason')}"
        return f"step {event['path']} {how}"
    fields = ", ".join(
        f"{name}={_value(value)}" for name, value in event.items() if name not in _QUIET and name != "$"
    )
    return f"{kind}({fields})"


def _control(event: Mapping[str, Any]) -> str:
    winner = event.get("winner") or "nobody"
    previous = event.get("previous") or "nobody"
    reasons = event.get("reasons", {})
    rivals = [
        f"{name} ({activation:.2f}{': ' + reasons[name] if reasons.get(name) else ''})"
        for name, activation in event.get("wanted", {}).items()
        if name != winner
    ]
    also = f"; also wanted it: {', '.join(rivals)}" if rivals else ""
    return f"control: {previous} -> {winner}, because {event.get('reason')}{also}"


def _with(name: str, value: Any) -> str:
    return "" if value is None else f", {name} {_value(value)}"


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict) and "$" in value:
        inner = ", ".join(f"{key}={_value(item)}" for key, item in value.items() if key != "$")
        return f"{value['$']}({inner})"
    if isinstance(value, dict) and len(value) == 1 and next(iter(value)).startswith("$"):
        return _value(next(iter(value.values())))
    text = str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _shares(recorded: Sequence[RecordedTick]) -> Iterable[str]:
    ticks: dict[str, int] = {}
    for tick in recorded:
        driver = tick.driver or "nobody"
        ticks[driver] = ticks.get(driver, 0) + 1
    total = sum(ticks.values())
    for driver, count in sorted(ticks.items(), key=lambda item: (-item[1], item[0])):
        yield f"{printable(driver)} drove {count * CONTROL_PERIOD:.1f} s ({count / total:.0%})"
