"""The subprocess's side of an isolated plugin: `python -m ...isolation.child SPEC READ WRITE PARENT`.

Gives up what a plugin does not need, imports the plugin, says what it is, and then answers tick by tick until
the pipe closes.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...agent.arbitration.mediator import Candidate, Mediator
from ...agent.behavior import Behavior, Context, Proposal
from ...agent.codec import decode, dumps, encode, known_classes
from ...agent.containment import describe
from ...agent.declarations import declared
from ...agent.events import Event, EventBus, Subscription
from ...agent.fields import configured
from ...world.robot import Image, RobotGeometry, WheelCommand
from ..errors import BrokenPluginError, IsolationError, PluginError
from ..loading import Plugin, constant, contained, entries, load_entry, plugins_in
from .confinement import confine, die_with_parent, folders_of_python, limit_resources, limited_cpu
from .described import description
from .wire import Channel, Kind, pack_proposal, unpack_tick

MEMORY = 1 << 30
"""Bytes that a plugin may take besides what Python and numpy have at the start."""
IMPORT_CPU = 10
"""Seconds of processor time that an import may take."""


def users_configs(cls: type[Behavior], settings: dict[str, Any]) -> dict[str, Any]:
    """The configurations of the behaviors that one drives by, from the user's settings by name."""
    configs: dict[str, Any] = {}
    for child in (declared(each).cls for each in cls.children.values()):
        if child.name in settings:
            configs[child.name] = configured(child.name, child.Config, None, settings[child.name])
        configs |= users_configs(child, settings)
    return configs


def plugins_of(spec: Mapping[str, Any]) -> list[Plugin]:
    """The plugins that a spec names: all or one of a file, or an entry point. Raises: PluginError."""
    if "file" in spec:
        found = plugins_in(Path(spec["file"]))
        return [plugin for plugin in found if spec.get("name") in (None, plugin.name)]
    for entry in entries(spec["group"]):
        if entry.value == spec["entry"]:
            cls = load_entry(entry, spec["group"])
            return [Plugin(entry.name, spec["group"], entry.value, constant(cls), spec)]
    raise BrokenPluginError(f"there is no entry point {spec['entry']!r}")


def readable(spec: Mapping[str, Any]) -> list[str]:
    """What the plugin of a spec is read from: its file's folder, or the packages of its entry point."""
    if "file" in spec:
        return [str(Path(spec["file"]).parent)]
    found = importlib.util.find_spec(str(spec["entry"]).partition(":")[0].partition(".")[0])
    if found is None:
        return []
    return [*(found.submodule_search_locations or ()), *([found.origin] if found.origin else ())]


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
            except BaseException as fault:
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


class MediatorServer:
    """Answers for one mediator."""

    def __init__(self, mediator: Mediator, channel: Channel) -> None:
        """Made after the mediator."""
        self._mediator, self._channel = mediator, channel

    def serve(self) -> None:
        """Until the pipe closes."""
        while True:
            kind, body = self._channel.receive()
            try:
                self._answer(kind, body)
            except IsolationError:
                raise
            except BaseException as fault:
                self._channel.send(Kind.FAULT, describe(fault).encode())

    def _answer(self, kind: int, body: bytes) -> None:
        if kind != Kind.ARBITRATE:
            self._mediator.reset()
            self._channel.send(Kind.DONE)
            return
        rows, previous = json.loads(body)
        candidates = [
            Candidate(name, priority, Proposal(WheelCommand(left, right), activation, reason))
            for name, priority, left, right, activation, reason in rows
        ]
        decision = self._mediator.arbitrate(candidates, previous)
        command = decision.command
        answer = [decision.winner, float(command.left), float(command.right), str(decision.reason)[:500]]
        self._channel.send(Kind.DECISION, json.dumps(answer).encode())


def begin(arguments: list[str]) -> tuple[dict[str, Any], Channel]:
    """Confines the process before anything of the plugin runs. arguments: spec, two pipes, parent."""
    spec = json.loads(arguments[0])
    channel = Channel(int(arguments[1]), int(arguments[2]))
    die_with_parent(int(arguments[3]))
    if spec.get("confined", True):
        limit_resources(MEMORY)
        confine([*folders_of_python(), *readable(spec)])
    return spec, channel


def main(arguments: list[str]) -> int:
    """Serves one plugin, or with no name in the spec only says what a file holds."""
    spec, channel = begin(arguments)
    try:
        with limited_cpu(IMPORT_CPU):
            plugins = plugins_of(spec)
        hello = [description(plugin.load(), plugin.group) for plugin in plugins]
        with contained("making one"):
            served = None if spec.get("name") is None else plugins[0].load()(**spec.get("settings", {}))
    except BaseException as fault:
        channel.send(Kind.FAULT, describe(fault, kind=not isinstance(fault, PluginError)).encode())
        return 1
    channel.send(Kind.HELLO, json.dumps(hello).encode())
    if served is not None:
        server = Server(served, channel) if isinstance(served, Behavior) else MediatorServer(served, channel)
        with contextlib.suppress(IsolationError):
            server.serve()
    return 0


if __name__ == "__main__":
    status = main(sys.argv[1:])
    os._exit(status)  # no threads and exit handlers of the plugin
