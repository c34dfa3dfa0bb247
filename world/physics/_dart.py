"""The one place that imports dartpy, with a message that helps where it cannot be loaded."""

from __future__ import annotations

from typing import Any

from ..errors import EngineMissingError


def _load() -> Any:
    try:
        import dartpy
    except ImportError as error:
        raise EngineMissingError(explain(str(error))) from error
    return dartpy


def explain(problem: str) -> str:
    """One line that says what to install, for the text of an ImportError."""
    for library, package in (("libGL", "libgl1"), ("libX11", "libx11-6")):
        if library in problem:
            return (
                f"DART cannot be loaded: the system library {library} is missing; "
                f"on Debian or Ubuntu: apt-get install {package}"
            )
    if "No module named" in problem:
        return (
            "DART cannot be loaded: dartpy is not installed; install it with: pip install 'dartpy>=6.20,<7'"
        )
    return f"DART cannot be loaded: {problem.splitlines()[0] if problem else 'unknown reason'}"


dartpy: Any = _load()
