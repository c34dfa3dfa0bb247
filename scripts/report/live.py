"""Shows a run while it happens: watches it as a tick listener, and serves the page and what is new.

The run is the same to the bit with and without. What costs time (packing) is done a few times a second, in a
thread of its own.
"""

from __future__ import annotations

import base64
import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...agent.codec import dumps
from ...agent.events import ArcAdded, BehaviorFinished, Event, LocalMapBuilt, LoopClosed, NodeCommitted
from ...agent.listener import Listener
from ...agent.recording.reader import RecordedTick
from ...plugins.description import described
from ...world.robot import CONTROL_PERIOD, Pose
from ..session.recording import outlines
from .map_content import map_content
from .packing import pack
from .page import make_live_page
from .robots import GEOMETRIES, robot_content
from .server import Feed, PageServer
from .ticks import Gatherer

if TYPE_CHECKING:
    from ...agent import Context
    from ...agent.arbitration.mediator import Candidate
    from ...world.robot import Percept
    from ..session.stage import Stage

Watch = Callable[["Stage"], None]
INTERVAL = 0.25
"""Wall-clock seconds between two parts that are sent."""
TICKS_A_SECOND = 32
"""Ticks sent in a wall-clock second, at most, beside those in which something happens."""
_GROWS = (NodeCommitted, ArcAdded, LocalMapBuilt, LoopClosed)


@contextlib.contextmanager
def live_page(port: int | None, tell: Callable[[str], None]) -> Iterator[Watch | None]:
    """Serves a page of the run that is given to the function it yields; None for port None.

    port: 0 takes any that is free. tell: is told the address. Raises: UsageError for a port that is taken.
    """
    if port is None:
        yield None
        return
    feed = Feed()
    with PageServer(make_live_page("a run under way"), port, feed) as server:
        tell(server.address)
        sender = Sender(feed)
        taps: list[Tap] = []

        def watch(stage: Stage) -> None:
            taps.append(Tap(stage, sender))
            taps[-1].start()

        try:
            yield watch
        finally:
            for tap in taps:
                tap.stop()
            sender.close()
            feed.end()
            feed.drained(2.0)


class Tap(Listener):
    """Watches the first robot of a session and hands ticks on when they are over."""

    def __init__(self, stage: Stage, sender: Sender) -> None:
        """To be started before anything runs."""
        super().__init__(stage.agent)
        self._stage, self._agent, self._sender = stage, stage.agent, sender
        self._percept: Percept | None = None
        self._pose = Pose()
        self._begun = False
        self._next = 0.0
        self._events: list[Event] = []
        self._states: dict[str, str] = {}
        self._belief: dict[int, float] = {}
        self._grown = False
        self._sent: dict[int, bool] = {}
        self.listen(Event, self._hear)

    def update(self, percept: Percept, context: Context) -> None:
        """Hands the tick before on, if anything happened in it or it is time for one, and begins this one."""
        if not self._begun:
            self._begun = True
            self._sender.begin(self._begin())
        elif self._events or time.perf_counter() >= self._next:
            self._complete()
        self._percept, self._pose = percept, context.pose

    def stop(self, reason: str = "cancelled") -> None:
        """Hands the last tick on."""
        self._complete()
        super().stop(reason)
        self.close()

    def _complete(self) -> None:
        """The tick is over: its truth is told of a moment (32 ms) after."""
        percept, self._percept = self._percept, None
        if percept is None:
            return
        self._next = time.perf_counter() + 1.0 / TICKS_A_SECOND
        agent = self._agent
        tick = RecordedTick(percept, truth=self._stage.world.true_pose(), pose=self._pose)
        tick.command, tick.driver = agent.command, agent.driver
        states, belief = agent.states(), agent.belief()
        if states != self._states:
            tick.states = self._states = states
        if belief != self._belief:
            tick.belief = self._belief = belief
        events, self._events = self._events, []
        self._sender.tick(tick, agent.proposals, events)
        if self._grown:
            self._grown = False
            self._sender.map(self._map())

    def _hear(self, event: Event) -> None:
        self._grown = self._grown or isinstance(event, _GROWS)
        # A result may be thousands of samples, and is not shown.
        self._events.append(replace(event, result=None) if isinstance(event, BehaviorFinished) else event)

    def _begin(self) -> dict[str, Any]:
        stage, agent = self._stage, self._agent
        settings = stage.settings
        facts = {"seed": settings.seed, "noise": settings.noise, "profile": settings.profile}
        return {
            "about": {
                "title": stage.world.spec.name,
                "kind": "live",
                "facts": facts,
                "placed": "true",
                "period": CONTROL_PERIOD,
                "grown": True,
                "live": True,
            },
            "walls": outlines(stage.world.spec),
            "robot": robot_content(agent.robot.geometry),
            "behaviors": [described(behavior) for behavior in agent.behaviors.values()],
            "map": self._map(),
        }

    def _map(self) -> dict[str, Any]:
        """All arcs, and the nodes that are new or have a local map since they were sent."""
        hybrid = self._stage.hybrid
        if hybrid is None:
            return {"nodes": [], "arcs": []}
        poses = {**self._stage.places, **self._stage.observers[0].nodes}
        mapped = {node: hybrid.graph.nodes[node]["local_map"] is not None for node in hybrid.graph}
        new = {node for node, whole in mapped.items() if self._sent.get(node) != whole}
        self._sent = mapped
        return map_content(hybrid, poses, new)


class Sender:
    """Takes what a tap hands on, packs it in a thread of its own and tells it to the viewers."""

    def __init__(self, feed: Feed) -> None:
        """Begins at once."""
        self._feed = feed
        self._waiting: list[tuple[str, Any]] = []
        self._over = threading.Event()
        self._gatherer: Gatherer | None = None
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def begin(self, content: Mapping[str, Any]) -> None:
        """What is known before the first tick."""
        self._waiting.append(("begin", content))

    def tick(self, tick: RecordedTick, proposals: Any, events: list[Event]) -> None:
        """One tick that is over; `proposals` and `events` are put into words later."""
        self._waiting.append(("tick", (tick, proposals, events)))

    def map(self, content: Mapping[str, Any]) -> None:
        """What the map has got."""
        self._waiting.append(("map", content))

    def close(self) -> None:
        """Sends what is left."""
        self._over.set()
        self._thread.join()

    def _work(self) -> None:
        while not self._over.wait(INTERVAL):
            self._send()
        self._send()

    def _send(self) -> None:
        waiting, self._waiting = self._waiting, []
        for kind, content in waiting:
            if kind == "tick":
                self._gather(*content)
                continue
            self._flush()
            if kind == "begin":
                self._gatherer = Gatherer(GEOMETRIES[content["robot"]["name"]])
            self._tell(kind, content)
        self._flush()

    def _gather(self, tick: RecordedTick, proposals: list[Candidate], events: list[Event]) -> None:
        assert self._gatherer is not None
        tick.proposals = [
            [each.name, each.priority, 0.0, 0.0, each.proposal.activation, each.proposal.reason]
            for each in proposals
        ]
        tick.events = [dumps(event) for event in events]
        self._gatherer.add(tick)

    def _flush(self) -> None:
        if self._gatherer is not None and self._gatherer.waiting:
            self._tell("ticks", self._gatherer.take())

    def _tell(self, kind: str, content: Mapping[str, Any]) -> None:
        self._feed.tell(kind, base64.b64encode(pack(content)).decode())
