"""The demo's choices; the demo itself is run by .ci/run."""

from hypothesis import given
from hypothesis import strategies as st
from tolman.scripts.demo import spread


@given(st.lists(st.integers(), min_size=1, max_size=40, unique=True), st.integers(1, 6))
def test_the_nodes_to_visit_are_different_and_known(nodes: list[int], count: int) -> None:
    chosen = spread(nodes, count)
    assert len(set(chosen)) == len(chosen) == min(count, len(nodes))
    assert set(chosen) <= set(nodes)


def test_the_nodes_to_visit_lie_apart() -> None:
    assert spread(list(range(9)), 3) == [1, 4, 7]
