"""A short form of `python -m tools.torture plugins`: some of each kind of fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.torture.misdeeds import misdeeds
from tools.torture.plugins import plugins

pytestmark = pytest.mark.slow
SOME = [
    "raise-base-stop",
    "interrupt-tick",
    "generator-exit-hear",
    "loop-reset",
    "endless-text-start",
    "swallow-make",
    "thread-start",
    "shouting-thread-tick",
    "at-exit-head",
    "priority-text",
    "result-holds-itself",
    "event-holds-itself",
    "event-of-a-mapper",
    "os-exit-import",
    "maps-patched",
    "parent-killed",
    "file-removed",
    "grandchild",
]


def test_there_are_a_hundred_kinds_and_each_is_python_or_meant_to_be_none() -> None:
    sources = {each.name: each.source for each in misdeeds()}
    assert len(sources) >= 100
    for name, source in sources.items():
        if name != "syntax":
            compile(source, name, "exec")


@pytest.mark.parametrize("name", SOME)
def test_a_run_goes_on_or_ends_in_one_line_with_wheels_at_rest(name: str, tmp_path: Path) -> None:
    assert [ending for ending in plugins(tmp_path, only=[name]) if ending.startswith("unclear")] == []
