"""Curves in a viser server's panel, with a cursor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.colors import LINES
from warpmuscle.view.curves import Panel
from warpmuscle.view.packing import whole

POINTS = 250  # of a curve at most
FIRST = (("angles", "Knee"), ("ground forces", "vertical"), ("activations", ""), ("torques", "Knee"))
SCALES = {"x": {"time": False}}
AXES = ({"size": 26, "font": "11px sans-serif"}, {"size": 46, "font": "11px sans-serif"})
CURSOR = {"stroke": "#24313d", "width": 1, "label": "", "points": {"show": False}}


class Plots:
    """A few plots, each of a panel that its menu chooses."""

    def __init__(self, gui: Any, panels: Sequence[Panel], time_of: Floats) -> None:
        """Make the plots of panels over times (F,), s."""
        self._panels, self._time = list(panels), np.asarray(time_of, dtype=np.float64)
        self.cursor = 0.0  # s
        self.menus: list[Any] = []
        self.handles: list[Any] = []
        self._groups: list[Any] = []
        names = [_name(panel) for panel in panels]
        for number, first in enumerate(_first(panels)):
            menu = gui.add_dropdown(f"plot {number + 1}", names, initial_value=names[first])
            menu.on_update(self._on_choice(number))
            self.menus.append(menu)
            self.handles.append(
                gui.add_uplot(
                    self._data(panels[first], 0.0),
                    _series(panels[first]),
                    height=130,
                    legend={"show": False},
                    scales=SCALES,
                    axes=AXES,
                )
            )

    def _on_choice(self, number: int) -> Any:
        def chosen(_: Any) -> None:
            panel = self._panel(number)
            handle = self.handles[number]
            handle.data, handle.series = self._data(panel, self.cursor), _series(panel)

        return chosen

    def _panel(self, number: int) -> Panel:
        return next(panel for panel in self._panels if _name(panel) == self.menus[number].value)

    def replace(self, panels: Sequence[Panel], time_of: Floats) -> None:
        """Plot other curves of the same names."""
        self._panels, self._time = list(panels), np.asarray(time_of, dtype=np.float64)

    def show(self, cursor: float) -> None:
        """Move the cursor to a time, s."""
        self.cursor = cursor
        for number, handle in enumerate(self.handles):
            handle.data = self._data(self._panel(number), cursor)

    def _data(self, panel: Panel, cursor: float) -> tuple[Floats, ...]:
        """Times, curves, and a line that runs along the bottom but for a spike at the cursor: three points there."""
        every = max(1, len(self._time) // POINTS)
        times = self._time[::every]
        place = int(np.searchsorted(times, cursor))
        curves = [np.asarray(line.values[::every], dtype=np.float64) for line in panel.lines]
        low, high = min(float(c.min()) for c in curves), max(float(c.max()) for c in curves)
        with_cursor = [np.insert(c, place, [np.interp(cursor, times, c)] * 3) for c in curves]
        spike = np.insert(np.full(len(times), low), place, [low, high, low])
        return (np.insert(times, place, [cursor] * 3), *with_cursor, spike)


def _series(panel: Panel) -> tuple[dict[str, Any], ...]:
    lines = [{"label": whole(line.name), "stroke": LINES[line.side], "width": 1.5} for line in panel.lines]
    return ({"label": "time, s"}, *lines, CURSOR)


def _name(panel: Panel) -> str:
    return whole(f"{panel.group}: {panel.title}" + (f", {panel.unit}" if panel.unit else ""))


def _first(panels: Sequence[Panel]) -> list[int]:
    """Panels that are shown at first: one of a kind, where there is one."""
    chosen = []
    for group, title in FIRST:
        own = [number for number, panel in enumerate(panels) if panel.group == group]
        if own:
            chosen.append(next((number for number in own if panels[number].title == title), own[0]))
    return chosen
