"""The agent: one control tick from percept to command, with every behavior's faults contained."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..files.interrupts import ends_run
from ..world.robot import STOP, Image, Percept, Robot, WheelCommand
from .arbitration.mediator import Candidate, Decision, Mediator
from .arbitration.priority import PriorityMediator
from .behavior import Behavior, Context
from .containment import Watchdog, check_command, describe, state_name
from .errors import AgentError, ConfigError, UnknownBehaviorError
from .estimation.odometry import PathIntegrator
from .events import (
    BehaviorFaulted,
    BehaviorFinished,
    BehaviorStarted,
    ControlChanged,
    EventBus,
    MediatorFaulted,
)
from .handle import BehaviorHandle, Limits
from .listener import Listener, Updated

_log = logging.getLogger(__name__)


class Agent:
    """Drives one robot: owns its behaviors, mediator, path integration and event bus.

    It also makes the children of its behaviors: each with the settings of its own behavior of that name.

    A behavior that raises, proposes what is not a sane command, exceeds its time budget, floods the bus or
    leaks subscriptions is stopped; in that tick the wheels stand still; `BehaviorFaulted` says so. After
    `max_faults` it is disabled for the rest of the run. A mediator that breaks is replaced by priorities.
    """

    def __init__(
        self,
        robot: Robot,
        behaviors: Iterable[Behavior],
        *,
        mediator: Mediator | None = None,
        seed: np.random.SeedSequence | None = None,
        max_faults: int = 3,
        limits: Limits = Limits(),  # noqa: B008  frozen
    ) -> None:
        """Raises: AgentError if two behaviors have the same name."""
        self.robot = robot
        self.bus = EventBus(on_fault=self._handler_fault)
        self.mediator: Mediator = mediator or PriorityMediator()
        self.first_mediator = self.mediator
        """The one it was made with, also after it broke."""
        self.odometry = PathIntegrator(robot.geometry)
        self._listeners: tuple[Updated, ...] = ()
        seed = seed if seed is not None else np.random.SeedSequence(0)
        self.context = Context(
            geometry=robot.geometry,
            publish=self.bus.publish,
            look=self._look,
            rng=np.random.default_rng(seed),
            subscribe=self.bus.subscribe,
        )
        watch = Watchdog(limits.budget, limits.hang, self._rest)
        self._hang = limits.hang
        self._wildest = limits.wild * robot.geometry.max_speed
        self._ports: dict[str, BehaviorHandle] = {}
        for behavior in behaviors:
            name = type(behavior).name
            if name in self._ports:
                raise AgentError(f"two behaviors are named {name!r}: rename or leave out one")
            self._ports[name] = BehaviorHandle(
                behavior, self.bus, limits, watch, robot.geometry, self._look, seed
            )
        configs = {name: port.behavior.config for name, port in self._ports.items()}
        self._active: list[BehaviorHandle] = []
        self._suspended: set[str] = set()
        self._faults: dict[str, int] = {}
        self._max_faults = max_faults
        self._to_restart: list[str] = []
        self._halt = False
        self.driver: str | None = None
        self.command: WheelCommand = STOP
        self.proposals: Sequence[Candidate] = ()
        for port in self._ports.values():
            try:
                port.adopt(configs)
            except ConfigError:
                raise
            except BaseException as fault:
                self._contain(port, fault)

    def __repr__(self) -> str:
        """`<Agent at 12.3 s, wall-following drives; active: obstacle-avoidance, wall-following; of 14>`."""
        active = ", ".join(port.name for port in self._active) or "none"
        drives = f"{self.driver or 'nobody'} drives"
        return f"<Agent at {self.context.time:.1f} s, {drives}; active: {active}; of {len(self._ports)}>"

    # --- activating behaviors ------------------------------------------------------------------------

    @property
    def behaviors(self) -> dict[str, Behavior]:
        """All behaviors by name, active or not (a copy)."""
        return {name: port.behavior for name, port in self._ports.items()}

    def behavior(self, name: str) -> Behavior:
        """The behavior of that name. Raises: UnknownBehaviorError, naming the known ones."""
        return self._port(name).behavior

    def is_active(self, name: str) -> bool:
        """Whether the behavior takes part in arbitration."""
        return any(active.name == name for active in self._active)

    def is_disabled(self, name: str) -> bool:
        """Whether it had so many faults that it cannot be started any more."""
        return self._faults.get(name, 0) >= self._max_faults

    def states(self) -> dict[str, str]:
        """The state of each active behavior and, as `parent/child`, of the behaviors that it drives by."""
        found: dict[str, str] = {}
        for port in self._active:
            _add_states(found, port.name, port.behavior)
        return found

    def belief(self) -> dict[int, float]:
        """Node -> probability, of what finds out where the robot is; empty where nothing does."""
        found: dict[int, float] = {}
        for listener in self._listeners:
            if isinstance(listener, Listener):
                found.update(listener.belief())
        return found

    def start(self, name: str, goal: Any = None) -> None:
        """Resets the behavior, gives it the goal and lets it take part from the next tick on.

        goal: of the behavior's `Goal`, a mapping of its fields, or None where it has only defaults.
        A fault in doing so is contained like one in a tick. Raises: AgentError if it is disabled.
        """
        port = self._port(name)
        if self.is_disabled(name):
            raise AgentError(f"behavior {name!r} was disabled after {self._max_faults} faults")
        if port in self._active:
            self._active.remove(port)
            port.release()
        port.renew(self.context, False)
        self._active.append(port)
        self._active.sort(key=lambda active: (-active.priority, active.name))
        self._suspended.discard(name)
        try:
            fitted = port.start(goal)
        except BaseException as fault:
            self._contain(port, fault)
            return
        self.bus.publish(BehaviorStarted(time=self.context.time, behavior=name, goal=fitted))

    def stop(self, name: str) -> None:
        """Takes the behavior out of arbitration; no event of success or failure follows."""
        port = self._port(name)
        if port in self._active:
            self._leave(port)

    def suspend(self, name: str) -> None:
        """Keeps the behavior as it is but asks it nothing until `resume`."""
        self._port(name)
        self._suspended.add(name)

    def resume(self, name: str) -> None:
        """Ends a `suspend`."""
        self._suspended.discard(name)

    def close(self) -> None:
        """Stops all behaviors."""
        for port in tuple(self._active):
            self._leave(port)

    # --- listeners -----------------------------------------------------------------------------------

    def attach(self, listener: Updated) -> None:
        """Has the listener's `update` called once a tick, after those attached before, from the next tick on.

        More than once does no harm.
        """
        if all(each is not listener for each in self._listeners):
            self._listeners = (*self._listeners, listener)

    def detach(self, listener: Updated) -> None:
        """Has it called no more, from the next tick on; one that is not attached does no harm."""
        self._listeners = tuple(each for each in self._listeners if each is not listener)

    # --- the tick ------------------------------------------------------------------------------------

    def tick(self) -> WheelCommand:
        """Senses, lets the behaviors propose, arbitrates, commands the robot and delivers the events."""
        percept = self.robot.sense()
        context, odometry = self.context, self.odometry
        odometry.update(percept.encoders)
        context.time = percept.time
        context.pose = odometry.pose
        context.distance, context.turn = odometry.distance, odometry.turn
        if self._to_restart:
            self._restart()
        for listener in self._listeners:
            listener.update(percept, context)
        halt, self._halt = self._halt, False
        self.proposals = proposals = self._collect(percept)
        decision = self._arbitrate(proposals)
        if halt or self._halt:
            command, self._halt = STOP, False
        else:
            command = decision.command.clamped(self.robot.geometry.max_speed)
        if decision.winner != self.driver:
            self._change_driver(decision.winner, decision.reason)
        self.command = command
        self.robot.act(command)
        self._retire()
        self.bus.deliver()
        return command

    def _collect(self, percept: Percept) -> list[Candidate]:
        candidates: list[Candidate] = []
        context, driver = self.context, self.driver
        for port in tuple(self._active):
            suspended = port.name in self._suspended
            if not suspended:
                port.renew(context, port.name == driver)
            try:
                proposal = port.ask(percept, suspended)
            except BaseException as fault:
                self._contain(port, fault)
                continue
            if proposal is not None:
                candidates.append(Candidate(port.name, port.priority, proposal))
        return candidates

    def _arbitrate(self, proposals: Sequence[Candidate]) -> Decision:
        mediator = self.mediator
        try:
            if type(mediator) is PriorityMediator:
                return mediator.arbitrate(proposals, self.driver)
            with Watchdog(None, self._hang, self._rest):
                decision = mediator.arbitrate(proposals, self.driver)
            self._check(decision)
            return decision
        except BaseException as fault:
            if ends_run(fault):
                raise
            name = str(getattr(type(mediator), "name", type(mediator).__name__))
            text = describe(fault)
            _log.error("mediator %s stopped: %s; going on by priority", name, text)
            self.bus.publish(MediatorFaulted(time=self.context.time, mediator=name, fault=text))
            self.mediator = PriorityMediator()
            self._halt = True
            return self.mediator.arbitrate(proposals, self.driver)

    def _check(self, decision: Any) -> None:
        if type(decision) is not Decision or type(decision.command) is not WheelCommand:
            raise TypeError(f"arbitrate must return a Decision, not {type(decision).__name__}")
        if type(decision.winner) not in (str, type(None)) or type(decision.reason) is not str:
            raise TypeError("a decision's winner and reason must be texts")
        check_command(decision.command, self._wildest)

    def _change_driver(self, winner: str | None, reason: str) -> None:
        wanted = {candidate.name: candidate.proposal.activation for candidate in self.proposals}
        reasons = {candidate.name: candidate.proposal.reason for candidate in self.proposals}
        self.bus.publish(
            ControlChanged(
                time=self.context.time,
                previous=self.driver,
                winner=winner,
                reason=reason,
                wanted=wanted,
                reasons=reasons,
            )
        )
        self.driver = winner

    def _retire(self) -> None:
        for port in tuple(self._active):
            if (outcome := port.outcome) is None:
                continue
            self._leave(port)
            self.bus.publish(
                BehaviorFinished(
                    time=self.context.time,
                    behavior=port.name,
                    succeeded=outcome.succeeded,
                    reason=outcome.reason,
                    result=outcome.result,
                )
            )

    # --- faults --------------------------------------------------------------------------------------

    def _contain(self, port: BehaviorHandle, fault: BaseException) -> None:
        """Stops a behavior that broke the contract, and the wheels for this tick.

        Raises: what it is given, where that is the user's wish to end.
        """
        if ends_run(fault):
            raise fault
        name, state = port.name, state_name(port.behavior)
        self._halt = True
        self._faults[name] = self._faults.get(name, 0) + 1
        disabled = self.is_disabled(name)
        text = describe(fault)
        _log.error(
            "behavior %s stopped in state %s: %s%s", name, state, text, " (disabled)" if disabled else ""
        )
        self._leave(port)
        self.bus.publish(
            BehaviorFaulted(time=self.context.time, behavior=name, state=state, fault=text, disabled=disabled)
        )
        if port.restarts and not disabled:
            self._to_restart.append(name)

    def _leave(self, port: BehaviorHandle) -> None:
        if port in self._active:
            self._active.remove(port)
        self._suspended.discard(port.name)
        if problem := port.end():
            _log.error("behavior %s raised in on_stop: %s", port.name, problem)

    def _handler_fault(self, owner: str, fault: BaseException) -> None:
        port = self._ports.get(owner)
        if port is not None and port in self._active:
            self._contain(port, fault)

    def _restart(self) -> None:
        names, self._to_restart = self._to_restart, []
        for name in names:
            if not self.is_active(name):
                self.start(name)

    def _rest(self) -> None:
        """Stops the wheels, for a process that ends here."""
        with contextlib.suppress(Exception):
            self.robot.act(STOP)

    def _look(self) -> Image:
        return self.robot.look()

    def _port(self, name: str) -> BehaviorHandle:
        try:
            return self._ports[name]
        except KeyError:
            known = ", ".join(sorted(self._ports)) or "none"
            raise UnknownBehaviorError(f"unknown behavior {name!r}; known: {known}") from None


def _add_states(found: dict[str, str], path: str, behavior: Behavior) -> None:
    found[path] = state_name(behavior)
    for role in type(behavior).children:
        child: Behavior = getattr(behavior, role)
        _add_states(found, f"{path}/{child.name}", child)


def run(agent: Agent, step: Callable[[], None], until: Callable[[], bool], max_ticks: int) -> bool:
    """Ticks agent and world in turn until `until()` holds (True) or `max_ticks` are over (False)."""
    for _ in range(max_ticks):
        agent.tick()
        step()
        if until():
            return True
    return False
