"""Options of the trainings of a sweep: when they end, and the options of `warpmuscle learn`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from warpmuscle.core.arguments import as_integer, as_number
from warpmuscle.core.errors import Error
from warpmuscle.learning.options import PPOOptions, options_of

ENDS = ("iterations", "until", "target")


@dataclass(frozen=True)
class TrainingPlan:
    """Options of one training."""

    iterations: int | None
    until: float | None  # s of wall time
    target: float | None  # share that must last its whole time at the speed wanted
    options: Mapping[str, Any]  # of `PPOOptions`; what is left out is usual


def training_plan(values: Mapping[str, Any]) -> TrainingPlan:
    """From the table `[training]` of a sweep file.

    Raises:
        Error: a key is unknown, a value impossible, or nothing ends the training.
    """
    options = {name: value for name, value in values.items() if name not in ENDS}
    checked = options_of({name: tuple(v) if isinstance(v, list) else v for name, v in options.items()})
    ends = {name: values.get(name) for name in ENDS}
    if all(end is None for end in ends.values()):
        raise Error("a training needs an end: iterations, until (s of wall time) or target (a share that walks)")
    if ends["iterations"] is not None:
        ends["iterations"] = as_integer(ends["iterations"], "iterations")
    if ends["until"] is not None:
        ends["until"] = as_number(ends["until"], "until", above=0.0)
    if ends["target"] is not None:
        ends["target"] = as_number(ends["target"], "target", least=0.0, most=1.0)
    kept = {name: getattr(checked, name) for name in PPOOptions.__struct_fields__ if name in options}
    return TrainingPlan(**ends, options=kept)
