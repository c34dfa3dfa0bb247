from __future__ import annotations

from tolman.agent.recording.explain import timeline
from tolman.agent.recording.reader import RecordedTick, Recording
from tolman.plugins.testing import percept


def test_an_event_that_holds_anything_is_told_in_one_line() -> None:
    events = ['{"$":"StepEnded"}', '{"$":"ControlChanged","wanted":5}', '{"time":[],"$":"a\\u001b[31m\\n"}']
    recording = Recording({}, ticks=[RecordedTick(percept(), events=events)], complete=True)
    lines = list(timeline(recording))
    assert ["cannot be told" in line for line in lines[:3]] == [True, True, True]
    assert all(line.isprintable() for line in lines)
