"""The agent's side of plugins in subprocesses: a crash, a hang or a leak there costs a tick, not the run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import field, fields, is_dataclass, make_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ...agent.behavior import Behavior, Context, NoConfig, Proposal, Transition
from ...agent.codec import decode, dumps, encode, known_classes
from ...agent.events import Event
from ...world.robot import Percept, WheelCommand
from ..errors import BrokenPluginError, IsolationError
from .wire import Channel, Kind, pack_tick, unpack_proposal

START_TIMEOUT = 30.0
"""Seconds that a subprocess may take to import its plugin."""
ANSWER_TIMEOUT = 1.0
"""Seconds that an isolated plugin may take for a tick before it is killed."""


class Subprocess:
    """One running subprocess and its channel; killed when it is dropped."""

    def __init__(self, spec: Mapping[str, Any]) -> None:
        """Starts it and waits for what it says it is. Raises: BrokenPluginError, IsolationError."""
        to_child, child_writes = os.pipe(), os.pipe()
        child = (to_child[0], child_writes[1])
        arguments = [
            sys.executable,
            "-m",
            "tolman.plugins.isolation.child",
            json.dumps(spec),
            *map(str, child),
        ]
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            arguments,
            pass_fds=child,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | threads,
        )
        for descriptor in child:
            os.close(descriptor)
        self.channel = Channel(child_writes[0], to_child[1])
        self._finalizer = weakref.finalize(self, _end, self._process, self.channel)
        kind, body = self.receive(START_TIMEOUT)
        if kind != Kind.HELLO:
            self.kill()
            raise BrokenPluginError(f"in its subprocess: {body.decode(errors='replace')}")
        self.hello: list[dict[str, Any]] = json.loads(body)

    def receive(self, timeout: float) -> tuple[int, bytes]:
        """The next message. Raises: IsolationError, saying how the process ended if it did."""
        try:
            return self.channel.receive(time.monotonic() + timeout)
        except IsolationError as fault:
            self.kill()
            code = self._process.returncode
            raise IsolationError(f"{fault} (exit status {code})") from fault

    def kill(self) -> None:
        """Ends it now. More than once does no harm."""
        self._finalizer()


def _end(process: subprocess.Popen[bytes], channel: Channel) -> None:
    # Whoever ended by itself keeps its own status; who hangs is killed.
    try:
        process.wait(0.02)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    channel.close()


def describe_file(path: Path) -> list[dict[str, Any]]:
    """What a plugin file holds, found out in a subprocess. Raises: BrokenPluginError, IsolationError."""
    child = Subprocess({"file": str(path.resolve())})
    try:
        return child.hello
    finally:
        child.kill()


class IsolatedBehavior(Behavior):
    """Stands for a behavior that runs in a subprocess; made by `isolated_class`.

    Any fault of the subprocess is one of the behavior. It is started again, in a new process if need be,
    with the goal it had, until it is disabled like any other.
    """

    spec: ClassVar[Mapping[str, Any]]
    Config = NoConfig
    restarts = True
    slow_start = True

    def __init__(self, config: Any = None, **settings: Any) -> None:
        """settings: the plugin's own. Raises: BrokenPluginError if it cannot be made with them."""
        self._settings = settings
        self._child: Subprocess | None = None
        self._last_goal: Any = None
        self._users: dict[str, Any] = {}
        self._heard: list[bytes] = []
        self._members = list(type(self).States)
        super().__init__(config)
        self._alive()

    def on_reset(self) -> None:
        """The subprocess resets its behavior when it is started."""
        self._heard.clear()

    def adopt(self, configs: Mapping[str, Any]) -> None:
        """Keeps the user's settings for the behaviors that the subprocess makes."""
        for name, config in configs.items():
            if is_dataclass(config):
                self._users[name] = {each.name: getattr(config, each.name) for each in fields(config)}

    def fitted_goal(self, goal: Any) -> Any:
        """The goal, or the last one where it is started again without. The subprocess checks its fields."""
        goal = self._last_goal if goal is None else goal
        cls = type(self).Goal
        named = cls is not None and type(goal).__name__ == cls.__name__
        self._last_goal = goal if named else super().fitted_goal(goal)
        return self._last_goal

    def on_start(self, context: Context) -> None:
        """Starts the behavior in the subprocess, and that before, if it is not running."""
        geometry = encode(context.geometry)
        order = {
            "goal": encode(self.goal),
            "settings": encode(self._users),
            "seed": int(context.rng.integers(2**63)),
            "time": context.time,
            "geometry": {name: value for name, value in geometry.items() if name != "$"},
        }
        child = self._alive()
        child.channel.send(Kind.START, json.dumps(order).encode())
        self._wait(child, Kind.DONE, context)

    def ask(self, percept: Percept, context: Context) -> Proposal | None:
        """What the subprocess proposes, whatever the state."""
        child = self._alive()
        for event in self._heard:
            child.channel.send(Kind.EVENT, event)
        self._heard.clear()
        child.channel.send(Kind.TICK, pack_tick(percept, context))
        body = self._wait(child, Kind.PROPOSAL, context)
        command, activation, reason, state, _ = unpack_proposal(body)
        if state >= len(self._members):
            raise IsolationError(f"the subprocess names state {state} of {len(self._members)}")
        self._enter_state(self._members[state])
        if command is None:
            return None
        return Proposal(WheelCommand(*command), activation, reason)

    def on_stop(self, context: Context) -> None:
        """Lets the subprocess stop its behavior; it stays for the next start, unless it is at fault."""
        child = self._child
        if child is not None:
            child.channel.send(Kind.STOP)
            self._wait(child, Kind.DONE, context)

    def close(self) -> None:
        """Ends the subprocess."""
        if self._child is not None:
            self._child.kill()
            self._child = None

    def _alive(self) -> Subprocess:
        if self._child is None:
            self._child = Subprocess({**type(self).spec, "settings": self._settings})
        return self._child

    def _wait(self, child: Subprocess, wanted: Kind, context: Context) -> bytes:
        """Serves what the plugin asks for until the wanted answer comes."""
        deadline = time.monotonic() + ANSWER_TIMEOUT
        try:
            while True:
                kind, body = child.receive(deadline - time.monotonic())
                if kind == wanted:
                    return body
                if kind == Kind.FAULT:
                    raise IsolationError(body.decode(errors="replace"))
                self._serve(child, kind, body, context)
        except Exception:
            self.close()  # whatever went wrong: a new process knows nothing of it
            raise

    def _serve(self, child: Subprocess, kind: int, body: bytes, context: Context) -> None:
        if kind == Kind.PUBLISH:
            event = decode(json.loads(body))
            if not isinstance(event, Event):
                raise IsolationError("an isolated plugin can publish only built-in events, as PluginEvent")
            context.publish(event)
        elif kind == Kind.LOOK:
            image = np.ascontiguousarray(context.look(), dtype="<f4")
            size = b"".join(length.to_bytes(4, "little") for length in image.shape)
            child.channel.send(Kind.IMAGE, size + image.tobytes())
        elif kind == Kind.SUBSCRIBE:
            cls = known_classes().get(body.decode(errors="replace"), Event)
            context.subscribe(cls, lambda event: self._heard.append(dumps(event).encode()))
        elif kind == Kind.RESULT:
            succeeded, reason, result = json.loads(body)
            self.finish(bool(succeeded), str(reason), decode(result))
        else:
            raise IsolationError(f"the subprocess sent a message of unknown kind {kind}")


