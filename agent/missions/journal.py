"""The journal of a mission: what is done, so that a mission goes on after a restart where it was."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...files.messages import quoted
from ...files.reading import read_text
from ...files.writing import write_text
from ..codec import decode, encode
from ..errors import CodecError, MissionError
from ..listener import Outcome

MAX_BYTES = 100_000_000
"""Largest journal that is read: of a million steps."""
_VERSION = 1


class Journal:
    """Completed steps by their place in the mission, in a file of JSON lines, or in memory alone.

    A line is written, and on the disk, before the mission goes on. A torn last line, as a power cut leaves
    it, is dropped: that step is done again.
    """

    def __init__(
        self,
        path: Path | None = None,
        *,
        mission: str = "",
        resume: bool = False,
        before: Callable[[], None] = lambda: None,
    ) -> None:
        """`resume`: take over what `path` holds. `before`: called before each line is written.

        Raises: MissionError if it is another mission's or damaged, FileError if it cannot be written.
        """
        self._path = path
        self._done: dict[str, tuple[str, Outcome]] = {}
        self.before = before
        if path is None:
            return
        if resume and path.exists():
            self._read(path, mission)
        else:
            head = {"tolman-mission": _VERSION, "mission": mission}
            write_text(path, json.dumps(head) + "\n", replace=True)

    def __len__(self) -> int:
        """How many steps are done."""
        return len(self._done)

    def recall(self, path: str, step: str) -> Outcome | None:
        """The outcome of the step at this place, None if it is not done.

        Raises: MissionError if another step stood there: the mission was changed in between.
        """
        if path not in self._done:
            return None
        recorded, outcome = self._done[path]
        if recorded != step:
            raise MissionError(
                f"the mission was changed since it was begun: step {path} was {recorded}, now {step}; "
                "run it from its beginning, without --resume"
            )
        return outcome

    def record(self, path: str, step: str, outcome: Outcome) -> None:
        """Keeps an outcome. Raises: MissionError if the disk does not take it."""
        self._done[path] = (step, outcome)
        if self._path is None:
            return
        self.before()
        entry = {
            "path": path,
            "step": step,
            "succeeded": outcome.succeeded,
            "value": encode(outcome.result),
            "reason": outcome.reason,
        }
        try:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as fault:
            raise MissionError(f"{self._path}: cannot be written: {fault.strerror}") from fault

    def _read(self, path: Path, mission: str) -> None:
        lines = read_text(path, MAX_BYTES, MissionError).split("\n")
        # What stands after the last newline was never completed.
        whole = lines[:-1]
        head = _parsed(path, 1, whole[0] if whole else "")
        if head.get("tolman-mission") != _VERSION:
            raise MissionError(f"{path}: not a mission's journal of version {_VERSION}")
        if head.get("mission") != mission:
            raise MissionError(f"{path}: the journal of {quoted(head.get('mission'))}, not of {mission!r}")
        for number, line in enumerate(whole[1:], start=2):
            entry = _parsed(path, number, line)
            try:
                outcome = Outcome(bool(entry["succeeded"]), decode(entry["value"]), str(entry["reason"]))
                self._done[str(entry["path"])] = (str(entry["step"]), outcome)
            except (KeyError, CodecError) as fault:
                raise MissionError(f"{path}, line {number}: damaged ({fault})") from fault
        if lines[-1]:
            write_text(path, "".join(line + "\n" for line in whole), replace=True)


def _parsed(path: Path, number: int, line: str) -> dict[str, Any]:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError) as fault:
        raise MissionError(f"{path}, line {number}: damaged ({fault})") from fault
    if not isinstance(entry, dict):
        raise MissionError(f"{path}, line {number}: damaged (not an object)")
    return entry
