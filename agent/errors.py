"""What can go wrong in the agent, as exceptions with one common base."""

from __future__ import annotations


class AgentError(Exception):
    """Base of every error the agent raises."""


class UnknownBehaviorError(AgentError, LookupError):
    """A behavior was named that the agent does not have."""


class BehaviorContractError(AgentError, TypeError):
    """A behavior class does not keep the contract of `agent.behavior`."""


class ConfigError(AgentError, ValueError):
    """A configuration value has the wrong name, type or range."""


class GoalError(AgentError, TypeError):
    """A behavior was given a goal that is none of its kind."""


class EventFloodError(AgentError, RuntimeError):
    """A behavior published more events in one tick than it may."""


class SubscriptionLeakError(AgentError, RuntimeError):
    """A behavior holds more subscriptions than it may."""


class BudgetExceededError(AgentError, TimeoutError):
    """A behavior took longer for a tick than it may."""


class CodecError(AgentError, ValueError):
    """A value that cannot be written as JSON, or text that is none of ours."""


class MissionError(AgentError, ValueError):
    """A mission that cannot be read or does not say what it must."""


class StepFailedError(AgentError, RuntimeError):
    """A mission's step failed; `step` and `reason` say which and why. Raised inside the mission."""

    def __init__(self, step: object, reason: str) -> None:
        """step: as it was yielded."""
        super().__init__(f"{step}: {reason}")
        self.step = step
        self.reason = reason


class RecordingError(AgentError, ValueError):
    """A file that is no recording, or one that cannot be replayed here."""
