"""What a sweep file says of the study that its runs are: `[study]`.

Example:
    [study]
    title = "Weak calf muscles"
    condition = "strength"         # the axis whose values are compared; without it, all axes but the seed
    reference = 1                  # its value that others are compared with, by default the first
    measures = ["speed", "step length", "knee*"]   # names as `warpmuscle gait` prints them, and patterns

    [[study.expected]]             # what is known, such as what has been published
    measure = "speed"
    change = "falls"               # from the reference; or rises, stays
    at = 0.5                       # a value of the condition, by default the farthest from the reference
    source = "Author 2020, table 3"
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec

from warpmuscle.core.errors import SceneError
from warpmuscle.core.files import shown
from warpmuscle.gait.measure_names import can_be_measured, measure_names
from warpmuscle.scene.validation.checks import near
from warpmuscle.studies.conditions import Condition, Expected
from warpmuscle.studies.energy_balance import MEASURES

COST = "cost"  # a measure of any search
POWER = "metabolic power in all"  # W, of the body with its loads
USUAL = (
    *("cost", "speed", "step length", "step width", "cadence", "stance", "double support", "cost of transport"),
    *("hip, maximum", "knee, maximum in stance", "knee, maximum in swing", "ankle, maximum in stance"),
    *("ankle, minimum at push-off", "ankle moment, maximum", "ankle power, maximum", "maximum vertical force"),
)
OF_FACTORS = 1.0  # value of an axis of factors that changes nothing


class _Expected(msgspec.Struct, forbid_unknown_fields=True):
    measure: str
    change: Literal["rises", "falls", "stays"] | None = None
    at: float | str | None = None
    value: float | None = None
    within: float | None = None
    source: str = ""


class StudyTable(msgspec.Struct, forbid_unknown_fields=True):
    """The table as it is written."""

    title: str = ""
    text: str = ""
    condition: str | None = None
    reference: float | str | None = None
    measures: list[str] | None = None
    expected: list[_Expected] = []


@dataclass(frozen=True)
class Study:
    """What the runs of a sweep are to show."""

    title: str
    text: str
    condition: str  # name of the axis; empty where all of them together are the condition
    reference: Condition
    measures: tuple[str, ...]  # patterns
    expected: tuple[Expected, ...]

    @property
    def usual(self) -> bool:
        """Whether the file names no measures, and those that most walks give are taken."""
        return self.measures == USUAL

    def condition_of(self, axes: Mapping[str, Condition]) -> Condition:
        """The condition of a run, by what sets it apart."""
        return axes.get(self.condition, OF_FACTORS) if self.condition else label(axes)

    def series_of(self, axes: Mapping[str, Condition]) -> str:
        """What else sets a run apart from others of its condition, but its seed; empty if nothing does."""
        others = {name: value for name, value in axes.items() if name != self.condition}
        return label(others) if self.condition and others.keys() - {"seed"} else ""


def label(axes: Mapping[str, Condition]) -> str:
    """What sets a run apart, in words: all axes but the seed that change anything."""
    words = [
        f"{name} {value if isinstance(value, str) else shown(value)}" if name != "run" else str(value)
        for name, value in axes.items()
        if name != "seed" and value != OF_FACTORS
    ]
    return ", ".join(words) or "normal"


def study_of(table: StudyTable, name: str, runs: Sequence[Mapping[str, Condition]]) -> Study:
    """The study that a table describes.

    Args:
        name: of the sweep. runs: by name of the axis, what sets each apart.

    Raises:
        SceneError: it names a condition, or a value of it, that no run has; or says nothing of what it expects;
            or it asks for a measure that no walk has.
    """
    axes = list(dict.fromkeys(axis for run in runs for axis in run if axis != "seed"))
    condition = (axes[0] if len(axes) == 1 else "") if table.condition is None else table.condition
    if condition not in axes and condition.rpartition(".")[2] in axes:  # the key of an axis, in place of its name
        condition = condition.rpartition(".")[2]
    if table.condition is not None and condition not in axes:
        known = ", ".join(axes) or "none but the seed"
        raise SceneError(f"no axis {condition!r}{near(condition, axes)}; there are: {known}", key="study.condition")
    if table.measures == []:
        raise SceneError("there is none in it; name some, or leave it out for the usual ones", key="study.measures")
    measures = USUAL if table.measures is None else tuple(table.measures)
    study = Study(table.title or name, table.text, condition, "", measures, ())
    values = list(dict.fromkeys(study.condition_of(run) for run in runs))
    reference = values[0] if table.reference is None else _among(table.reference, values, "study.reference")
    for index, pattern in enumerate(table.measures or ()):
        _check_measure(pattern, f"study.measures.{index}")
    expected: list[Expected] = []
    for index, one in enumerate(table.expected):
        found = _expected(one, values, reference, f"study.expected.{index}")
        if found in expected:
            raise SceneError("is there twice, and would count twice", key=f"study.expected.{index}")
        expected.append(found)
    return Study(study.title, table.text, condition, reference, study.measures, tuple(expected))


def _expected(one: _Expected, values: Sequence[Condition], reference: Condition, place: str) -> Expected:
    """What is expected of a measure; SceneError if it cannot be meant."""
    if {*"*?["} & {*one.measure}:
        raise SceneError("is the name of one measure, not a pattern of names", key=f"{place}.measure")
    _check_measure(one.measure, f"{place}.measure")
    if one.change is None and one.value is None:
        raise SceneError("says neither a change (rises, falls, stays) nor the value of one", key=place)
    if one.within is not None and (one.change != "stays" or not 0.0 < one.within < math.inf):
        raise SceneError('is greater than 0, of what "stays"', key=f"{place}.within")
    if one.value is not None and not math.isfinite(one.value):
        raise SceneError(f"is a finite number, not {one.value:g}", key=f"{place}.value")
    sign = {"rises": 1.0, "falls": -1.0}.get(one.change or "", 0.0)
    if one.value is not None and sign and not sign * one.value > 0.0:
        side = "above" if sign > 0.0 else "below"
        raise SceneError(f"is a change, {side} 0 where it {one.change}, not {one.value:g}", key=f"{place}.value")
    at = None if one.at is None else _among(one.at, values, f"{place}.at")
    if at is not None and at == reference:
        raise SceneError("is the reference itself, from which it changes by 0", key=f"{place}.at")
    return Expected(one.measure, one.change or "", at, one.value, one.source, one.within or 0.0)


def _check_measure(pattern: str, key: str) -> None:
    """Refuse, before anything is searched for, what fits no measure; free parameters, which have a dot, do later."""
    if "." not in pattern and not can_be_measured(pattern, (COST, POWER, *MEASURES)):
        known = (COST, *measure_names(), POWER, *MEASURES)
        words = near(pattern, known) or "; `warpmuscle gait` prints those of a walk"
        raise SceneError(f"no walk has a measure {pattern!r}{words}", key=key)


def _among(value: Condition, values: Sequence[Condition], key: str) -> Condition:
    if value not in values:
        known = ", ".join(other if isinstance(other, str) else shown(other) for other in values)
        raise SceneError(f"no run has the condition {value!r}; they are: {known}", key=key)
    return value
