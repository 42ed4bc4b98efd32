"""Measures over conditions: every run as a point, the median of each condition, and the band that most lie in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.plots.style import GRAY, PALETTE, grid, legible, top_legend

COLUMNS, MOST_TICKS = 3, 6
MOST_SLANTED = 7  # words side by side under a panel; more of them stand upright
LEGEND = 0.25  # in, above all panels
_SHIFT = 0.12  # of a condition that is a word, between series


@dataclass(frozen=True)
class Lines:
    """A series of a panel: conditions (C,), the median and band of each, and every run."""

    label: str
    median: Floats
    low: Floats
    high: Floats
    run_condition: tuple[int, ...]  # of each run, its place among the conditions
    run_value: Floats  # (R,)
    expected: tuple[tuple[int, float], ...] = ()  # place of a condition, and what was expected there


@dataclass(frozen=True)
class Panel:
    """A measure."""

    title: str
    unit: str
    lines: tuple[Lines, ...]


def draw_conditions(axis: str, conditions: Sequence[float | str], panels: Sequence[Panel]) -> Any:
    """The figure, a panel a measure.

    Args:
        axis: what the conditions are. conditions: numbers, or words that are put side by side.
    """
    figure, places = grid(len(panels), COLUMNS, 2.3)
    numbers = [condition for condition in conditions if isinstance(condition, float | int)]
    words = len(numbers) < len(conditions)
    x = np.arange(len(conditions), dtype=float) if words else np.array(numbers, dtype=float)
    for axes, panel in zip(places, panels, strict=True):
        for number, lines in enumerate(panel.lines):
            _line(axes, x + (number * _SHIFT if words else 0.0), lines, PALETTE[number % len(PALETTE)], words)
        axes.set(title=legible(panel.title), ylabel=panel.unit)
        if words:
            texts, many = [legible(str(word)) for word in conditions], len(conditions) > MOST_SLANTED
            axes.set_xticks(x, texts, rotation=90 if many else 30, ha="center" if many else "right", fontsize=7)
        else:
            axes.set_xlabel(legible(axis))
            if len(x) <= MOST_TICKS:
                axes.set_xticks(x, [f"{value:g}" for value in x])
    handles, labels = places[0].get_legend_handles_labels()
    if any(labels):
        figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - LEGEND / figure.get_figheight()))
        top_legend(figure, handles, [legible(text) for text in labels])
    return figure


def _line(axes: Any, x: Floats, lines: Lines, color: str, words: bool) -> None:
    order = np.arange(len(x)) if words else np.argsort(x)
    known = order[np.isfinite(lines.median[order])]
    where = x[list(lines.run_condition)]
    axes.plot(where, lines.run_value, ".", color=color, alpha=0.45, ms=6, mew=0)
    if words:
        spread = [lines.median[known] - lines.low[known], lines.high[known] - lines.median[known]]
        axes.errorbar(x[known], lines.median[known], spread, fmt="o", color=color, ms=4, lw=1, label=lines.label)
    else:
        axes.fill_between(x[known], lines.low[known], lines.high[known], color=color, alpha=0.15, lw=0)
        axes.plot(x[known], lines.median[known], "o-", color=color, ms=3.5, lw=1.4, label=lines.label)
    for place, value in lines.expected:
        axes.plot(x[place], value, "D", mfc="none", mec=GRAY, ms=6)
