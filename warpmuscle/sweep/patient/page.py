"""What a patient's path has come to, as lines of text, as a table of walks, and as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of, rounded
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.plots.stride_bands import Group, Panel, draw_strides
from warpmuscle.plots.style import style
from warpmuscle.report.images import data_uri
from warpmuscle.report.page import template
from warpmuscle.results.records import made_by
from warpmuscle.scene.norms import FORCE
from warpmuscle.studies.conditions import Cell, Spread
from warpmuscle.sweep.patient.compared import BAND, JUDGED_POINTS, Changed, Distance, Walk, numbers_of
from warpmuscle.sweep.patient.file import UNCHANGED
from warpmuscle.sweep.patient.gait import ANGLES, MOMENTS, UNITS, unit_of
from warpmuscle.sweep.patient.path import PathResult
from warpmuscle.sweep.patient.recorded import Patient

DECIMALS = {"deg": 1, "N m/kg": 2, "W/kg": 2, "body weights": 2, "m/s": 2, "s": 2, "m": 2, "J/(kg m)": 2, "SD": 1}
SHOWN = 0.05  # deg, from which on a shift of angles is told
ENOUGH = 6  # pairs of walks, from which on a change has an interval


def number(unit: str, value: float | None) -> str:
    """A value with as many decimals as its unit is worth; empty if there is none."""
    if value is None or not np.isfinite(value):
        return ""
    return rounded(value, DECIMALS.get(unit, 1))


def band(unit: str, spread: Spread) -> str:
    """A band over seeds in words; empty of a single one."""
    return f"{number(unit, spread.low)} to {number(unit, spread.high)}" if spread.count > 1 else ""


def match_lines(found: PathResult) -> list[tuple[str, ...]]:
    """How far walks are from the patient, a row a curve and side, as it is printed."""
    rows: list[tuple[str, ...]] = [
        ("distance from the patient", "unit", "own strides", "before", "after", "5 to 95 % of seeds")
    ]
    for one in (*found.searched, *found.judged):
        name = f"{one.side} {one.name[:1].lower()}{one.name[1:]}"
        values = (number(one.unit, one.of_strides), number(one.unit, one.before), number(one.unit, one.found.median))
        rows.append(
            (name + ("" if one.name in ANGLES else ", not searched for"), one.unit, *values, band(one.unit, one.found))
        )
    return rows


def change_lines(found: PathResult) -> list[tuple[str, ...]]:
    """Medians of the numbers under each condition, and changes that are clear, as it is printed."""
    names = found.conditions
    rows = [("after adapting", "unit", "patient", *names)]
    for one in found.numbers:
        cells = {str(cell.condition): cell for cell in one.cells}
        texts = [_cell_text(one.unit, cells[name], name) if name in cells else "" for name in names]
        rows.append((one.name, one.unit, number(one.unit, one.patient), *texts))
    return rows


def _cell_text(unit: str, cell: Cell, name: str) -> str:
    """The median, and by how much it differs from that without a change."""
    text = number(unit, cell.spread.median)
    if name == UNCHANGED or not cell.change.count:
        return text
    return f"{text} ({signed(unit, cell.change.median)}{'' if is_clear(cell) else ' ?'})"


def signed(unit: str, value: float) -> str:
    """A change with its sign."""
    text = number(unit, value)
    return text if text.startswith("-") or not text else f"+{text}"


def ends(cell: Cell) -> tuple[float, float]:
    """The interval of a change; of fewer pairs than one takes, the least and the greatest, about."""
    low, high = cell.interval
    return (low, high) if np.isfinite(low) else (cell.change.low, cell.change.high)


def is_clear(cell: Cell) -> bool:
    """Whether the interval of the change is on one side of 0; of fewer pairs than one takes, whether all are."""
    low, high = ends(cell)
    return bool(cell.change.count > 1 and low * high > 0.0)


def table(found: PathResult) -> list[tuple[str, ...]]:
    """A row a walk: which search, seed and condition, whether it walked to the end, distance, and all its numbers."""
    walks = [("match", walk) for walk in found.matched] + [("adapt", walk) for walk in found.adapted]
    names = list(dict.fromkeys(name for _, walk in walks for name in numbers_of(walk)))
    rows = [
        ("search", "seed", "condition", "walked", "why not", "distance (SD)", *(f"{n} ({unit_of(n)})" for n in names))
    ]
    for search, walk in walks:
        numbers = numbers_of(walk)
        distance = found.distances.get(walk.seed) if search == "match" else None
        rows.append(
            (search, str(walk.seed), walk.condition, "yes" if walk.walked else "no", walk.why,
             "" if distance is None else repr(distance), *(repr(numbers[n]) if n in numbers else "" for n in names))
        )  # fmt: skip
    return rows


def counted(found: PathResult) -> str:
    """How near the walks are, in one line."""
    distances = list(found.distances.values())
    before = found.distance_before
    was = f"{before:.1f} before" if before is not None else f"the scene as it stands {found.before.why}"
    strides = ", ".join(f"{number_of(found.patient.strides(side), 'stride')} of the {side}" for side in SIDES)
    return (
        f"{strides}; {number_of(len(found.matched), 'search')}, {len(distances)} walked, angles "
        f"{np.median(distances):.1f} SD of the patient's strides from the mean ({was})"
    )


def page(found: PathResult, command: str) -> str:
    """The page; raises Error if jinja2 or matplotlib are missing."""
    rendered, label = template("patient.html"), f"the patient's strides, ± {BAND:g} SD"
    with style():
        figures = {
            "angles": _uri(_match_panels(found, ANGLES), 3, label),
            "judged": _uri(_match_panels(found, (*MOMENTS, FORCE)), 4, label),
            "change_angles": _uri(_change_panels(found, ANGLES), 3, label),
            "change_moments": _uri(_change_panels(found, (*MOMENTS, FORCE)), 4, label),
        }
    return str(
        rendered.render(
            title=found.asked.title, text=found.asked.asked.text, headline=_headline(found), verdict=_verdict(found),
            figures=figures, searched=[_distance(one) for one in found.searched],
            judged=[_distance(one) for one in found.judged], points=_points(found),
            conditions=found.conditions, changes=list(found.asked.changes), main=_main_changes(found),
            numbers=[_number_row(one, found) for one in found.numbers],
            fallen=[(w.seed, w.condition or "match", w.why) for w in (*found.matched, *found.adapted) if not w.walked],
            least=found.patient.least_spread, floor=_floor(found), band=BAND, habit=found.asked.asked.adapt.habit,
            enough=len(found.distances) >= ENOUGH, file=found.asked.source.text, made=made_by(command),
        )
    )  # fmt: skip


def _headline(found: PathResult) -> list[tuple[str, str]]:
    """The numbers that are read first."""
    distances = list(found.distances.values())
    before = found.distance_before
    walked = len(distances)
    return [
        (" + ".join(str(found.patient.strides(side)) for side in SIDES), "strides recorded, left + right"),
        (f"{found.patient.gait.speed:.2f} m/s", "speed of the patient"),
        (f"{walked} of {len(found.matched)}", "searches found a walk"),
        (f"{before:.1f} SD" if before is not None else "falls", found.before_in_words),
        (f"{np.median(distances):.1f} SD", "from the patient's mean stride, after it"),
    ]


def _verdict(found: PathResult) -> str:
    """Whether the walks are within the patient's own spread, in a sentence."""
    inside = [one for one in found.searched if one.found.median <= BAND]
    names = [f"{one.side} {one.name.lower()}" for one in found.searched if one.found.median > BAND]
    if not names:
        return f"All six angles are within {BAND:g} SD of the patient's mean stride, root mean square."
    rest = f"not {', '.join(names)}"
    if not inside:
        return (
            f"None of the six angles is within {BAND:g} SD of the patient's mean stride: the model does not walk like "
            "this patient, and what follows holds for the model alone."
        )
    are = f"{len(inside)} of six angles {'is' if len(inside) == 1 else 'are'}"
    return f"{are} within {BAND:g} SD of the patient's mean stride, root mean square; {rest}."


