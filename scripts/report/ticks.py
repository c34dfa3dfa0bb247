"""Gathers ticks, of a recording or of a run under way, into what the page shows of them."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...agent.estimation.odometry import PathIntegrator
from ...agent.recording.explain import describe_event
from ...agent.recording.reader import RecordedTick
from ...files.messages import printable
from ...world.robot import Image, Pose, RobotGeometry
from .packing import Series

PLACE_STEP, ANGLE_STEP = 0.0005, 0.002
"""Meters and radians to which poses are kept: finer than the page can show."""
MAX_IMAGE_BYTES = 1_000_000
"""Of camera images in a page; of more, every second, fourth, ... is kept."""

KINDS = {
    "ControlChanged": "control",
    "BehaviorFaulted": "fault",
    "MediatorFaulted": "fault",
    "Stuck": "fault",
    "Lost": "fault",
    "NodeCreated": "node",
    "NodePassed": "node",
    "NodeReached": "node",
    "Localized": "node",
    "LoopClosed": "closure",
    "NodeCommitted": "map",
    "ArcAdded": "map",
    "LocalMapBuilt": "map",
    "CornerReached": "corner",
    "WallMet": "corner",
    "BehaviorStarted": "behavior",
    "BehaviorFinished": "behavior",
    "StepStarted": "mission",
    "StepEnded": "mission",
    "Said": "mission",
    "MissionEnded": "mission",
}
"""Class of an event -> the row in which the page shows it; all others are `other`."""
_FACTS = ("node", "source", "target", "distance", "behavior", "corner", "side", "previous", "winner")
"""Fields of events that the page uses, besides the words."""


class Gatherer:
    """Takes ticks one by one; `take` gives what came since the last time, packed for the page.

    start: the true pose of the first tick, at which the agent's own frame begins; None without truth.
    """

    def __init__(self, geometry: RobotGeometry) -> None:
        """geometry: the robot's, for the distances that its infrared values mean."""
        self._geometry = geometry
        self._names: dict[str, int] = {}
        self._texts: dict[str, int] = {}
        self._sent = (0, 0)
        self._reasons: dict[str, int] = {}
        self._states: dict[str, int] = {}
        self._odometry = PathIntegrator(geometry)
        self.start: Pose | None = None
        self.count = 0
        self._clear()

    def _clear(self) -> None:
        self._first = self.count
        self._numbers: list[int] = []
        self._true: list[tuple[float, float, float]] = []
        self._believed: list[tuple[float, float, float]] = []
        self._infrared: list[tuple[float, ...]] = []
        self._drivers: list[int] = []
        self._commands: list[tuple[float, float]] = []
        self._activations: dict[str, list[tuple[int, int]]] = defaultdict(list)
        self._reason_changes: dict[str, list[tuple[int, int]]] = defaultdict(list)
        self._state_changes: dict[str, list[tuple[int, int]]] = defaultdict(list)
        self._events: list[list[Any]] = []
        self._beliefs: list[list[Any]] = []
        self._images: list[tuple[int, Image]] = []

    # --- taking ticks in -----------------------------------------------------------------------------

    def add(self, tick: RecordedTick) -> None:
        """One tick more; they come in order."""
        at, percept = self.count, tick.percept
        if tick.truth is not None and self.start is None and at == 0:
            self.start = tick.truth
        self._numbers.append(percept.tick)
        self._infrared.append(tuple(percept.infrared[:8]))
        if tick.truth is not None:
            self._true.append((tick.truth.x, tick.truth.y, tick.truth.heading))
        self._believe(tick)
        self._drivers.append(0 if tick.driver is None else self._name(tick.driver))
        command = tick.command
        self._commands.append((0.0, 0.0) if command is None else (command.left, command.right))
        self._propose(at, tick)
        self._enter(at, tick.states)
        if tick.belief is not None:
            self._beliefs.append([at, {node: round(weight, 4) for node, weight in tick.belief.items()}])
        self._images.extend((at, image) for image in tick.images)
        for text in tick.events:
            self._hear(at, json.loads(text))
        self.count += 1

    def _believe(self, tick: RecordedTick) -> None:
        pose = tick.pose
        if pose is None:  # recorded by a tolman that did not keep it: near enough, without its calibration
            self._odometry.update(tick.percept.encoders)
            pose = self._odometry.pose
        if self.start is not None:
            pose = self.start.compose(pose.x, pose.y, pose.heading)
        self._believed.append((pose.x, pose.y, pose.heading))

    def _propose(self, at: int, tick: RecordedTick) -> None:
        for name, _, _, _, activation, reason in tick.proposals:
            name = str(name)
            level = max(1, min(255, round(255 * float(activation))))
            self._activations[name].append((at - self._first, level))
            text = self._text(str(reason))
            if self._reasons.get(name) != text:
                self._reasons[name] = text
                self._reason_changes[name].append((at, text))

    def _enter(self, at: int, states: Mapping[str, str] | None) -> None:
        if states is None:
            return
        for path in self._states.keys() - states.keys():
            if self._states[path] >= 0:
                self._states[path] = -1
                self._state_changes[path].append((at, -1))
        for path, state in states.items():
            text = self._text(state)
            if self._states.get(path) != text:
                self._states[path] = text
                self._state_changes[path].append((at, text))

    def _hear(self, at: int, event: Mapping[str, Any]) -> None:
        kind = str(event.get("$", "event"))
        row = KINDS.get(kind, "other")
        if kind == "BehaviorFinished" and not event.get("succeeded"):
            row = "fault"
        try:
            text = describe_event(event)
        except (TypeError, ValueError, LookupError, AttributeError):  # of a recording that holds anything
            text = kind
        facts = {name: event[name] for name in _FACTS if isinstance(event.get(name), str | int | float)}
        self._events.append([at, row, kind, printable(text)[:400], facts])

    def _name(self, name: str) -> int:
        """Numbers of behaviors begin at 1: 0 is nobody."""
        return self._names.setdefault(name, len(self._names) + 1)

    def _text(self, text: str) -> int:
        return self._texts.setdefault(printable(text)[:200], len(self._texts))

    @property
    def waiting(self) -> int:
        """How many ticks came since the last time."""
        return self.count - self._first

    # --- giving them out -----------------------------------------------------------------------------

    def take(self) -> dict[str, Any]:
        """What came since the last time, with arrays and series in it, for `pack`."""
        count = self.waiting
        names, texts = list(self._names), list(self._texts)
        true = self._poses(self._true) if len(self._true) == count else None
        chunk = {
            "first": self._first,
            "count": count,
            "numbers": Series(self._numbers),
            "names": names[self._sent[0] :],
            "texts": texts[self._sent[1] :],
            "true": true,
            "believed": self._poses(self._believed),
            "infrared": self._distances(),
            "driver": np.array(self._drivers, dtype=np.uint8),
            "left": Series([left for left, _ in self._commands]),
            "right": Series([right for _, right in self._commands]),
            "activations": {name: _levels(each, count) for name, each in self._activations.items()},
            "reasons": {name: _changes(each) for name, each in self._reason_changes.items()},
            "states": {path: _changes(each) for path, each in self._state_changes.items()},
            "events": self._events,
            "beliefs": self._beliefs,
            "images": _images(self._images),
        }
        self._sent = len(names), len(texts)
        self._clear()
        return chunk

    def _poses(self, poses: list[tuple[float, float, float]]) -> list[Series]:
        table = np.array(poses, dtype=np.float64).reshape(-1, 3)
        steps = (PLACE_STEP, PLACE_STEP, ANGLE_STEP)
        table[:, 2] = np.unwrap(table[:, 2])
        return [Series(table[:, column], step) for column, step in enumerate(steps)]

    def _distances(self) -> NDArray[np.uint8]:
        """(n * 8,) distances from the rim in 1/254 of the range; 255 is nothing in range."""
        response = np.array(self._geometry.infrared_response, dtype=np.float64)
        raw = np.array([[*each, *[0.0] * (8 - len(each))] for each in self._infrared], dtype=np.float64)
        raw = raw.reshape(-1)
        far = np.interp(raw, response[::-1, 1], response[::-1, 0])
        beyond = raw < response[-1, 1] * (1.0 - response[-1, 2])
        shares = np.rint(254.0 * far / self._geometry.infrared_range)
        return np.where(beyond, 255, shares).astype(np.uint8)


def _levels(levels: list[tuple[int, int]], count: int) -> NDArray[np.uint8]:
    dense = np.zeros(count, dtype=np.uint8)
    if levels:
        table = np.array(levels, dtype=np.int64)
        dense[table[:, 0]] = table[:, 1]
    return dense


def _changes(changes: list[tuple[int, int]]) -> list[Series]:
    return [Series([at for at, _ in changes]), Series([text for _, text in changes])]


def _images(images: list[tuple[int, Image]]) -> list[list[Any]]:
    """Tick, height, width, tones (1 or 3) and pixels of each image; of too many only some."""
    total, every = sum(image.size for _, image in images), 1
    while total / every > MAX_IMAGE_BYTES:
        every *= 2
    return [
        [at, image.shape[0], image.shape[1], 3 if image.ndim == 3 else 1, gray(image)]
        for at, image in images[::every]
    ]


def gray(values: NDArray[Any]) -> NDArray[np.uint8]:
    """Luminances in [0, 1] as bytes, flat."""
    levels = np.clip(np.nan_to_num(np.asarray(values, dtype=np.float64)), 0.0, 1.0)
    return np.asarray(np.rint(255.0 * levels), dtype=np.uint8).ravel()
