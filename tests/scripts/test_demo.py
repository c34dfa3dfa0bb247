"""The demo's choices; the demo itself is run by .ci/run."""

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from tolman.scripts.demo import spread, what_now


@given(st.lists(st.integers(), min_size=1, max_size=40, unique=True), st.integers(1, 6))
def test_the_nodes_to_visit_are_different_and_known(nodes: list[int], count: int) -> None:
    chosen = spread(nodes, count)
    assert len(set(chosen)) == len(chosen) == min(count, len(nodes))
    assert set(chosen) <= set(nodes)


def test_the_nodes_to_visit_lie_apart() -> None:
    assert spread(list(range(9)), 3) == [1, 4, 7]


def test_it_ends_by_saying_where_the_picture_is_and_what_to_try(tmp_path: Path) -> None:
    first, *_, last = what_now(tmp_path / "env1.tolman")
    assert first == f"Look at {tmp_path / 'env1.png'}"
    assert (Path(__file__).parents[2] / last.rpartition(" ")[2]).is_file()
