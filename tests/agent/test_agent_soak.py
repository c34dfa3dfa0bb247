from __future__ import annotations

import pytest

from tools.soak_faults import KINDS, soak


@pytest.mark.slow
def test_thousands_of_ticks_with_faulty_plugins_move_nothing_that_was_stopped() -> None:
    count = soak(6000)
    assert set(count.faults) >= {f"faulty-{kind.replace(' ', '-')}" for kind in KINDS}
    assert count.moved_after_fault == 0
    assert count.collisions_by_stopped == 0
    assert count.memory < 20_000
