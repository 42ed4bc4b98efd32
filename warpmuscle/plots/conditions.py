"""Measures over conditions: every run as a point, the median of each condition, and the band that most lie in.

Beside them stands what was expected of a change: its value, or whether it rises, falls or stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.plots.style import GRAY, PALETTE, grid, legible

COLUMNS, MOST_TICKS = 3, 6
MOST_SLANTED = 7  # words side by side under a panel; more of them stand upright
ROW = 0.22  # in, of a row of text above all panels
LEAST_HEIGHT = 0.01  # of half a panel, in parts of what it shows
RISES, FALLS = "^", "v"
_SHIFT = 0.12  # of a condition that is a word, between series
_ASIDE = 0.2  # of a bar beside a condition that is a word


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
    signs: tuple[tuple[int, float, str], ...] = ()  # place of a condition, median of the reference, RISES or FALLS
    stays: tuple[tuple[int, float, float], ...] = ()  # place, median of the reference, change that is none

    @property
    def is_expected(self) -> bool:
        """Whether anything was expected of it."""
        return bool(self.expected or self.signs or self.stays)


@dataclass(frozen=True)
class Panel:
    """A measure."""

    title: str
    unit: str
    lines: tuple[Lines, ...]


def draw_conditions(
    axis: str, conditions: Sequence[float | str], panels: Sequence[Panel], walked: Sequence[str] = ()
) -> Any:
    """The figure, a panel a measure, titles in bold where something was expected, and a key above.

    Args:
        axis: what the conditions are. conditions: numbers, or words that are put side by side.
        walked: of each condition, how many runs are in it, in words; stands behind its name.
    """
    figure, places = grid(len(panels), COLUMNS, 2.3)
    numbers = [condition for condition in conditions if isinstance(condition, float | int)]
    words = len(numbers) < len(conditions)
    x = np.arange(len(conditions), dtype=float) if words else np.array(numbers, dtype=float)
    for axes, panel in zip(places, panels, strict=True):
        for number, lines in enumerate(panel.lines):
            _line(axes, x + (number * _SHIFT if words else 0.0), lines, PALETTE[number % len(PALETTE)], words)
        axes.set_title(legible(panel.title), weight="bold" if any(one.is_expected for one in panel.lines) else "normal")
        axes.set_ylabel(panel.unit)
        _widen(axes)
        if words:
            texts, many = [legible(str(word)) for word in conditions], len(conditions) > MOST_SLANTED
            axes.set_xticks(x, texts, rotation=90 if many else 30, ha="center" if many else "right", fontsize=7)
        else:
            axes.set_xlabel(legible(axis))
            if len(x) <= MOST_TICKS:
                axes.set_xticks(x, [f"{value:g}" for value in x])
    _key(figure, places, panels, words, _counts(conditions, walked))
    return figure


def _widen(axes: Any) -> None:
    """Show values that are equal but for rounding as a level row, and no digits behind a common offset."""
    low, high = axes.get_ylim()
    middle = 0.5 * (low + high)
    half = max(0.5 * (high - low), LEAST_HEIGHT * abs(middle))
    axes.set_ylim(middle - half, middle + half)
    axes.ticklabel_format(axis="y", useOffset=False)


def _counts(conditions: Sequence[float | str], walked: Sequence[str]) -> str:
    """How many runs stand behind each condition, once for those that have as many."""
    if not walked:
        return ""
    if len(set(walked)) == 1:
        return f"each condition: {walked[0]}"
    named = [c if isinstance(c, str) else f"{c:g}" for c in conditions]
    return "; ".join(f"{name}: {count}" for name, count in zip(named, walked, strict=True))


def _key(figure: Any, places: Sequence[Any], panels: Sequence[Panel], words: bool, counts: str) -> None:
    """What points, lines and marks are, above all panels, and which colour each series has."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def mark(kind: str, label: str, line: str = "none", **more: Any) -> Any:
        return Line2D([], [], color=PALETTE[0], marker=kind, ls=line, label=label, **more)

    band = "5 to 95 % of the runs"
    found = [mark(".", "one run", alpha=0.45, mew=0), mark("o", "median", "none" if words else "-", ms=4)]
    found.append(mark("|", band, ms=10) if words else Patch(color=PALETTE[0], alpha=0.15, lw=0, label=band))
    lines = [one for panel in panels for one in panel.lines]
    hollow: dict[str, Any] = {"mfc": "none", "mec": GRAY, "ms": 6}
    signs = {sign for one in lines for _, _, sign in one.signs}
    marks = [
        ("D", "expected value", any(one.expected for one in lines)), (RISES, "expected: rises", RISES in signs),
        (FALLS, "expected: falls", FALLS in signs),
    ]  # fmt: skip
    found += [mark(kind, label, **hollow) for kind, label, drawn in marks if drawn]
    if any(one.stays for one in lines):
        found.append(Line2D([], [], color=GRAY, marker="_", ms=6, lw=1, label="expected: stays within"))
    handles, labels = places[0].get_legend_handles_labels()
    rows, height = 1 + bool(counts) + bool(labels), figure.get_figheight()
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - (ROW * rows + 0.03) / height))
    if counts:
        figure.text(0.008, 1.0 - (ROW * (rows - 1) + 0.04) / height, legible(counts), color=GRAY, size=8.0, va="top")
    if labels:
        place = (1.0, 1.0 - ROW / height)
        figure.legend(
            handles, [legible(text) for text in labels], loc="upper right", ncols=len(labels), bbox_to_anchor=place,
            borderaxespad=0.1,
        ).set_in_layout(False)  # fmt: skip
    figure.legend(
        handles=found, loc="upper left", ncols=len(found), borderaxespad=0.1, handletextpad=0.3, columnspacing=1.2
    ).set_in_layout(False)


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
    edge = color if lines.label else GRAY  # of several series, each has its own marks
    for place, value in lines.expected:
        axes.plot(x[place], value, "D", mfc="none", mec=edge, ms=6)
    aside = _ASIDE if words else 0.02 * float(np.ptp(x))
    for place, value, sign in lines.signs:
        axes.plot(x[place] + aside, value, sign, mfc="none", mec=edge, ms=6)
    for place, value, within in lines.stays:
        axes.errorbar(x[place] + aside, value, within, color=edge, lw=1, capsize=3)
