"""What a result that was read has to be: shapes, kinds and ranges of all its numbers, so that all work on it is sound.

Files and journals may come from anyone. What they hold is checked here once, by the layout of `records` and
`recording`, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from warpmuscle.core.array_checks import HUGE, LARGEST_INDEX, check_integers, check_numbers
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import Status
from warpmuscle.results.learned import check_learned
from warpmuscle.results.recorded_quantities import INTEGER_QUANTITIES, NAMED, QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import (
    ANY_NUMBER,
    COLUMNS,
    Best,
    Evaluations,
    Fit,
    History,
    ParameterTable,
    Result,
    Searched,
    SearchOptions,
)

HUGE_SINGLE = 1.0e18  # the same of single precision, in which motion is recorded
LONGEST = 1.0e5  # s, of a motion
QUATERNION_LENGTH = (0.5, 2.0)
_ORIENTATIONS = [name for name, quantity in QUANTITIES.items() if quantity.axes[-1] == "x y z w"]


def check_result(result: Result) -> None:
    """Check all of a result; raises ValueError with the place of what is wrong."""
    count = len(result.parameters.name)
    if not 0 <= result.seed < 2**64:
        raise ValueError(f"the seed is {result.seed}")
    check_parameters(result.parameters)
    rows = 0
    if result.evaluations is not None:
        check_evaluations(result.evaluations, count)
        rows = len(result.evaluations)
    if result.best is not None:
        _check_best("best", result.best, count, rows)
    if result.searched is not None:
        if result.evaluations is None:
            raise ValueError("a search has no evaluations")
        _check_searched(result.searched, count, rows)
    for term, parts in result.parts.items():
        check_numbers(f"best/parts/{term}/value", np.array(list(parts.values())), (len(parts),))
    for number, recording in enumerate(result.replays):
        check_recording(recording, f"replay/{number}/")
    if result.fit is not None:
        _check_fit(result.fit)
    if result.learned is not None:
        check_learned(result.learned)


def check_parameters(table: ParameterTable) -> None:
    """Check a table of parameters; raises ValueError."""
    shape = (len(table.name),)
    for name in ("min", "max", "step", "value"):
        check_numbers(f"parameters/{name}", getattr(table, name), shape)
    for name in ("unit", "scale"):
        if len(getattr(table, name)) != len(table.name):
            raise ValueError(
                f"parameters/{name} has {number_of(len(getattr(table, name)), 'entry')}, not {len(table.name)}"
            )
    if unknown := set(table.scale) - {"linear", "log"}:
        raise ValueError(f"parameters/scale holds {min(unknown)!r}, not linear or log")
    if np.any(table.min > table.max):
        raise ValueError("parameters/min holds a value above that of parameters/max")
    if np.any(table.min[np.array(table.scale, dtype=str) == "log"] <= 0.0):
        raise ValueError("parameters/min holds a value of 0 or less for a scale that is logarithmic")


def check_evaluations(found: Evaluations, parameters: int) -> None:
    """Check a table of candidates with so many parameters; raises ValueError."""
    count = np.size(found.cost)
    for name in COLUMNS[1:]:
        check_column(name, getattr(found, name), count)
    check_numbers("evaluations/params", found.params, (count, parameters))
    if len(set(found.term_names)) != len(found.term_names):
        raise ValueError("evaluations/term_names names a term twice")
    check_numbers("evaluations/terms", found.terms, (count, len(found.term_names)), gaps=True)


def check_column(name: str, array: Any, count: int) -> None:
    """Check the numbers of a column of a table of so many candidates, one each; raises ValueError."""
    if name == "cost":
        check_numbers("evaluations/cost", array, (count,))
    elif name == "end_time":
        check_numbers("evaluations/end_time", array, (count,), 0.0)
    else:
        highest = max(Status) if name == "status" else LARGEST_INDEX
        check_integers(f"evaluations/{name}", array, (count,), -1 if name == "search" else 0, highest)


def check_recording(motion: Recording, place: str = "") -> None:
    """Check a motion, whose shapes it has checked itself; raises ValueError."""
    for name in QUANTITIES:
        array = motion[name]
        if name in INTEGER_QUANTITIES:
            check_integers(f"{place}{name}", array, array.shape, 0, 1 if name == "stance" else LARGEST_INDEX)
        else:
            check_numbers(f"{place}{name}", array, array.shape, -HUGE_SINGLE, HUGE_SINGLE)
    if motion.frames:
        check_numbers(f"{place}time", motion.time, motion.time.shape, -LONGEST, LONGEST)
        if np.any(np.diff(motion.time) <= 0.0):
            raise ValueError(f"{place}time holds times that do not increase")
    for name in _ORIENTATIONS:
        length = np.linalg.norm(motion[name].astype(np.float64), axis=-1)
        if length.size and not (QUATERNION_LENGTH[0] <= length.min() and length.max() <= QUATERNION_LENGTH[1]):
            raise ValueError(f"{place}{name} holds quaternions that are far from unit length")
    for name in NAMED.values():
        _check_names(f"{place}{name}", getattr(motion, name))


def _check_best(place: str, best: Best, parameters: int, rows: int) -> None:
    check_numbers(f"{place}/params", best.params, (parameters,))
    check_numbers(f"{place}/cost", np.asarray(best.cost), ())
    if not 0 <= best.index < rows:
        raise ValueError(f"{place}/index is {best.index}, but /evaluations has {number_of(rows, 'row')}")


def _check_searched(searched: Searched, parameters: int, rows: int) -> None:
    _check_options("searches", searched.options)
    _check_history(searched.history)
    if not 0 <= searched.stage < max(len(searched.stages), 1):
        raise ValueError(f"searches: stage {searched.stage} is none of {len(searched.stages)}")
    if searched.evaluated and not rows <= searched.evaluated <= LARGEST_INDEX:
        raise ValueError(f"searches: {number_of(searched.evaluated, 'candidate')} in all, but /evaluations has {rows}")
    for number, state in enumerate(searched.states):
        for name, array in state.items():
            if np.asarray(array).dtype.kind not in "biuf":
                raise ValueError(f"searches/{number}/{name} holds no numbers")
    for number, stage in enumerate(searched.stages):
        _check_options(f"stages/{number}", stage.options)
        _check_names(f"stages/{number}/free", stage.free)
        if stage.best is not None:
            _check_best(f"stages/{number}/best", stage.best, parameters, rows)


def _check_history(history: History) -> None:
    shape = np.shape(history.generation)
    if len(shape) != 1:
        raise ValueError(f"history/generation has shape {shape}, and should have one axis")
    for name in ("generation", "search", "stage"):
        check_integers(f"history/{name}", getattr(history, name), shape)
    check_integers("history/asks_crc32", history.asks_crc32, shape, 0, 2**32 - 1)
    for name in ("best", "median", "spread"):
        check_numbers(f"history/{name}", getattr(history, name), shape)
    check_numbers("history/sigma", history.sigma, shape, gaps=True)


def _check_options(place: str, options: SearchOptions) -> None:
    def refuse(name: str, value: object) -> ValueError:
        return ValueError(f"{place}: {name} is {value!r}")

    for name in ("strategy", "restarts"):
        if not isinstance(getattr(options, name), str):
            raise refuse(name, getattr(options, name))
    for name, can_miss in {"searches": False, "population": True, "candidates": False}.items():
        value = getattr(options, name)
        if not (value is None and can_miss) and not (type(value) is int and 0 < value <= 2 * ANY_NUMBER):
            raise refuse(name, value)
    for name, least in {"sigma": 0.0, "until": 0.0, "target": -HUGE}.items():
        value = getattr(options, name)
        if value is not None and not (type(value) in (int, float) and least <= value <= HUGE):
            raise refuse(name, value)


def _check_fit(fit: Fit) -> None:
    if fit.r2.ndim != 3 or 0 in fit.r2.shape:
        raise ValueError(f"the fit's r2 has shape {fit.r2.shape}, and should have stages, motions and joints")
    check_numbers("r2 of the fit", fit.r2, (len(fit.stages), fit.r2.shape[1], len(fit.joints)))
    check_numbers("seconds of the fit", fit.seconds, (len(fit.stages),))


def _check_names(place: str, names: Iterable[str]) -> None:
    names = list(names)
    if len(set(names)) != len(names):
        raise ValueError(f"{place} holds a name twice")
