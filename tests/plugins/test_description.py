from __future__ import annotations

import json

from tolman.behaviors.wall_following import WallFollowing
from tolman.plugins.description import described


def test_a_behavior_is_described_in_json_values() -> None:
    told = described(WallFollowing(distance=0.06))
    assert json.loads(json.dumps(told)) == told
    assert (told["name"], told["priority"], told["initial"]) == ("wall-following", 10, "SEARCH")
    assert told["settings"]["distance"] == 0.06
    assert told["about"].startswith("Keeps a wall at one side")


def test_each_transition_names_states_that_there_are() -> None:
    told = described(WallFollowing())
    assert told["edges"]
    for source, target, triggers in told["edges"]:
        assert {source, target} <= set(told["states"])
        assert triggers
