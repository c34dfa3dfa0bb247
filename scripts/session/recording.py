"""Records a session: what happens, and how the session is made again."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...agent.recording.recorder import Recorder
from ..errors import SessionError
from .trust import code_of

if TYPE_CHECKING:
    from .requests import RunSettings
    from .stage import Stage


@contextlib.contextmanager
def recorded(
    path: Path | None,
    kind: str,
    request: RunSettings,
    stage: Stage,
    attachments: Mapping[str, bytes] | None = None,
) -> Iterator[None]:
    """Records what happens inside to `path`; does nothing for None.

    kind: "map", "go" or "mission". request: the session's, with all that makes it again. To be entered when
    the agents are made and nothing is started yet. Raises: SessionError for a session that has gone on.
    """
    if path is None:
        yield
        return
    world, agents = stage.world, stage.agents
    if stage.begun:
        raise SessionError(
            f"{path}: only a run from its start can be recorded; open another simulation for it"
        )
    header = {
        "kind": kind,
        "request": plain_request(request),
        "settings": stage.options,
        "seed": request.seed,
        "world": world.spec.name,
        "world_digest": world.spec.digest,
        "robots": len(world.robots),
        "geometry": stage.agent.robot.geometry.name,
        "version": version("tolman"),
        "code": code_of(request.plugins),
    }
    truths = [partial(world.true_pose, index) for index in range(len(agents))]
    further = list(zip(agents[1:], truths[1:], strict=True))
    recorder = Recorder(path, stage.agent, header, truths[0], attachments, further)
    recorder.start()
    try:
        yield
    finally:
        recorder.close()


def plain_request(request: RunSettings) -> dict[str, Any]:
    """A request as JSON values: paths as text but for outputs, which a replay does not write."""
    values = asdict(request)
    for name, value in values.items():
        if isinstance(value, Path):
            values[name] = str(value)
        elif isinstance(value, tuple):
            values[name] = [str(item) for item in value]
    return values
