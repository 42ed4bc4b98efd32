"""Predicted and measured adaptations as lines of text, as a table, and as one HTML page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.plain_text import number_of, rounded
from warpmuscle.plots.style import PALETTE, grid, style
from warpmuscle.report.images import data_uri
from warpmuscle.report.page import template
from warpmuscle.results.records import made_by
from warpmuscle.sweep.adaptation.compared import FREQUENCY, KINDS, AngleChange, Change, Score

COLUMNS = 3
MARKS = dict(zip(KINDS, ("o", "^", "v", "s"), strict=True))


@dataclass(frozen=True)
class Comparison:
    """What a benchmark has come to."""

    conditions: int
    runs: int
    changes: Sequence[Change]
    scores: Sequence[Score]
    angles: Sequence[AngleChange]
    left_out: Mapping[str, str]  # runs that give nothing, and why

    @property
    def counted(self) -> str:
        """How many conditions and runs there are, and how many walked."""
        walked = self.runs - len(self.left_out)
        return f"{number_of(self.conditions, 'condition')}, {number_of(self.runs, 'run')}, of which {walked} walked"


def lines(found: Comparison) -> list[tuple[str, ...]]:
    """A row a quantity and kind of condition: what part of the measured changes is predicted, and how far off."""
    head = ("quantity", "changes of", "conditions", "predicted part", "error")
    return [head, *_score_rows(found)]


def _score_rows(found: Comparison) -> list[tuple[str, ...]]:
    return [
        (one.quantity, one.kind, str(one.conditions), _percent(100.0 * one.part), _percent(one.error))
        for one in found.scores
    ]


def _percent(value: float) -> str:
    return f"{rounded(value, 0)} %" if np.isfinite(value) else ""


def change_table(found: Comparison) -> list[tuple[str, ...]]:
    """A row a condition and quantity, in percent of what was measured in the condition that it is compared with."""
    head = ("condition", "study", "kind", "quantity", "measured (%)", "predicted (%)", "5 % (%)", "95 % (%)", "seeds")
    rows = [
        (c.record.name, c.record.study, c.record.kind, c.quantity,
         *map(_digits, (c.measured, c.predicted, c.low, c.high)), str(c.seeds))
        for c in found.changes
    ]  # fmt: skip
    return [head, *rows]


def _digits(value: float) -> str:
    return rounded(value, 2)


def page(found: Comparison, sweep: str, command: str) -> str:
    """The page; raises Error if jinja2 or matplotlib are missing."""
    with style():
        figure = data_uri(_figure(found)) if found.changes else ""
    return str(
        template("adaptation.html").render(
            counted=found.counted,
            best=_best(found),
            scores=_score_rows(found),
            figure=figure,
            changes=[
                (change.record.described, *row)
                for change, row in zip(found.changes, change_table(found)[1:], strict=True)
            ],
            angles=[
                (
                    one.record.described,
                    one.record.name,
                    *(f"{e:.1f} ({m:.1f})" for e, m in zip(one.error, one.measured, strict=True)),
                )
                for one in found.angles
            ],
            left_out=sorted(found.left_out.items()),
            sweep=sweep,
            made=made_by(command),
        )
    )


def _best(found: Comparison) -> list[tuple[str, str, str, str]]:
    """For each kind of condition the formula of metabolic power with the least error, and what it comes to."""
    best = []
    for kind in KINDS:
        mine = [one for one in found.scores if one.kind == kind and one.quantity != FREQUENCY]
        if mine:
            least = min(mine, key=lambda one: one.error)
            part = _percent(100.0 * least.part) + (", the wrong sign" if least.part < 0.0 else "")
            best.append((kind, least.quantity, part, _percent(least.error)))
    return best


def _figure(found: Comparison) -> Any:
    quantities = list(dict.fromkeys(change.quantity for change in found.changes))
    figure, places = grid(len(quantities), COLUMNS, 2.6)
    for axes, quantity in zip(places, quantities, strict=True):
        mine = [change for change in found.changes if change.quantity == quantity]
        ends = [value for one in mine for value in (one.measured, one.predicted, 0.0)]
        axes.plot([min(ends), max(ends)], [min(ends), max(ends)], color="0.7", linewidth=1.0)
        for number, kind in enumerate(KINDS):
            of_kind = [one for one in mine if one.record.kind == kind]
            if of_kind:
                x, y = ([getattr(one, name) for one in of_kind] for name in ("measured", "predicted"))
                spread = np.array([(one.predicted - one.low, one.high - one.predicted) for one in of_kind]).T
                axes.errorbar(x, y, spread, fmt=MARKS[kind], color=PALETTE[number], markersize=4.0, label=kind)
        axes.set_title(quantity)
        axes.set_xlabel("measured change, %")
        axes.set_ylabel("predicted change, %")
    # One for all, beside them: within, it would hide points.
    shown = {name: handle for axes in places for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(shown.values(), shown, loc="outside upper right", ncols=len(shown))
    return figure
