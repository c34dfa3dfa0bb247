from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from .fuzz import READERS, check


@pytest.mark.parametrize("name", sorted(READERS))
def test_a_mutated_file_gives_a_world_or_a_clear_error(name: str) -> None:
    outcomes = {check(name, seed) for seed in range(120)}
    assert False in outcomes


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_seed_of_mutation_will_do(data: st.DataObject) -> None:
    check(data.draw(st.sampled_from(sorted(READERS))), data.draw(st.integers(0, 2**63 - 1)))
