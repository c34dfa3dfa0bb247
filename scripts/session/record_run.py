"""Records a session: what happens, and how the session is made again."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...agent import Agent
from ...agent.recording.recorder import Recorder
from ...world import World
from .settings import load_settings
from .trust import code_of


@contextlib.contextmanager
def recorded(
    path: Path | None,
    kind: str,
    request: Any,
    agent: Agent,
    world: World,
    attachments: Mapping[str, bytes] | None = None,
    others: Sequence[Agent] = (),
) -> Iterator[None]:
    """Records what happens inside to `path`; does nothing for None.

    kind: "map", "go" or "mission". request: the session's, with all that makes it again. To be entered when
    the agent is made and nothing is started yet. others: the agents of the world's further robots.
    """
    if path is None:
        yield
        return
    header = {
        "kind": kind,
        "request": plain_request(request),
        "settings": load_settings(request.config),
        "seed": request.seed,
        "world": world.spec.name,
        "world_digest": world.spec.digest,
        "robots": len(world.robots),
        "geometry": agent.robot.geometry.name,
        "version": version("tolman"),
        "code": code_of(request.plugins),
    }
    truths = [partial(world.true_pose, index) for index in range(len(world.robots))]
    further = list(zip(others, truths[1:], strict=False))
    recorder = Recorder(path, agent, header, truths[0], attachments, further)
    recorder.start()
    try:
        yield
    finally:
        recorder.close()


def plain_request(request: Any) -> dict[str, Any]:
    """A request as JSON values: paths as text but for outputs, which a replay does not write."""
    values = asdict(request)
    for name, value in values.items():
        if isinstance(value, Path):
            values[name] = str(value)
        elif isinstance(value, tuple):
            values[name] = [str(item) for item in value]
    return values
