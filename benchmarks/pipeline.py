"""The whole of tolman at work in a made-up world, a tick at a time, and what each part of it costs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tolman.agent import Agent
from tolman.maps.hybrid_map import HybridMap
from tolman.scripts.session.assembly import make_mapper
from tolman.scripts.session.requests import MapRequest
from tolman.scripts.session.stage import Stage
from tolman.world import Pose, WorldSpec, open_world
from tolman.world.spec import Box, Start, room_walls

PITCH = 0.45
"""Meters between the blocks of a made-up world."""


def boxes_world(count: int, robots: int = 1) -> WorldSpec:
    """A square room of four walls and `count` - 4 blocks in rows, robots along its lower wall."""
    blocks = count - 4
    columns = max(1, math.ceil(math.sqrt(blocks)), math.ceil(0.3 * robots / PITCH))
    side = (columns + 1) * PITCH
    shapes = list(room_walls(side, side))
    for number in range(blocks):
        row, column = divmod(number, columns)
        shapes.append(Box((column + 1) * PITCH, (row + 1) * PITCH, 0.1, 0.1))
    starts = [Pose(0.1 + 0.25 * number, 0.057, 0.0) for number in range(robots)]
    return WorldSpec(
        f"boxes-{count}", tuple(shapes), starts=(Start("right", starts[0]),), robots=tuple(starts[1:])
    )


@dataclass
class Pipeline:
    """Robots that map a world by its walls, without local maps; `step` is one tick of everything."""

    spec: WorldSpec
    model: str = "wheels"
    agents: list[Agent] = field(default_factory=list)
    mappers: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Starts the run."""
        self.begin()

    def begin(self) -> None:
        """Begins from the start."""
        request = MapRequest(world=self.spec.name, global_only=True, model=self.model)
        self.world: Any = open_world(self.spec, model=self.model, noise="thesis", seed=1)
        stage = Stage(self.world, request, {})
        self.agents = [stage.robot(robot) for robot in range(len(self.world.robots))]
        self.mappers = [
            make_mapper(stage.profile, request, agent, HybridMap(), _Nowhere()) for agent in self.agents
        ]
        for mapper in self.mappers:
            mapper.start()

    def step(self) -> None:
        """One control tick: every agent senses, decides and commands, and the world steps."""
        for agent in self.agents:
            agent.tick()
        self.world.step()

    def renew(self) -> None:
        """Begins again where the first robot has its map; called between measurements."""
        if self.mappers[0].done:
            self.begin()


class _Nowhere:
    """Keeps nothing of what is mapped."""

    def build(self, samples: Any, entry_heading: float) -> Any:
        """Not asked for."""
        raise AssertionError("no local maps here")

    def commit(self, node: int, corner: Any) -> None:
        """Keeps nothing."""

    def rest(self, nodes: Any, arcs: Any) -> None:
        """Keeps nothing."""


class Parts:
    """Splits a pipeline's ticks among its parts, by timing the calls that lead into each."""

    NAMES = ("physics", "infrared", "sensing besides", "behaviors", "mediator", "mapping", "agent besides")

    def __init__(self, pipeline: Pipeline) -> None:
        """Puts clocks into this pipeline's own objects; others are not touched."""
        self.spent = dict.fromkeys(("step", "tick", *self.NAMES), 0.0)
        world = pipeline.world
        self._clock(world, "_advance", "physics")
        for robot in world.robots:
            self._clock(robot.sensors["infrared"], "values", "infrared")
        self._clock(world, "step", "step")
        for agent in pipeline.agents:
            self._clock(agent, "tick", "tick")
            self._clock(agent, "_collect", "behaviors")
            self._clock(agent.mediator, "arbitrate", "mediator")
            self._clock(agent.bus, "deliver", "mapping")

    def _clock(self, owner: Any, method: str, name: str) -> None:
        call: Callable[..., Any] = getattr(owner, method)
        spent, now = self.spent, time.process_time

        def clocked(*args: Any) -> Any:
            began = now()
            try:
                return call(*args)
            finally:
                spent[name] += now() - began

        setattr(owner, method, clocked)

    def shares(self) -> dict[str, float]:
        """Seconds by part."""
        spent = dict(self.spent)
        step, tick = spent.pop("step"), spent.pop("tick")
        spent["sensing besides"] = step - spent["physics"] - spent["infrared"]
        spent["agent besides"] = tick - spent["behaviors"] - spent["mediator"] - spent["mapping"]
        return spent
