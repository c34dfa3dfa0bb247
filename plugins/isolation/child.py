"""The subprocess's side of an isolated plugin: `python -m tolman.plugins.isolation.child SPEC READ WRITE`.

Imports the plugin, says what it is, and then answers tick by tick until the pipe closes.
"""

from __future__ import annotations

import contextlib
import json
import resource
import sys
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np

from ...agent.behavior import Behavior, Context, Proposal
from ...agent.codec import decode, dumps, encode, known_classes
from ...agent.containment import describe
from ...agent.declarations import declared
from ...agent.events import Event, EventBus, Subscription
from ...agent.fields import configured
from ...world.robot import Image, RobotGeometry
from ..discovery import BEHAVIORS, discover, plugins_in
from ..errors import IsolationError
from .wire import Channel, Kind, pack_proposal, unpack_tick

MEMORY = 1 << 30
"""Bytes that a plugin may take besides what Python and numpy have at the start."""


def description(cls: type[Behavior]) -> dict[str, Any]:
    """What the agent needs to know of a behavior class, as JSON."""
    return {
        "name": cls.name,
        "priority": int(cls.priority),
        "states": [state.name for state in cls.States],
        "initial": cls.initial.name,
        "about": (cls.__doc__ or "").strip().partition("\n")[0],
        "transitions": [
            [row.trigger, [state.name for state in row.origins], row.target.name] for row in cls.transitions
        ],
        "goal": None if cls.Goal is None else [cls.Goal.__name__, _defaults(cls.Goal)],
    }


def _defaults(goal: type[Any]) -> list[list[Any]]:
    """Each field of a goal: its name, then, encoded, its default if it has one."""
    found: list[list[Any]] = []
    for each in fields(goal):
        if each.default_factory is not MISSING:
            found.append([each.name, encode(each.default_factory())])
        else:
            found.append([each.name] if each.default is MISSING else [each.name, encode(each.default)])
    return found


def users_configs(cls: type[Behavior], settings: dict[str, Any]) -> dict[str, Any]:
    """The configurations of the behaviors that one drives by, from the user's settings by name."""
    configs: dict[str, Any] = {}
    for child in (declared(each).cls for each in cls.children.values()):
        if child.name in settings:
            configs[child.name] = configured(child.name, child.Config, None, settings[child.name])
        configs |= users_configs(child, settings)
    return configs


def classes_of(spec: dict[str, Any]) -> list[type[Behavior]]:
    """The behavior classes that a spec names: all of a file, or one entry point."""
    if "file" in spec:
        found = [plugin for plugin in plugins_in(Path(spec["file"])) if plugin.group == BEHAVIORS]
        return [plugin.load() for plugin in found if spec.get("name") in (None, plugin.name)]
    return [discover().find(spec["name"]).load()]


class Server:
    """Answers for one behavior."""

    def __init__(self, behavior: Behavior, channel: Channel) -> None:
        """Made after the behavior; nothing is started yet."""
        self._behavior, self._channel = behavior, channel
        self._indices = {state: index for index, state in enumerate(type(behavior).States)}
        self._bus = EventBus(on_fault=self._handler_fault)
        self._fault: BaseException | None = None
        self._context: Context | None = None
        self._known = known_classes()

    def serve(self) -> None:
        """Until the pipe closes."""
        while True:
            kind, body = self._channel.receive()
            try:
                self._answer(kind, body)
            except IsolationError:
                raise
            except (Exception, SystemExit) as fault:
                self._channel.send(Kind.FAULT, describe(fault).encode())

    def _answer(self, kind: int, body: bytes) -> None:
        if kind == Kind.TICK:
            self._tick(body)
        elif kind == Kind.EVENT:
            self._bus.publish(decode(json.loads(body)))
            self._bus.deliver()
        elif kind == Kind.START:
            self._start(json.loads(body))
        elif kind == Kind.STOP and self._context is not None:
            self._behavior.stop(self._context)
            self._channel.send(Kind.DONE)
        else:
            self._channel.send(Kind.DONE)

    def _start(self, order: dict[str, Any]) -> None:
        self._bus = EventBus(on_fault=self._handler_fault)
        self._fault = None
        self._context = Context(
            geometry=RobotGeometry(**decode(order["geometry"])),
            publish=self._publish,
            look=self._look,
            rng=np.random.default_rng(order["seed"]),
            time=order["time"],
            subscribe=self._subscribe,
        )
        self._behavior.adopt(users_configs(type(self._behavior), decode(order["settings"])))
        self._behavior.start(decode(order["goal"]), self._context)
        self._channel.send(Kind.DONE)

    def _tick(self, body: bytes) -> None:
        context, behavior = self._context, self._behavior
        if context is None:
            raise IsolationError("a tick before the start")
        if self._fault is not None:
            raise self._fault
        percept = unpack_tick(body, context)
        proposal = behavior.propose(percept, context)
        if proposal is not None and type(proposal) is not Proposal:
            raise TypeError(f"propose must return a Proposal or None, not {type(proposal).__name__}")
        if behavior.finished:
            result = [behavior.succeeded, behavior.reason, encode(behavior.result)]
            self._channel.send(Kind.RESULT, json.dumps(result).encode())
        state = self._indices[behavior.state]
        if proposal is None:
            answer = pack_proposal(None, 0.0, "", state, behavior.finished)
        else:
            command = (proposal.command.left, proposal.command.right)
            answer = pack_proposal(command, proposal.activation, proposal.reason, state, behavior.finished)
        self._channel.send(Kind.PROPOSAL, answer)

    def _publish(self, event: Event) -> bool:
        self._channel.send(Kind.PUBLISH, dumps(event).encode())
        return True

    def _subscribe(self, event_type: type[Any], handler: Any) -> Subscription:
        self._channel.send(Kind.SUBSCRIBE, event_type.__name__.encode())
        return self._bus.subscribe(event_type, handler, owner=self._behavior.name)

    def _handler_fault(self, owner: str, fault: BaseException) -> None:
        self._fault = fault

    def _look(self) -> Image:
        self._channel.send(Kind.LOOK)
        kind, body = self._channel.receive()
        if kind != Kind.IMAGE:
            raise IsolationError("no image came")
        height, width = int.from_bytes(body[:4], "little"), int.from_bytes(body[4:8], "little")
        return np.frombuffer(body[8:], dtype="<f4").reshape(height, width).astype(np.float32)


def limit_memory(extra: int = MEMORY) -> None:
    """Lets this process take `extra` more bytes of address space than it has now (Linux)."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + extra
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    except (OSError, ValueError):
        return  # elsewhere than on Linux: a leak is noticed by whoever looks at the machine


def main(arguments: list[str]) -> int:
    """Serves one plugin, or with no name in the spec only says what a file holds."""
    spec = json.loads(arguments[0])
    channel = Channel(int(arguments[1]), int(arguments[2]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        classes = classes_of(spec)
        hello = [description(cls) for cls in classes]
        behavior = None if spec.get("name") is None else classes[0](**spec.get("settings", {}))
    except (Exception, SystemExit) as fault:
        channel.send(Kind.FAULT, describe(fault).encode())
        return 1
    channel.send(Kind.HELLO, json.dumps(hello).encode())
    if behavior is not None:
        limit_memory()
        with contextlib.suppress(IsolationError, KeyboardInterrupt):
            Server(behavior, channel).serve()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
