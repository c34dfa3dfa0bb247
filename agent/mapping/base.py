"""What all mappers share: making nodes, arcs and local maps, handing them over, and when to end.

A mapper drives nothing itself. It starts behaviors, listens to their reports and grows a hybrid map. How it
tells where a node is, and that it is back at one, is the method's own: see `corners` and `published`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from ..codec import reinstate, snapshot
from ..events import ArcAdded, CornerReached, LocalMapBuilt, NodeCommitted, NodeCreated
from ..goals import LocalSamples
from ..listener import Listener, TickListener

if TYPE_CHECKING:
    from ...maps.hybrid_map import HybridMap
    from ...maps.local.local_map import LocalMap
    from ..agent import Agent

ArcKey = tuple[int, int, str]
"""start, end, kind of an arc."""
_STRATEGIES = {"rows": ("rows", "rows"), "columns": ("columns", "columns"), "alternate": ("rows", "columns")}


class MapSink(Protocol):
    """Where a mapper hands over what it makes: whoever trains local maps and keeps the map."""

    def build(self, samples: LocalSamples, entry_heading: float) -> LocalMap:
        """Trains the local map of the mapper's current node. entry_heading: rad, map frame."""

    def commit(self, node: int, corner: CornerReached) -> None:
        """Takes a node that is complete, while the robot stands at it or on its way from there.

        corner: where it was met first; `NodeCreated` and `LoopClosed` name it by its number.
        """

    def rest(self, nodes: Sequence[int], arcs: Sequence[ArcKey]) -> None:
        """Takes what changed without a new node, while the robot stands at a known one.

        nodes, arcs: those that were taken back.
        """


class AnyMapper(TickListener, Protocol):
    """What a run needs of a mapper, whichever the profile names."""

    @property
    def reason(self) -> str:
        """Why it ended; empty before."""

    @property
    def done(self) -> bool:
        """Whether mapping has ended."""

    @property
    def current(self) -> int:
        """The node the robot is at, or met last; -1 if there is none."""


@dataclass(frozen=True, slots=True)
class NodeSettings:
    """What every mapper can be told.

    side: of the wall. local_maps: whether to explore around nodes. strategy: "rows", "columns" or
    "alternate". max_nodes: end after so many, None for no limit.
    """

    side: str = "right"
    local_maps: bool = True
    strategy: str = "alternate"
    max_nodes: int | None = None


class BaseMapper(Listener):
    """Makes nodes, arcs and local maps. A method decides when, and what comes next: `_go_on`.

    current: the node made or met last, -1 if there is none. `start` after `restore` goes on from there.
    """

    behaviors: ClassVar[tuple[str, ...]] = ()
    """What it drives by; the first follows the wall."""
    kept: ClassVar[tuple[str, ...]] = ("current", "_met")
    """The attributes that its `state` keeps."""

    def __init__(self, agent: Agent, hybrid_map: HybridMap, sink: MapSink, config: NodeSettings) -> None:
        """Nothing is mapped yet."""
        super().__init__(agent)
        self.agent, self.map, self.sink = agent, hybrid_map, sink
        self.current = -1
        self._settings = config
        self._met: CornerReached | None = None

    def stop(self, reason: str = "cancelled") -> None:
        """Ends it where it is: no corner becomes a node any more."""
        if not self.done:
            self._end(False, reason)
            for name in self.behaviors[1:]:
                if name in self.agent.behaviors:
                    self.agent.stop(name)

    def state(self) -> dict[str, Any]:
        """What a resumed mapping needs to go on exactly; to be taken while a node is committed."""
        return {**snapshot(self, self.kept), "heard": self.agent.bus.corners}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Goes back to a `state`."""
        reinstate(self, self.kept, state)
        self.agent.bus.corners = int(state["heard"])

    # --- steps ---------------------------------------------------------------------------------------

    def _create(self, met: CornerReached, *, corner: str, entry_heading: float, turn: float = 0.0) -> int:
        """Adds the node of a corner that was met; the node before it, -1 if there is none.

        corner: its kind as the map has it. entry_heading: rad, map frame. turn: rad, of the boundary there.
        """
        previous = self.current
        self.current = self.map.add_node(corner=corner, turn=turn, entry_heading=entry_heading)
        self._met = met
        time = self.agent.context.time
        self.agent.bus.publish(NodeCreated(time=time, node=self.current, corner=met.kind, met=met.number))
        return previous

    def _join(self, source: int, target: int, distance: float, variance: float = 0.0) -> None:
        """Adds the arcs between two nodes. distance: m. variance: of it, m^2."""
        side, time = self._settings.side, self.agent.context.time
        self.map.add_arc(source, target, side=side, distance=distance, variance=variance)
        self.agent.bus.publish(
            ArcAdded(time=time, source=source, target=target, side=side, distance=distance)
        )

    @property
    def _strategy(self) -> str:
        """How the space around the current node is explored."""
        return _STRATEGIES[self._settings.strategy][self.current % 2]

    def _keep_samples(self, samples: Any) -> None:
        """Has the current node's local map trained, if exploration brought anything home."""
        if not isinstance(samples, LocalSamples) or len(samples.positions) == 0:
            return
        data = self.map.graph.nodes[self.current]
        data["local_map"] = self.sink.build(samples, data["entry_heading"])
        self.agent.bus.publish(
            LocalMapBuilt(
                time=self.agent.context.time,
                node=self.current,
                positions=len(samples.positions),
                panoramas=len(samples.panoramas),
            )
        )

    def _commit(self) -> None:
        """The current node is complete: hands it over and goes on, unless it was the last."""
        self._hand_over()
        limit = self._settings.max_nodes
        if limit is not None and self._count() >= limit:
            self._end(True, "max nodes")
        else:
            self._go_on()

    def _hand_over(self) -> None:
        assert self._met is not None
        self.sink.commit(self.current, self._met)
        self.agent.bus.publish(NodeCommitted(time=self.agent.context.time, node=self.current))

    def _count(self) -> int:
        """How many nodes count for the limit."""
        return len(self.map.nodes())

    def _go_on(self) -> None:
        """Drives on from the current node."""
        raise NotImplementedError

    def _end(self, succeeded: bool, reason: str) -> None:
        self.agent.stop(self.behaviors[0])
        self.finish(succeeded, self.current, reason)