def _floor(found: PathResult) -> str:
    """What the reader has to know of the patient's angles and their spread."""
    patient = found.patient
    return " ".join(filter(None, (_hips(patient.hip_offset), _spread_of_strides(patient))))


def _hips(offset: float) -> str:
    """By how much hip angles were shifted, in a sentence; empty if they were not."""
    if abs(offset) < SHOWN:
        return ""
    return (
        f"The pelvis of the model is tilted otherwise than that of the recordings. So the patient's hips are shown, "
        f"and were searched for, {abs(offset):.1f} degrees {'more' if offset > 0 else 'less'} flexed: where angles are "
        "equal, thighs stand alike."
    )


def _spread_of_strides(patient: Patient) -> str:
    """How much of the spread is the patient's own, in a sentence."""
    if min(patient.strides(side) for side in SIDES) < 2:
        return (
            "There is but one stride of a side, so that the patient's own spread is not known: "
            f"{patient.least_spread:g} degrees stand for it."
        )
    measured = [float(np.mean(patient.gait.curves[n][s].std(axis=0, ddof=1))) for n in ANGLES for s in SIDES]
    return (
        f"The patient's strides spread by {min(measured):.1f} to {max(measured):.1f} degrees (mean SD of an angle); "
        f"less than {patient.least_spread:g} degrees counts as {patient.least_spread:g}."
    )


def _uri(panels: list[Panel], columns: int, label: str) -> str:
    return data_uri(draw_strides(panels, columns, "the patient's mean", label)) if panels else ""


def _match_panels(found: PathResult, names: Sequence[str]) -> list[Panel]:
    """Panels of the walks that the search found, left above right."""
    return [
        _panel(found, name, side, [(found.before_in_words, [found.before], True),
                                   ("the model, matched", list(found.matched), False)])
        for side in SIDES for name in names if name in found.patient.gait.curves or name in ANGLES
    ]  # fmt: skip


