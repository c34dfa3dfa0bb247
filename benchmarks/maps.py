"""Measures the maps: SOM training, fit, free space, files. Run with `make bench`, or this module alone.

Prints each figure beside its target. Times are those of this machine as busy as it is: compare them within
one run. Exit status 0 whether or not targets are reached: a busy machine is no fault.
"""

from __future__ import annotations

from .figures import report
from .soms import som_figures
from .storage import storage_figures


def main() -> None:
    """Prints what was measured."""
    missed = report(som_figures()) + report(storage_figures())
    print(f"{missed} target(s) missed" if missed else "all targets reached")


if __name__ == "__main__":
    main()
