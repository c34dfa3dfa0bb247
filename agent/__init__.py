"""From percepts to proposals: events, the behavior contract, the mediator, path integration, mapping.

The agent knows its robot only through `tolman.world.robot`; it never sees where the robot truly is.
"""

from . import events
from .agent import Agent, run
from .arbitration.mediator import Candidate, Decision, Mediator
from .arbitration.priority import PriorityMediator
from .behavior import Behavior, Child, Context, NoConfig, Proposal, Transition
from .errors import AgentError, BehaviorContractError, ConfigError, GoalError, UnknownBehaviorError
from .estimation.odometry import PathIntegrator
from .handle import Limits
from .listener import Listener, Outcome, TickListener
from .missions.mission import Mission, MissionRunner

__all__ = [
    "Agent",
    "AgentError",
    "Behavior",
    "BehaviorContractError",
    "Candidate",
    "Child",
    "ConfigError",
    "Context",
    "Decision",
    "GoalError",
    "Limits",
    "Listener",
    "Mediator",
    "Mission",
    "MissionRunner",
    "NoConfig",
    "Outcome",
    "PathIntegrator",
    "PriorityMediator",
    "Proposal",
    "TickListener",
    "Transition",
    "UnknownBehaviorError",
    "events",
    "run",
]