def _change_panels(found: PathResult, names: Sequence[str]) -> list[Panel]:
    """Panels of the walks that adapted, a group a condition."""
    words = {UNCHANGED: "the model without it"}
    groups = [
        (words.get(condition, condition), [walk for walk in found.adapted if walk.condition == condition], False)
        for condition in found.conditions
    ]
    return [_panel(found, name, side, groups) for side in SIDES for name in names]


def _panel(found: PathResult, name: str, side: str, groups: list[tuple[str, list[Walk], bool]]) -> Panel:
    patient = found.patient
    rows: Floats | None = patient.gait.curves.get(name, {}).get(side)
    mean: Floats | None
    spread: Floats | None
    mean = None if rows is None else rows.mean(axis=0)
    if name in ANGLES:
        spread = BAND * patient.spread[name][side]
    else:
        spread = None if rows is None or len(rows) < 2 else BAND * rows.std(axis=0, ddof=1)
    drawn = tuple(
        Group(label, np.array([w.gait.mean(name, side) for w in walks if w.gait is not None and name in w.gait.curves]),
              quiet)
        for label, walks, quiet in groups
    )  # fmt: skip
    words = {"deg": "degrees"}.get(UNITS[name], UNITS[name])
    return Panel(f"{side.capitalize()} {name[:1].lower()}{name[1:]}", words, mean, spread, drawn)


def _distance(one: Distance) -> dict[str, str]:
    return {
        "name": f"{one.side} {one.name.lower()}", "unit": one.unit, "own": number(one.unit, one.of_strides),
        "before": number(one.unit, one.before), "after": number(one.unit, one.found.median),
        "band": band(one.unit, one.found),
        "within": "" if one.within is None else number("%", one.within.median).split(".")[0],
        "likeness": "" if one.likeness is None else f"{one.likeness.median:.2f}",
    }  # fmt: skip


def _points(found: PathResult) -> list[dict[str, str]]:
    """Times and lengths, that no search saw, beside the patient's."""
    return [
        {"name": one.name, "unit": one.unit, "patient": number(one.unit, one.patient),
         "after": number(one.unit, one.matched.median), "band": band(one.unit, one.matched)}
        for one in found.numbers if one.name in JUDGED_POINTS and one.patient is not None
    ]  # fmt: skip


def _number_row(one: Changed, found: PathResult) -> dict[str, Any]:
    cells = {str(cell.condition): cell for cell in one.cells}
    none = cells.get(UNCHANGED)
    return {
        "name": one.name, "unit": one.unit, "patient": number(one.unit, one.patient),
        "spread": "" if one.spread is None else f"± {number(one.unit, one.spread)}",
        "matched": number(one.unit, one.matched.median), "matched_band": band(one.unit, one.matched),
        "none": "" if none is None else number(one.unit, none.spread.median),
        "none_band": "" if none is None else band(one.unit, none.spread),
        "cells": [_change_cell(one.unit, cells.get(name)) for name in found.asked.changes],
    }  # fmt: skip


def _change_cell(unit: str, cell: Cell | None) -> dict[str, Any]:
    # A key such as `clear` would be the method of the dictionary to the template.
    if cell is None or not cell.spread.count:
        return {"value": "", "change": "", "interval": "", "sure": False}
    low, high = ends(cell)
    interval = f"{signed(unit, low)} to {signed(unit, high)}" if cell.change.count > 1 else ""
    change = signed(unit, cell.change.median) if cell.change.count else ""
    return {"value": number(unit, cell.spread.median), "change": change, "interval": interval, "sure": is_clear(cell)}


def _main_changes(found: PathResult) -> list[dict[str, Any]]:
    """For each change what it does most clearly: changes over the spread of the walks without it, greatest first."""
    listed = []
    for name in found.asked.changes:
        ranked = []
        for one in found.numbers:
            cells = {str(cell.condition): cell for cell in one.cells}
            cell, none = cells.get(name), cells.get(UNCHANGED)
            if cell is None or none is None or not cell.change.count or not is_clear(cell):
                continue
            scale = max(none.spread.high - none.spread.low, 0.02 * abs(none.spread.median), 1e-9)
            low, high = ends(cell)
            way = "rises" if cell.change.median > 0 else "falls"
            text = (
                f"{one.name}{',' if ',' in one.name else ''} {way} by {number(one.unit, abs(cell.change.median))} "
                f"{one.unit} ({signed(one.unit, low)} to {signed(one.unit, high)})"
            )
            ranked.append((abs(cell.change.median) / scale, text))
        walked = next((c for one in found.numbers for c in one.cells if str(c.condition) == name), None)
        ranked.sort(key=lambda pair: -pair[0])
        listed.append({
            "name": name, "lines": [text for _, text in ranked[:6]], "more": max(len(ranked) - 6, 0),
            "walked": "" if walked is None else f"{walked.walked} of {walked.runs}",
            "fell": walked is None or walked.walked == 0,
        })  # fmt: skip
    return listed
