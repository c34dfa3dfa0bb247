from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tools.torture import worlds as torture_worlds
from tools.torture.worlds import READERS, campaign, check


@pytest.mark.parametrize("name", sorted(READERS))
def test_a_mutated_file_gives_a_world_or_a_clear_error(name: str) -> None:
    outcomes = {check(name, seed) for seed in range(120)}
    assert False in outcomes


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_seed_of_mutation_will_do(data: st.DataObject) -> None:
    check(data.draw(st.sampled_from(sorted(READERS))), data.draw(st.integers(0, 2**63 - 1)))


def test_a_campaign_reports_what_hangs_takes_memory_or_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang(data: bytes) -> object:
        while True:
            pass

    valid, faults, memory = campaign("maze", 30)
    assert (faults, memory < 50e6) == ([], True)
    assert valid < 30
    monkeypatch.setattr(torture_worlds, "PATIENCE", 1)
    for name, read, problem in (
        ("greedy", lambda data: bytearray(2**30) if len(data) != 1 else None, "MemoryError"),
        ("raising", lambda data: {}[data], "KeyError"),
    ):
        monkeypatch.setitem(READERS, name, (b"x", read))
        monkeypatch.setattr(torture_worlds, "check", lambda name, seed: seed == 0 or READERS[name][1](b"xy"))
        assert problem in campaign(name, 2)[1][0]
    monkeypatch.setattr(torture_worlds, "check", lambda name, seed: seed == 0 or hang(b""))
    assert "hung" in campaign("maze", 2)[1][0]
