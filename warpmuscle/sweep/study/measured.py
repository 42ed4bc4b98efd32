"""A study: a sweep whose runs differ in conditions and seeds, measured, compared, and held against what is expected."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.status import Status
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.gait.table import unit_of
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.result import read as read_result
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.validation.checks import near
from warpmuscle.studies.conditions import (
    Cell,
    Condition,
    Expected,
    Trend,
    Verdict,
    cells_of,
    farthest,
    trend_of,
    verdict_of,
)
from warpmuscle.studies.energy_balance import MEASURES as BALANCE
from warpmuscle.studies.energy_balance import UNIT as BALANCE_UNIT
from warpmuscle.studies.energy_balance import balance_measures
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.plan.runs import SweepRun
from warpmuscle.sweep.processes import in_processes
from warpmuscle.sweep.run import SweepResult
from warpmuscle.sweep.study.table import COST, POWER, Study

UNSEEN = ("target speed", "norm band", " at")  # ends of names of what is no measure by itself


@dataclass(frozen=True)
class MeasuredRun:
    """The best motion of a run in numbers."""

    run: SweepRun
    condition: Condition
    series: str
    walked: bool  # to the end
    measures: Measures
    why: str = ""  # no more is known of it
    units: Mapping[str, str] = field(default_factory=dict)  # of free parameters that are measures
    file: Path | None = None  # of the run, that has its motion


@dataclass(frozen=True)
class Row:
    """A measure over all conditions of a series."""

    series: str
    measure: str
    unit: str
    cells: tuple[Cell, ...]
    trend: Trend | None


@dataclass(frozen=True)
class Held:
    """What was expected of a measure, and what was found."""

    expected: Expected
    series: str
    cell: Cell
    verdict: Verdict


@dataclass(frozen=True)
class StudyResult:
    """What a study has come to."""

    study: Study
    runs: tuple[MeasuredRun, ...]
    rows: tuple[Row, ...]
    held: tuple[Held, ...]

    @property
    def measures(self) -> list[str]:
        """All measures, each once."""
        return list(dict.fromkeys(row.measure for row in self.rows))


def measured(
    plan: Plan, done: SweepResult, processes: int = 1, tell: Callable[[int], None] | None = None
) -> StudyResult:
    """Measure all runs of a sweep with a study.

    Args:
        processes: at most so many measure at the same time. tell: gets how many runs have been measured.

    Raises:
        Error: the sweep has no study or no run has ended, or none gives a measure that the study names.
    """
    study = plan.study
    if study is None:
        raise Error(f"{plan.file}: this sweep has no [study]")
    ended = [run for run in plan.runs if run.name not in done.failed and done.folder.result(run.name).exists()]
    tasks = [(run, done.folder.result(run.name)) for run in ended]
    runs: list[MeasuredRun] = []
    for run in in_processes(processes, partial(_measured, study), tasks):
        runs.append(run)
        if tell is not None:
            tell(len(runs))
    if not runs:
        raise Error(f"{plan.file}: no run of this study has produced a result; {next(iter(done.failed.values()), '')}")
    rows = _rows(study, runs)
    return StudyResult(study, tuple(runs), rows, _held(study, rows))


def _measured(study: Study, task: tuple[SweepRun, Path]) -> MeasuredRun:
    run, file = task
    condition, series = study.condition_of(run.axes), study.series_of(run.axes)
    try:
        result = read_result(file)
    except ResultError as error:
        return MeasuredRun(run, condition, series, False, {}, str(error))
    best, evaluations = result.best, result.evaluations
    if best is None or evaluations is None or not result.replays:
        return MeasuredRun(run, condition, series, False, {}, "no candidate had ended")
    measures: Measures = {COST: best.cost}
    units: dict[str, str] = {}
    for name, unit, value in zip(result.parameters.name, result.parameters.unit, best.params, strict=True):
        if any("." in pattern and fnmatchcase(name, pattern) for pattern in study.measures):
            measures[name], units[name] = float(value), unit
    walked, why = Status(int(evaluations.status[best.index])) == Status.COMPLETED, ""
    try:
        scene = recorded_scene(result)
        found = gait_measures(result.replays[0], scene)
        measures |= found | in_all(found, scene) | balance_measures(result.replays[0], scene)
    except Error as error:  # of what has no legs, or fell before a whole cycle
        why = str(error)
    return MeasuredRun(run, condition, series, walked, measures, why, units, file)


def in_all(measures: Measures, scene: Scene) -> Measures:
    """The metabolic power of a numeric scene's whole body with its loads, W, if that for each kilogram is known."""
    power = measures.get("metabolic power")
    return {} if power is None else {POWER: power * body_mass(scene.character)}


def _rows(study: Study, runs: Sequence[MeasuredRun]) -> tuple[Row, ...]:
    given = dict.fromkeys(name for run in runs for name, value in run.measures.items() if value is not None)
    any_walked = any(run.walked for run in runs)
    names = _named(study, [name for name in given if not name.endswith(UNSEEN)], any_walked)
    units = (
        {COST: "", POWER: "W"}
        | dict.fromkeys(BALANCE, BALANCE_UNIT)
        | {name: unit for run in runs for name, unit in run.units.items()}
    )
    rows = []
    for series in dict.fromkeys(run.series for run in runs):
        mine = [run for run in runs if run.series == series]
        conditions, seeds = [run.condition for run in mine], [run.run.seed for run in mine]
        walked = np.array([run.walked for run in mine])
        for name in names:
            values = values_of(mine, name)
            cells = cells_of(values, walked, conditions, seeds, study.reference)
            unit = units[name] if name in units else unit_of(name)
            rows.append(Row(series, name, unit, tuple(cells), trend_of(values, conditions)))
    return tuple(rows)


def values_of(runs: Sequence[MeasuredRun], name: str) -> Floats:
    """A measure of runs (R,), not a number where one does not give it, or fell: then only its cost counts."""
    found = [run.measures.get(name) if run.walked or name == COST else None for run in runs]
    return np.array([np.nan if value is None else value for value in found], dtype=float)


def _named(study: Study, given: Sequence[str], walked: bool) -> list[str]:
    """The measures that a study names, in its order; raises Error where it names one that no run gives.

    Where none walked, only what there is: falls give next to nothing, and a table of costs is worth more than no table.
    """
    found: dict[str, None] = {}
    for pattern in (*study.measures, *(expected.measure for expected in study.expected)):
        names = [name for name in given if name == pattern or fnmatchcase(name, pattern)]
        if not names and walked and not (study.usual and pattern in study.measures):
            known = ", ".join(given)
            raise Error(f"the study asks for {pattern!r}{near(pattern, given)}; its runs give: {known}")
        found |= dict.fromkeys(names)
    return list(found)


def _held(study: Study, rows: Sequence[Row]) -> tuple[Held, ...]:
    held = []
    for expected in study.expected:
        for row in rows:
            if row.measure == expected.measure:
                at = expected.at
                if at is None:
                    at = farthest([cell.condition for cell in row.cells], study.reference)
                cell = next((cell for cell in row.cells if cell.condition == at), None)
                if cell is not None:
                    held.append(Held(expected, row.series, cell, verdict_of(expected, cell)))
    return tuple(held)
