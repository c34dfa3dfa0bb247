"""The agent's side of plugins in subprocesses: a crash, a hang or a leak there costs a tick, not the run."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar

import numpy as np

from ...agent.arbitration.mediator import Candidate, Decision
from ...agent.behavior import Behavior, Context, Proposal
from ...agent.codec import decode, dumps, encode, known_classes
from ...agent.events import Event
from ...files.messages import printable
from ...world.robot import Percept, WheelCommand
from ..errors import IsolationError
from ..loading import BEHAVIORS
from .described import LONGEST, behavior_class, named
from .process import Subprocess
from .wire import Kind, pack_tick, unpack_proposal

ANSWER_TIMEOUT = 1.0
"""Seconds that an isolated plugin may take for a tick before it is killed."""
MOST_HEARD = 1000
"""Events that wait for an isolated behavior at most; more are not heard."""


class IsolatedBehavior(Behavior):
    """Stands for a behavior that runs in a subprocess; made by `isolated_class`.

    Any fault of the subprocess is one of the behavior. It is started again, in a new process if need be,
    with the goal it had, until it is disabled like any other.
    """

    _spec: ClassVar[Mapping[str, Any]]
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
        super().__init__(config, **settings)
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

    def _ask(self, percept: Percept, context: Context) -> Proposal | None:
        """What the subprocess proposes, whatever the state."""
        child = self._alive()
        heard, self._heard = self._heard, []
        for event in heard:
            child.channel.send(Kind.EVENT, event)
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

    def _hear(self, event: Event) -> None:
        if len(self._heard) < MOST_HEARD:
            self._heard.append(dumps(event).encode())

    def _alive(self) -> Subprocess:
        if self._child is None:
            self._child = Subprocess({**type(self)._spec, "settings": self._settings})
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
                    raise IsolationError(body.decode(errors="replace")[:LONGEST])
                self._serve(child, kind, body, context)
        except BaseException:
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
            context.subscribe(cls, self._hear)
        elif kind == Kind.RESULT:
            succeeded, reason, result = json.loads(body)
            self.finish(bool(succeeded), printable(str(reason)[:LONGEST]), decode(result))
        else:
            raise IsolationError(f"the subprocess sent a message of unknown kind {kind}")


class IsolatedMediator:
    """Stands for a mediator that runs in a subprocess; made by `isolated_class`.

    Any fault of the subprocess is one of the mediator: the agent goes on by priority.
    """

    slow_start = True
    name: ClassVar[str]
    spec: ClassVar[Mapping[str, Any]]

    def __init__(self, **options: Any) -> None:
        """options: the mediator's own. Raises: BrokenPluginError if it cannot be made with them."""
        self._child = Subprocess({**self.spec, "settings": options})

    def arbitrate(self, candidates: Sequence[Candidate], previous: str | None) -> Decision:
        """What the subprocess decides."""
        rows = [
            [name, priority, float(command.left), float(command.right), float(proposal.activation), reason]
            for name, priority, proposal in candidates
            for command, reason in ((proposal.command, str(proposal.reason)[:LONGEST]),)
        ]
        body = self._ask(Kind.ARBITRATE, json.dumps([rows, previous]).encode(), Kind.DECISION)
        winner, left, right, reason = json.loads(body)
        if winner is not None and winner not in [candidate.name for candidate in candidates]:
            raise IsolationError("the subprocess picks one that does not propose")
        return Decision(winner, WheelCommand(float(left), float(right)), printable(str(reason)[:LONGEST]))

    def reset(self) -> None:
        """The subprocess resets its mediator."""
        self._ask(Kind.STOP, b"", Kind.DONE)

    def close(self) -> None:
        """Ends the subprocess."""
        self._child.kill()

    def _ask(self, kind: Kind, body: bytes, wanted: Kind) -> bytes:
        self._child.channel.send(kind, body)
        answered, answer = self._child.receive(ANSWER_TIMEOUT)
        if answered != wanted:
            raise IsolationError(answer.decode(errors="replace")[:LONGEST])
        return answer


def isolated_class(spec: Mapping[str, Any], told: Mapping[str, Any]) -> type[Any]:
    """A class that stands for the plugin that a subprocess tells of. Raises: BrokenPluginError."""
    group, name = named(told)
    spec = {**spec, "group": group, "name": name}
    if group == BEHAVIORS:
        return behavior_class(IsolatedBehavior, IsolatedBehavior._ask, told, _spec=spec)
    about = printable(str(told.get("about"))[:LONGEST])
    body = {"name": name, "spec": spec, "__doc__": f"{about} (isolated)"}
    return type("Isolated", (IsolatedMediator,), body)


def close_all(plugins: Iterable[Any]) -> None:
    """Ends the subprocesses of those that have one."""
    for plugin in plugins:
        if isinstance(plugin, IsolatedBehavior | IsolatedMediator):
            plugin.close()
