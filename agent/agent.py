"""The agent: one control tick from percept to command, with every behavior's faults contained."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

import numpy as np

from ..world.robot import STOP, Percept, Robot, WheelCommand
from .behavior import Behavior, Context, Proposal
from .errors import AgentError, UnknownBehaviorError
from .events import BehaviorFaulted, BehaviorFinished, BehaviorStarted, ControlChanged, EventBus
from .mediator import Candidate, Mediator, PriorityMediator
from .path_integration import PathIntegrator

_log = logging.getLogger(__name__)


class Process(Protocol):
    """Something that watches every tick without driving: mapping, navigation, a mission, a recorder."""

    def update(self, percept: Percept, context: Context) -> None:
        """Called once a tick after path integration, before the behaviors propose."""


class Agent:
    """Drives one robot: owns its behaviors, mediator, path integration and event bus.

    A behavior that raises, or proposes what is not a finite command, is stopped; in that tick the wheels
    stand still; `BehaviorFaulted` says so. After `max_faults` it is disabled for the rest of the run.
    """

    def __init__(
        self,
        robot: Robot,
        behaviors: Iterable[Behavior],
        *,
        mediator: Mediator | None = None,
        seed: np.random.SeedSequence | None = None,
        max_faults: int = 3,
    ) -> None:
        """Raises: AgentError if two behaviors have the same name."""
        self.robot = robot
        self.bus = EventBus()
        self.mediator: Mediator = mediator or PriorityMediator()
        self.odometry = PathIntegrator(robot.geometry)
        self.processes: list[Process] = []
        self.context = Context(
            geometry=robot.geometry,
            publish=self.bus.publish,
            look=robot.look,
            rng=np.random.default_rng(seed if seed is not None else np.random.SeedSequence(0)),
        )
        self._behaviors: dict[str, Behavior] = {}
        for behavior in behaviors:
            if behavior.name in self._behaviors:
                raise AgentError(f"two behaviors are named {behavior.name!r}: rename or leave out one")
            self._behaviors[behavior.name] = behavior
        self._active: list[Behavior] = []
        self._suspended: set[str] = set()
        self._faults: dict[str, int] = {}
        self._max_faults = max_faults
        self.driver: str | None = None
        self.command: WheelCommand = STOP
        self.proposals: Sequence[Candidate] = ()

    # --- activating behaviors ------------------------------------------------------------------------

    @property
    def behaviors(self) -> dict[str, Behavior]:
        """All behaviors by name, active or not (a copy)."""
        return dict(self._behaviors)

    def behavior(self, name: str) -> Behavior:
        """The behavior of that name. Raises: UnknownBehaviorError, naming the known ones."""
        try:
            return self._behaviors[name]
        except KeyError:
            known = ", ".join(sorted(self._behaviors)) or "none"
            raise UnknownBehaviorError(f"unknown behavior {name!r}; known: {known}") from None

    def is_active(self, name: str) -> bool:
        """Whether the behavior takes part in arbitration."""
        return any(active.name == name for active in self._active)

    def start(self, name: str, goal: Any = None) -> None:
        """Resets the behavior, gives it the goal and lets it take part from the next tick on."""
        behavior = self.behavior(name)
        if self._faults.get(name, 0) >= self._max_faults:
            raise AgentError(f"behavior {name!r} was disabled after {self._max_faults} faults")
        if behavior in self._active:
            self._active.remove(behavior)
        behavior.reset()
        self.context.in_control = False
        behavior.on_start(goal, self.context)
        self._active.append(behavior)
        self._active.sort(key=lambda active: (-active.priority, active.name))
        self._suspended.discard(name)
        self.bus.publish(BehaviorStarted(time=self.context.time, behavior=name, goal=goal))

    def stop(self, name: str) -> None:
        """Takes the behavior out of arbitration; no event of success or failure follows."""
        behavior = self.behavior(name)
        if behavior in self._active:
            self._active.remove(behavior)
            self._suspended.discard(name)
            behavior.on_stop(self.context)

    def suspend(self, name: str) -> None:
        """Keeps the behavior as it is but asks it nothing until `resume`."""
        self.behavior(name)
        self._suspended.add(name)

    def resume(self, name: str) -> None:
        """Ends a `suspend`."""
        self._suspended.discard(name)

    # --- the tick ------------------------------------------------------------------------------------

    def tick(self) -> WheelCommand:
        """Senses, lets the behaviors propose, arbitrates, commands the robot and delivers the events."""
        percept = self.robot.sense()
        context, odometry = self.context, self.odometry
        odometry.update(percept.encoders)
        context.time = percept.time
        context.pose = odometry.pose
        context.distance, context.turn = odometry.distance, odometry.turn
        for process in self.processes:
            process.update(percept, context)
        self.proposals, faulted = self._collect(percept)
        decision = self.mediator.arbitrate(self.proposals, self.driver)
        command = STOP if faulted else decision.command.clamped(self.robot.geometry.max_speed)
        if decision.winner != self.driver:
            self._change_driver(decision.winner, decision.reason)
        self.command = command
        self.robot.act(command)
        self._retire()
        self.bus.deliver()
        return command

    def _collect(self, percept: Percept) -> tuple[list[Candidate], bool]:
        candidates: list[Candidate] = []
        faulted = False
        context = self.context
        for behavior in tuple(self._active):
            if behavior.name in self._suspended or behavior.finished:
                continue
            context.in_control = behavior.name == self.driver
            try:
                proposal = behavior.propose(percept, context)
                if proposal is None:
                    continue
                _check_proposal(proposal)
            except Exception as fault:
                self._contain(behavior, fault)
                faulted = True
                continue
            candidates.append(Candidate(behavior.name, behavior.priority, proposal))
        return candidates, faulted

    def _contain(self, behavior: Behavior, fault: Exception) -> None:
        count = self._faults[behavior.name] = self._faults.get(behavior.name, 0) + 1
        state = getattr(behavior.state, "name", str(behavior.state))
        disabled = count >= self._max_faults
        text = f"{type(fault).__name__}: {fault}"
        _log.error(
            "behavior %s stopped in state %s: %s%s",
            behavior.name,
            state,
            text,
            " (disabled)" if disabled else "",
        )
        self._active.remove(behavior)
        for subscription in self.bus.subscriptions(behavior.name):
            subscription.cancel()
        try:
            behavior.on_stop(self.context)
        except Exception as second:
            _log.error("behavior %s also raised in on_stop: %r", behavior.name, second)
        self.bus.publish(
            BehaviorFaulted(
                time=self.context.time, behavior=behavior.name, state=state, fault=text, disabled=disabled
            )
        )

    def _change_driver(self, winner: str | None, reason: str) -> None:
        wanted = {candidate.name: candidate.proposal.activation for candidate in self.proposals}
        self.bus.publish(
            ControlChanged(
                time=self.context.time, previous=self.driver, winner=winner, reason=reason, wanted=wanted
            )
        )
        self.driver = winner

    def _retire(self) -> None:
        for behavior in [active for active in self._active if active.finished]:
            self._active.remove(behavior)
            behavior.on_stop(self.context)
            self.bus.publish(
                BehaviorFinished(
                    time=self.context.time,
                    behavior=behavior.name,
                    succeeded=behavior.succeeded,
                    reason=behavior.reason,
                    result=behavior.result,
                )
            )


def _check_proposal(proposal: Any) -> None:
    if not isinstance(proposal, Proposal):
        raise TypeError(f"propose must return a Proposal or None, not {type(proposal).__name__}")
    if not isinstance(proposal.command, WheelCommand) or not proposal.command.is_finite():
        raise ValueError(f"the proposed command is not finite: {proposal.command!r}")
    if not (math.isfinite(proposal.activation) and 0.0 <= proposal.activation <= 1.0):
        raise ValueError(f"activation must be in [0, 1], not {proposal.activation!r}")


def run(agent: Agent, step: Callable[[], None], until: Callable[[], bool], max_ticks: int) -> bool:
    """Ticks agent and world in turn until `until()` holds (True) or `max_ticks` are over (False)."""
    for _ in range(max_ticks):
        agent.tick()
        step()
        if until():
            return True
    return False
