"""Where the candidates of a search lie between the bounds of each parameter."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.style import GRAY, PALETTE, heading, legible, page
from warpmuscle.plots.subject import Absent, Subject
from warpmuscle.results.records import ParameterTable

_BEST_PART = 0.1  # of the candidates
_ROW = 0.165  # inches
_LONG = 46  # rows from which on there are two columns


def draw(subject: Subject) -> Any:
    """All candidates, the best tenth of them, the start and the best, of each parameter between its bounds."""
    result = subject.result
    if result.evaluations is None or result.best is None or not result.parameters.name:
        raise Absent(f"{subject.source} holds no search; `warpmuscle optimize` writes files that do")
    if result.is_brief:
        raise Absent(f"{subject.source} holds only the best of its candidates")
    mine = result.evaluations.rows(result.evaluations.stage == result.evaluations.stage[result.best.index])
    unit = unit_values(result.parameters, mine.params)
    best_tenth = unit[np.argsort(mine.cost, kind="stable")[: max(1, round(_BEST_PART * len(unit)))]]
    marks = unit_values(result.parameters, np.stack([result.parameters.value, np.asarray(result.best.params)]))
    count = len(result.parameters.name)
    columns = 2 if count > _LONG else 1
    rows = -(-count // columns)
    figure = page(_ROW * rows + 1.35, width=9.0 if columns == 1 else 13.0)
    for column, axes in enumerate(np.ravel(figure.subplots(1, columns, squeeze=False))):
        shown = np.arange(column * rows, min((column + 1) * rows, count))
        _rows(axes, result.parameters, shown, unit, best_tenth, marks)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    note = f"{number_of(len(mine), 'candidate')}, each parameter from its lower to its upper bound"
    heading(figure, f"{subject.scene.name}: parameters", note)
    return figure


def unit_values(table: ParameterTable, params: Floats) -> Floats:
    """Values (N, P) as parts of their intervals, 0 at the lower and 1 at the upper bound, on each parameter's scale."""
    log = np.array([scale == "log" for scale in table.scale])
    tiny = np.finfo(float).tiny
    low, high, value = (
        np.where(log, np.log(np.maximum(v, tiny)), v) for v in (table.min, table.max, np.asarray(params, dtype=float))
    )
    return np.asarray((value - low) / np.maximum(high - low, tiny))


def _bound(value: float) -> str:
    return f"{value:.4g}" if abs(value) >= 100.0 else f"{value:.3g}"


def _rows(axes: Any, table: ParameterTable, shown: Any, unit: Floats, best_tenth: Floats, marks: Floats) -> None:
    """A row a parameter: its name on the left, its bounds at the ends, its unit on the right."""
    y = np.arange(len(shown))
    for values, width, color, label in (
        (unit, 5.0, "#D0D0D0", "all candidates, 5 to 95 %"),
        (best_tenth, 5.0, PALETTE[5], "best tenth of them, 5 to 95 %"),
    ):
        low, high = np.percentile(values[:, shown], [5.0, 95.0], axis=0)
        axes.hlines(y, low, np.maximum(high, low + 0.003), color=color, lw=width, label=label)
    axes.plot(marks[0, shown], y, "|", color=PALETTE[6], ms=7.0, mew=1.4, label="start")
    axes.plot(marks[1, shown], y, "o", color=PALETTE[1], ms=3.6, label="best")
    for row, k in zip(y, shown, strict=True):
        axes.text(-0.012, row, _bound(table.min[k]), ha="right", va="center", size=6.5, color=GRAY)
        text = f"{_bound(table.max[k])} {table.unit[k]}".rstrip() + (", log" if table.scale[k] == "log" else "")
        axes.text(1.012, row, text, ha="left", va="center", size=6.5, color=GRAY)
    axes.set(xlim=(0.0, 1.0), ylim=(len(shown) - 0.5, -0.5), xticks=[])
    axes.set_yticks(y, [legible(table.name[k]) for k in shown], size=7.0)
    axes.tick_params(axis="y", length=0.0, pad=32.0)
    axes.spines["right"].set_visible(True)
    axes.spines["bottom"].set_visible(False)
