"""What every run stands on: a world, the agents of its robots, their truth, and the one loop.

`Simulation` (in `simulation`) adds what one wants of it; a replay uses it as it is.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Mapping
from importlib.metadata import version
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeVar

from ...agent import Agent, Behavior
from ...files.interrupts import Deferred
from ...maps.meta import MapMeta
from ...plugins.discovery import Catalog, load_mediator
from ...plugins.isolation.proxy import close_all
from ...world.geometry import Plan
from ...world.robot import STOP, Pose
from .assembly import find_plugins, make_agent
from .profiles import Profile, find_profile
from .requests import Progress, RunSettings, SessionError
from .settings import configured, mediator_of
from .truth import Observer

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...world import World
    from .requests import MapRequest

START_WITHIN, STAY_WITHIN = 0.25, 1.0
"""Meters outside of the rectangle around all walls at which a run may begin, and up to which it goes on."""
_LOOK = 1.0
"""Simulated seconds between two looks at where the robots are, and between two reports of progress."""

R = TypeVar("R", bound=RunSettings)


class Stage:
    """A world with the agents of its robots. Use it as a context manager: at its end all wheels stand still.

    settings: what the run is made with; options: the file of settings, read; profile: the method. agents,
    observers: of the robots that drive, in the world's order; the first is there from the start, `robot`
    adds others. begun: whether anything has run yet. trouble: why `run` gave up by itself, such as a robot
    that left all walls. hybrid, places: for those who look on, the map that the last job makes or drives by,
    and the true poses of its nodes as far as the job was told.
    """

    def __init__(
        self,
        world: World,
        settings: RunSettings,
        options: Mapping[str, Any],
        *,
        profile: Profile | None = None,
        behaviors: Iterable[Behavior] = (),
        progress: Callable[[Progress], None] = lambda progress: None,
    ) -> None:
        """Takes an open world over. behaviors: of the first robot, besides those that are found.

        Raises: PluginError, ConfigError, SessionError; the world is closed then.
        """
        self.world, self.settings, self.options = world, settings, dict(options)
        self.agents: list[Agent] = []
        self.observers: list[Observer] = []
        self.begun = False
        self.trouble = ""
        self.hybrid: HybridMap | None = None
        self.places: Mapping[int, Pose] = {}
        self._progress = progress
        self._looked = -math.inf
        self._catalog: Catalog | None = None
        try:
            self.profile = configured(profile or find_profile(settings.profile), self.options)
            self._bounds = _bounds(world)
            self._add_robot(behaviors)
        except BaseException:
            world.close()
            raise

    def __repr__(self) -> str:
        """World, method, seed, and how far it is."""
        name, of = type(self).__name__, self.settings
        spec = self.world.spec.name
        return f"{name}({spec!r}, seed={of.seed}, profile={self.profile.name!r}, time={self.time:.3f} s)"

    def __enter__(self) -> Self:
        """The session itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Closes it, whatever ended the block."""
        self.close()

    @property
    def agent(self) -> Agent:
        """The first robot's."""
        return self.agents[0]

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return self.world.time

    def robot(self, index: int) -> Agent:
        """The agent of one of the world's robots; those before it get theirs too. Raises: LookupError."""
        if not 0 <= index < len(self.world.robots):
            raise LookupError(f"there is no robot {index}; the world has {len(self.world.robots)}")
        while len(self.agents) <= index:
            self._add_robot(())
        return self.agents[index]

    def _add_robot(self, behaviors: Iterable[Behavior]) -> None:
        index = len(self.agents)
        name, values = mediator_of(self.options)
        configs, robot = self.options.get("behaviors"), self.world.robots[index]
        if self._catalog is None:
            self._catalog = find_plugins(self.settings, self.profile, configs)
        mediator = load_mediator(name, self._catalog, values)
        agent = make_agent(
            self.settings, self.profile, configs, self._catalog, mediator, robot, index, behaviors
        )
        self.agents.append(agent)
        self.observers.append(Observer(self.world, agent, index))
        pose = self.world.true_pose(index)
        if self._outside(index, START_WITHIN):
            raise SessionError(
                f"{self.world.spec.name}: a start at ({pose.x:g}, {pose.y:g}) is outside of all walls, "
                f"which are {self._walls()}; start inside"
            )

    def request(self, kind: type[R], **values: Any) -> R:
        """A request with the settings of this session."""
        names = RunSettings.__dataclass_fields__
        return kind(**{name: getattr(self.settings, name) for name in names}, **values)

    # --- the loop ----------------------------------------------------------------------------------------

    def step(self) -> None:
        """One control tick (32 ms): every agent senses, decides and commands, and the world goes on."""
        self._tick()
        self._advance()

    def run(
        self,
        over: Callable[[], bool],
        *,
        limit: float = math.inf,
        stand: bool = False,
        doing: Callable[[], tuple[int | None, str]] | None = None,
    ) -> bool:
        """Steps until `over()`. Returns False if the simulated time `limit` (s) or `trouble` came first.

        An interrupt by the user ends it between two ticks (`UserInterrupt`).

        over: asked after each step of the world.
        stand: asks before the step instead, so that the robot stays where it was when it was over.
        doing: how many nodes are known and what is done, for a report of progress each second.
        """
        with Deferred() as interrupts:
            while self.time < limit:
                interrupts.check()
                self._tick()
                if stand and over():
                    return True
                self._advance()
                if not stand and over():
                    return True
                if self.time - self._looked >= _LOOK and self._look(doing):
                    return False
        return False

    def _look(self, doing: Callable[[], tuple[int | None, str]] | None) -> bool:
        """Tells how far it is; whether there is trouble."""
        self._looked = self.time
        if doing is not None:
            self.tell(*doing())
        return self._left_walls()

    def _tick(self) -> None:
        self.begun = True
        for agent, observer in zip(self.agents, self.observers, strict=True):
            agent.tick()
            observer.ticked()

    def _advance(self) -> None:
        self.world.step()
        for observer in self.observers:
            observer.stepped()

    def tell(self, nodes: int | None, message: str) -> None:
        """Reports progress."""
        self._progress(Progress(self.time, nodes, message))

    def _left_walls(self) -> bool:
        for index in range(len(self.agents)):
            if self._outside(index, STAY_WITHIN):
                pose = self.world.true_pose(index)
                self.trouble = f"the robot left all walls: it is at ({pose.x:.2f}, {pose.y:.2f})"
        return bool(self.trouble)

    def _outside(self, robot: int, margin: float) -> bool:
        """Whether a robot is farther than that (m) outside of the rectangle around all walls."""
        if self._bounds is None:
            return False
        x0, y0, x1, y1 = self._bounds
        pose = self.world.true_pose(robot)
        inside = x0 - margin <= pose.x <= x1 + margin and y0 - margin <= pose.y <= y1 + margin
        return not inside

    def _walls(self) -> str:
        assert self._bounds is not None
        x0, y0, x1, y1 = self._bounds
        return f"within ({x0:g}, {y0:g}) and ({x1:g}, {y1:g})"

    def halt(self) -> None:
        """Ends all driving: one more tick in which the wheels stop and the last events are heard."""
        self._tick()
        for agent in self.agents:
            agent.close()

    def close(self) -> None:
        """Stops all wheels and behaviors and frees the world, whatever happened. Twice does no harm.

        The wheels rest first, since behaviors may take their time, and last. An interrupt waits for the end.
        """
        with Deferred(patient=True), contextlib.ExitStack() as steps:  # from the last to the first, each done
            steps.callback(self.world.close)
            driven = list(zip(self.world.robots, self.agents, strict=False))
            for robot, agent in driven:
                steps.callback(robot.act, STOP)
                steps.callback(close_all, [*agent.behaviors.values(), agent.mediator, agent.first_mediator])
                steps.callback(agent.close)
            for robot, _ in driven:
                steps.callback(robot.act, STOP)

    def map_meta(self, request: MapRequest) -> MapMeta:
        """What a map made here says about itself."""
        settings, spec = self.settings, self.world.spec
        islands = {"islands": True} if request.islands else {}
        return MapMeta(
            world=spec.name,
            world_digest=spec.digest,
            profile=settings.profile,
            side=request.side,
            seed=settings.seed,
            noise=settings.noise,
            versions={"tolman": version("tolman")},
            geometry=self.world.robots[0].geometry.name,
            scalars={"noise_scale": settings.noise_scale, "robot_model": settings.model, **islands},
        )


def _bounds(world: World) -> tuple[float, float, float, float] | None:
    """The rectangle (m) around all walls: x0, y0, x1, y1; None where there are none."""
    shapes = world.spec.shapes if world.spec is not None else ()
    return Plan(shapes).bounds if shapes else None
