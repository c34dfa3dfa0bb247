"""State diagrams from a behavior's table: Mermaid text, and a picture by matplotlib."""

from __future__ import annotations

import math
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from ..agent.behavior import Behavior
from ..files.writing import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Edges = dict[tuple[Enum, Enum], list[str]]


def edges(cls: type[Behavior]) -> Edges:
    """(source, target) -> the triggers that lead there, with their conditions, in the order of the table."""
    found: Edges = {}
    for row in cls.transitions:
        label = (
            f"{row.trigger} [{row.when.removeprefix('is_').replace('_', ' ')}]" if row.when else row.trigger
        )
        for source in row.origins:
            found.setdefault((source, row.target), []).append(label)
    return found


def mermaid(cls: type[Behavior]) -> str:
    """The behavior's states and transitions as a Mermaid `stateDiagram-v2`."""
    lines = ["stateDiagram-v2"]
    lines += [f"    {state.name}: {state.name.lower().replace('_', ' ')}" for state in cls.States]
    lines.append(f"    [*] --> {cls.initial.name}")
    for (source, target), triggers in edges(cls).items():
        lines.append(f"    {source.name} --> {target.name}: {' / '.join(triggers)}")
    return "\n".join(lines) + "\n"


def draw(cls: type[Behavior], path: Path) -> None:
    """Draws the diagram to a file; its suffix (.png, .svg, .pdf) says the format. Same class, same bytes."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context({"svg.hashsalt": "tolman"}):
        size = 4.0 + 0.6 * len(cls.States)
        figure = Figure(figsize=(size, size), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set_axis_off()
        axes.set_title(f"{cls.name} (priority {cls.priority})")
        _draw_states(axes, cls)
        metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
        suffix = path.suffix.lower()
        with atomic_file(path, replace=True) as file:
            kind = suffix.removeprefix(".") or None
            figure.savefig(file, format=kind, dpi=100, metadata=metadata.get(suffix, {"Software": None}))


def _places(states: list[Enum]) -> dict[Enum, tuple[float, float]]:
    """The states around a circle, the first on top; one alone in the middle."""
    count = len(states)
    radius = 0.0 if count == 1 else 1.0
    return {
        state: (
            radius * math.sin(math.tau * index / count),
            radius * math.cos(math.tau * index / count),
        )
        for index, state in enumerate(states)
    }


def _draw_states(axes: Axes, cls: type[Behavior]) -> None:
    places = _places(list(cls.States))
    for (source, target), triggers in edges(cls).items():
        _draw_edge(axes, places[source], places[target], "\n".join(triggers))
    for state, (x, y) in places.items():
        initial = state is cls.initial
        axes.text(
            x,
            y,
            state.name.lower().replace("_", "\n"),
            ha="center",
            va="center",
            zorder=3,
            fontweight="bold" if initial else "normal",
            bbox={
                "boxstyle": "round,pad=0.5",
                "facecolor": "#dbe9f6" if initial else "white",
                "edgecolor": "black",
            },
        )
    axes.set_xlim(-1.5, 1.5)
    axes.set_ylim(-1.4, 1.5)


def _draw_edge(axes: Axes, start: tuple[float, float], end: tuple[float, float], label: str) -> None:
    arrow = {"arrowstyle": "-|>", "color": "0.3", "shrinkA": 24, "shrinkB": 24}
    if start == end:
        x, y = start[0] * 1.25, start[1] * 1.25 + (0.35 if start == (0.0, 0.0) else 0.0)
        axes.text(x, y, f"↻ {label}", ha="center", va="center", fontsize=8, color="0.2")
        return
    bend = 0.25
    axes.annotate("", end, start, arrowprops=arrow | {"connectionstyle": f"arc3,rad={bend}"})
    # The middle of the arc: half the bend to the side of the chord, a little beyond for the text.
    x = 0.5 * (start[0] + end[0]) + 0.6 * bend * (end[1] - start[1])
    y = 0.5 * (start[1] + end[1]) - 0.6 * bend * (end[0] - start[0])
    box = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    axes.text(x, y, label, ha="center", va="center", fontsize=8, color="0.2", bbox=box, zorder=2)