def isolated_class(spec: Mapping[str, Any], hello: Mapping[str, Any]) -> type[IsolatedBehavior]:
    """A behavior class that stands for the one in the subprocess. Raises: BrokenPluginError."""
    try:
        states = Enum(f"{hello['name']}-states", {name: name for name in hello["states"]})  # type: ignore[misc]
        rows = tuple(
            Transition(trigger, tuple(states[source] for source in sources), states[target])
            for trigger, sources, target in hello["transitions"]
        )
        body = {
            "name": str(hello["name"]),
            "priority": int(hello["priority"]),
            "States": states,
            "initial": states[hello["initial"]],
            "transitions": rows,
            "Goal": _goal_class(*hello["goal"]) if hello["goal"] else None,
            "spec": dict(spec) | {"name": str(hello["name"])},
            "__doc__": f"{hello['about']} (isolated)",
            "__module__": __name__,
        } | {state.name.lower(): IsolatedBehavior.ask for state in states}
    except (KeyError, TypeError, ValueError) as fault:
        raise BrokenPluginError(f"the subprocess of {dict(spec)} says nothing sensible: {fault}") from fault
    return type("Isolated", (IsolatedBehavior,), body)


def _goal_class(name: str, described: list[list[Any]]) -> type[Any]:
    """Stands for the goal's class: the same fields and defaults, of any type."""
    made: list[tuple[str, Any, Any]] = []
    for field_name, *default in described:
        made.append((field_name, Any, _default_of(default[0]) if default else field()))
    return make_dataclass(name, made, frozen=True)


def _default_of(encoded: Any) -> Any:
    return field(default_factory=lambda: decode(encoded))


def close_all(behaviors: Sequence[Behavior]) -> None:
    """Ends the subprocesses of those that have one."""
    for behavior in behaviors:
        if isinstance(behavior, IsolatedBehavior):
            behavior.close()
