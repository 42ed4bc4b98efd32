"""What a study has come to, as lines of text, as a table of runs, and as one HTML page."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from warpmuscle.core.files import shown
from warpmuscle.core.plain_text import number_of, rounded
from warpmuscle.gait.table import DECIMALS
from warpmuscle.plots.conditions import FALLS, RISES, Lines, Panel, draw_conditions
from warpmuscle.plots.style import style
from warpmuscle.report.images import data_uri
from warpmuscle.report.page import template
from warpmuscle.results.records import made_by
from warpmuscle.studies.conditions import CLEAR, Cell, Condition, Verdict, has_value, spread_of
from warpmuscle.studies.energy_balance import MEASURES as BALANCE
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.study.measured import Held, Row, StudyResult, values_of
from warpmuscle.sweep.study.replay import replay_of
from warpmuscle.sweep.study.table import COST

SEARCH_COST = "cost of the search"
PLACES = DECIMALS | {"W/kg": 2, "J/(kg m)": 2}  # of which changes are small
OTHERWISE: dict[Verdict, str] = {"contradicts": "against what was expected", "open": "left open"}  # by verdict
NAMES = ("", "run")  # axes of conditions that have but names
VERDICTS = (
    "Agrees: the 95 % confidence interval of the median change lies on the expected side, or, if only a value was "
    "expected, contains it; in sign, not in size: it lies on the expected side, but does not contain the expected "
    "value. Contradicts: it lies on the other side, or does not contain the value. Open: it does neither, or there are "
    "fewer than the six seeds that it takes. What should not change by more than an amount agrees if the whole "
    "interval is within it."
)


def text_of(condition: Condition) -> str:
    """A condition in words."""
    return condition if isinstance(condition, str) else shown(condition)


def number(unit: str, value: float) -> str:
    """A value with as many decimals as its unit is worth; empty if there is none."""
    if not np.isfinite(value):
        return ""
    return rounded(value, PLACES[unit]) if unit in PLACES else f"{value:.4g}"


def lines(found: StudyResult) -> list[tuple[str, ...]]:
    """The study as it is printed: a row a measure and series, with the median of each condition."""
    conditions = _conditions(found)
    several = len({row.series for row in found.rows}) > 1
    head = (*(("series",) if several else ()), "measure", "unit", *map(text_of, conditions), "trend")
    rows = [head]
    for row in found.rows:
        cells = {cell.condition: number(row.unit, cell.spread.median) for cell in row.cells}
        series = (row.series,) if several else ()
        rows.append((*series, row.measure, row.unit, *(cells.get(c, "") for c in conditions), _trend(row)))
    return rows


def held_lines(found: StudyResult) -> list[str]:
    """What was expected, a line each."""
    return [
        f"{held.verdict}: {held.expected.measure} {_expected(held, found)} at {_where(held)}; "
        f"found {_found(held, found)}, {_note(held)}" + (f" ({held.expected.source})" if held.expected.source else "")
        for held in found.held
    ]


def run_table(found: StudyResult) -> list[tuple[str, ...]]:
    """A row a run: name, seed, what sets it apart, whether it walked to the end, and all its measures."""
    axes = list(dict.fromkeys(axis for run in found.runs for axis in run.run.axes if axis != "seed"))
    units = {row.measure: row.unit for row in found.rows}
    words = ("condition" if axis == "run" else axis for axis in axes)  # `run` is the name of all
    head = ("run", "seed", *words, "walked", *(f"{name} ({unit})" if unit else name for name, unit in units.items()))
    rows = [head]
    for run in found.runs:
        values = (run.measures.get(name) for name in units)
        texts = ("" if value is None else repr(float(value)) for value in values)
        own = (text_of(run.run.axes[axis]) if axis in run.run.axes else "" for axis in axes)
        rows.append((run.run.name, str(run.run.seed), *own, "yes" if run.walked else "no", *texts))
    return rows


def page(found: StudyResult, plan: Plan, command: str) -> str:
    """The page; raises Error if jinja2 or matplotlib are missing."""
    series = list(dict.fromkeys(row.series for row in found.rows))
    tables = [_table(found, one, len(series) > 1) for one in series]
    with style():
        figure = data_uri(_figure(found))
    names = {condition: _named(condition, found) for condition in _conditions(found)}
    return str(
        template("study.html").render(
            title=found.study.title,
            text=found.study.text,
            headline=headline(found),
            replay=replay_of(found, names),
            held=[_held(held, found) for held in found.held],
            reference=_named(found.study.reference, found),
            verdicts=VERDICTS,
            figure=figure,
            words=any(isinstance(condition, str) for condition in _conditions(found)),
            people=any(row.unit == "SD" for row in found.rows),
            angles=any(row.unit == "deg" for row in found.rows),
            diamonds=any(held.expected.value is not None for held in found.held),
            tables=tables,
            left_out=[(run.run.name, run.why or "fell") for run in found.runs if run.why or not run.walked],
            sweep=plan.text,
            made=made_by(command),
        )
    )


def counted(found: StudyResult) -> str:
    """How many runs there are, of how many conditions, and how many walked."""
    conditions, seeds = _conditions(found), {run.run.seed for run in found.runs}
    walked = sum(run.walked for run in found.runs)
    verdicts = Counter(held.verdict for held in found.held)
    text = (
        f"{number_of(len(found.runs), 'run')}, {number_of(len(conditions), 'condition')}, "
        f"{number_of(len(seeds), 'seed')}; {walked} walked to the end"
    )
    if found.held:
        text += "; of what was expected " + ", ".join(f"{count} {word}" for word, count in sorted(verdicts.items()))
    return text


def headline(found: StudyResult) -> list[tuple[str, str]]:
    """What the page begins with: numbers, and what they count."""
    walked, verdicts = sum(run.walked for run in found.runs), Counter(held.verdict for held in found.held)
    seeds = len({run.run.seed for run in found.runs})
    numbers = [(str(len(_conditions(found))), "conditions"), (str(seeds), "seeds" if seeds > 1 else "seed")]
    numbers.append((f"{walked} of {len(found.runs)}", "walked to the end"))
    if found.held:
        numbers.append((f"{verdicts['agrees']} of {len(found.held)}", "as expected"))
        numbers += [(str(verdicts[word]), meaning) for word, meaning in OTHERWISE.items() if verdicts[word]]
    return numbers


def _conditions(found: StudyResult) -> list[Condition]:
    return list(dict.fromkeys(run.condition for run in found.runs))


def _trend(row: Row) -> str:
    if row.trend is None:
        return ""
    word = "" if row.trend.chance < CLEAR else " (unclear)"
    return f"{row.trend.tau:+.2f}{word}"


def _table(found: StudyResult, series: str, several: bool) -> dict[str, Any]:
    rows = [row for row in found.rows if row.series == series]
    cells = rows[0].cells if rows else ()
    heads = [
        text_of(cell.condition) + ("" if cell.walked == cell.runs else f" ({cell.walked} of {cell.runs} walked)")
        for cell in cells
    ]
    return {
        "title": series if several else _heading(found.study.condition),
        "heads": heads,
        "trends": any(row.trend is not None for row in rows),
        "powers": any(row.measure in BALANCE for row in rows),
        "rows": [
            {
                "measure": row.measure,
                "unit": row.unit,
                "cells": [_shown(row, cell) for cell in row.cells],
                "trend": "" if row.trend is None else f"{row.trend.tau:+.2f}, p {row.trend.chance:.2g}",
            }
            for row in rows
        ],
    }


def _shown(row: Row, cell: Cell) -> dict[str, str]:
    """A cell of a table: the cost of a fall is a million, which says nothing but that all fell."""
    if row.measure == COST and not cell.walked:
        return {"median": "fell", "band": ""}
    return {"median": number(row.unit, cell.spread.median), "band": _band(row.unit, cell)}


def _heading(axis: str) -> str:
    """What sets conditions apart, unless they have but names."""
    return "Conditions" if axis in NAMES else axis


def _band(unit: str, cell: Any) -> str:
    spread = cell.spread
    return f"{number(unit, spread.low)} to {number(unit, spread.high)}" if spread.count > 1 else ""


def _expected(held: Held, found: StudyResult) -> str:
    """What was expected, in words."""
    words: list[str] = [held.expected.change] if held.expected.change else []
    if held.expected.within:
        words.append(f"within {number(_unit(held, found), held.expected.within)} {_unit(held, found)}".rstrip())
    if held.expected.value is not None:
        value = abs(held.expected.value) if held.expected.change == "falls" else held.expected.value
        words.append(f"by {number(_unit(held, found), value)} {_unit(held, found)}".rstrip())
    return " ".join(words)


def _named(condition: Condition, found: StudyResult) -> str:
    """A condition in words, with the name of its axis where it is a number."""
    axis = found.study.condition
    return text_of(condition) if isinstance(condition, str) or axis in NAMES else f"{axis} {text_of(condition)}"


def _where(held: Held) -> str:
    return text_of(held.cell.condition) + (f", {held.series}" if held.series else "")


def _found(held: Held, found: StudyResult) -> str:
    unit, change, (low, high) = _unit(held, found), held.cell.change, held.cell.interval
    interval = f" ({number(unit, low)} to {number(unit, high)})" if np.isfinite(low) else ""
    if not change.count:
        return "nothing"
    return f"{number(unit, change.median)} {unit}".rstrip() + interval


def _note(held: Held) -> str:
    """On how many pairs of runs it rests, and whether an expected value is in the interval."""
    has = has_value(held.expected, held.cell) if held.expected.change else None
    words = {None: "", True: "; the expected value lies within", False: "; the expected value lies outside"}
    return number_of(held.cell.change.count, "pair") + words[has]


def _unit(held: Held, found: StudyResult) -> str:
    return next(row.unit for row in found.rows if row.measure == held.expected.measure)


def _held(held: Held, found: StudyResult) -> dict[str, str]:
    return {
        "measure": held.expected.measure,
        "condition": _named(held.cell.condition, found) + (f", {held.series}" if held.series else ""),
        "expected": _expected(held, found),
        "found": _found(held, found),
        "note": _note(held),
        "verdict": held.verdict,
        "words": _words(held),
        "source": held.expected.source,
    }


def _words(held: Held) -> str:
    """The verdict, and whether it is of the sign alone: a change by a tenth of what is published is no agreement."""
    sign_alone = held.expected.change and has_value(held.expected, held.cell) is False
    return "agrees in sign, not in size" if held.verdict == "agrees" and sign_alone else held.verdict


def _figure(found: StudyResult) -> Any:
    conditions = _conditions(found)
    place = {condition: number for number, condition in enumerate(conditions)}
    panels = []
    for measure in found.measures:
        rows = [row for row in found.rows if row.measure == measure]
        several = len(rows) > 1
        title = SEARCH_COST if measure == COST else measure
        panels.append(Panel(title, rows[0].unit, tuple(_line(found, row, place, several) for row in rows)))
    panels.sort(key=lambda panel: (panel.title == SEARCH_COST, not any(one.is_expected for one in panel.lines)))
    axis = "condition" if found.study.condition in NAMES else found.study.condition
    return draw_conditions(axis, conditions, panels, _walked(found, conditions))


def _walked(found: StudyResult, conditions: list[Condition]) -> list[str]:
    """Of each condition, how many of its runs walked and so stand in the figure."""
    words = []
    for condition in conditions:
        mine = [run.walked for run in found.runs if run.condition == condition]
        words.append(number_of(len(mine), "run") if all(mine) else f"{sum(mine)} of {len(mine)} walked")
    return words


def _line(found: StudyResult, row: Row, place: dict[Condition, int], several: bool) -> Lines:
    runs = [run for run in found.runs if run.series == row.series and run.walked]
    spreads = {cell.condition: cell.spread for cell in row.cells}
    if row.measure == COST:  # that of a fall is a million: it would leave nothing to see of the others
        spreads = {c: spread_of(values_of([run for run in runs if run.condition == c], COST)) for c in spreads}

    def column(name: str) -> Any:
        return np.array([getattr(spreads[c], name) if c in spreads else np.nan for c in place])

    base = spreads[found.study.reference].median if found.study.reference in spreads else np.nan
    return Lines(
        row.series if several else "", column("median"), column("low"), column("high"),
        tuple(place[run.condition] for run in runs), values_of(runs, row.measure), *_marks(found, row, place, base),
    )  # fmt: skip


def _marks(found: StudyResult, row: Row, place: dict[Condition, int], base: float) -> tuple[Any, Any, Any]:
    """What is expected of a row: values, signs of changes, and ranges, each with its place; none without a base."""
    of_row = [held for held in found.held if held.series == row.series and held.expected.measure == row.measure]
    at = [(place[held.cell.condition], held.expected) for held in of_row if np.isfinite(base)]
    signs = {"rises": RISES, "falls": FALLS}
    return (
        tuple((where, base + one.value) for where, one in at if one.value is not None),
        tuple((where, base, signs[one.change]) for where, one in at if one.value is None and one.change in signs),
        tuple((where, base, one.within) for where, one in at if one.change == "stays"),
    )
