from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tolman.agent.boundary.trace import Corner, WallSegment
from tolman.agent.codec import decode, dumps, loads, reinstate, snapshot
from tolman.agent.errors import CodecError
from tolman.agent.estimation.odometry import PathIntegrator
from tolman.agent.events import Event, PluginEvent
from tolman.agent.goals import Follow, FollowFrom
from tolman.world.robot import EPUCK, Pose

values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**60), 2**60), st.floats(), st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.tuples(inner, inner),
        st.dictionaries(st.text("abc", min_size=1, max_size=3), inner, max_size=3),
    ),
    max_leaves=8,
)


@given(values)
def test_any_plain_value_survives_the_codec(value: object) -> None:
    again = loads(dumps(value))
    assert type(again) is type(value)
    assert dumps(again) == dumps(value)


def test_events_and_goals_survive_the_codec() -> None:
    event: Event = PluginEvent(time=0.1, name="x", data={"goal": Follow("left", FollowFrom.CONCAVE)})
    assert loads(dumps(event)) == event
    array = np.arange(6, dtype=np.float32).reshape(2, 3)
    assert np.array_equal(loads(dumps(array)), array)


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[" * 10_000,
        '{"$":"Pose","z":1}',
        '{"$":"Pose","x":[],"self":1}',
        '{"$enum":"FollowFrom.NOWHERE"}',
        '{"$float":"much"}',
        '{"$float":{}}',
        '{"$tuple":5}',
        '{"$array":[1],"dtype":"no such"}',
        '{"$array":[1]}',
        '{"$array":[1],"dtype":"O"}',
        '{"$array":[1],"dtype":"(1000000,1000000)f8"}',
        '{"$array":[1],"dtype":"U1000000000"}',
        '{"$array":[[1],[2,3]],"dtype":"float64"}',
    ],
)
def test_text_that_is_no_value_is_refused(text: str) -> None:
    with pytest.raises(CodecError):
        loads(text)


def test_a_class_the_codec_does_not_know_stays_a_dict() -> None:
    assert loads('{"$":"os.system","command":"ls"}') == {"$": "os.system", "command": "ls"}


def test_a_class_that_is_named_to_it_is_made_again() -> None:
    corner = Corner("convex", 0.5, None, WallSegment(0.5, 0.01, 0.02))
    text = dumps([corner])
    assert decode(json.loads(text), Corner, WallSegment) == [corner]
    assert loads(text)[0]["kind"] == "convex"


def test_attributes_go_back_to_what_they_were() -> None:
    one, other = PathIntegrator(EPUCK, Pose(1.0, 2.0, 3.0)), PathIntegrator(EPUCK)
    reinstate(other, ("x", "_previous"), snapshot(one, ("x", "_previous")))
    assert (other.x, other.y) == (1.0, 0.0)
