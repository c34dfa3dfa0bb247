"""Property tests draw the same examples every time and are not timed: a loaded machine fails nothing."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("tolman", deadline=None, derandomize=True)
settings.register_profile("quick", deadline=None, derandomize=True, max_examples=20)  # of `make check`
settings.load_profile("tolman")
