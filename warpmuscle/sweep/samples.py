"""Points between limits, in place of every combination of values: the table `[sample]` of a sweep file.

Example:
    [sample]
    points = 64                         # of a Sobol sequence a power of two
    method = "sobol"                    # or "random", "adaptive"
    seed = 1
    first = 16                          # with "adaptive": so many of a Sobol sequence at first ...
    batch = 8                           # ... then so many at a time where results change most

    [sample.axes]
    "objective.target_speed" = { min = 0.8, max = 1.4 }
    strength = { keys = ["character.muscles.*.f_max"], min = 0.5, max = 2, scale = "log", factor = true }

A point has a value on each axis. More points of the same seed begin with the earlier ones, so that a sweep can be
extended. Those of a Sobol sequence (Sobol 1967, direction numbers of Joe and Kuo 2008) fill the limits more evenly than
independent ones; all are shifted by one random vector, modulo 1 (Cranley and Patterson 1976). Adaptive ones follow from
the least costs of those before, see `refinement`.
"""

from __future__ import annotations

import math
import warnings
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.formats.overrides import Override
from warpmuscle.formats.toml import Source
from warpmuscle.sweep.axes import Choice, flat, short_name

POINT = "point"  # the axis of their numbers
PLACE = "sample.axes"


class Range(msgspec.Struct, forbid_unknown_fields=True):
    """An axis of a sample: keys that get the same value between two limits, or are multiplied by it."""

    min: float
    max: float
    scale: Literal["linear", "log"] = "linear"
    keys: list[str] = []
    factor: bool = False


class Sample(msgspec.Struct, forbid_unknown_fields=True):
    """The table `[sample]` of a sweep file."""

    points: int
    axes: dict[str, Any]  # each a `Range`
    method: Literal["sobol", "random", "adaptive"] = "sobol"
    seed: int = 1
    first: int | None = None  # by default four, and four more an axis
    batch: int | None = None  # by default half of these


class Sampled(NamedTuple):
    """The points of a sweep file that are known."""

    choices: list[Choice]  # one a point
    units: Floats  # (n, d) in the unit cube
    axes: tuple[str, ...]  # (d,)


def rounds_of(sample: Sample, dimensions: int) -> tuple[int, int]:
    """How many points an adaptive sample begins with, and how many follow at a time."""
    first = 4 * (dimensions + 1) if sample.first is None else sample.first
    return min(first, sample.points), max(first // 2, 1) if sample.batch is None else sample.batch


def sampled(source: Source, sample: Sample, chosen: Floats | None = None) -> Sampled:
    """A choice a point, with a value of each axis beside its number.

    Args:
        chosen: (n, d) points of the unit cube after the first ones of an adaptive sample; none by default.

    Raises:
        SceneError: there are no points or axes, or limits that are none, with the key.
    """
    if sample.points < 1:
        raise SceneError("there must be one point at least", key="sample.points")
    check_size("sweep", sample.points, lambda text: SceneError(text, key="sample.points"))
    for name in ("first", "batch"):
        count = getattr(sample, name)
        if count is not None and sample.method != "adaptive":
            raise SceneError('is of method = "adaptive" alone', key=f"sample.{name}")
        if count is not None and count < 1:
            raise SceneError("there must be one point at least", key=f"sample.{name}")
    if sample.seed < 0:
        raise SceneError("a seed is a whole number of 0 at least", key="sample.seed")
    if not sample.axes:
        raise SceneError('name what is sampled: "objective.target_speed" = { min = 0.8, max = 1.4 }', key=PLACE)
    names: dict[str, Range] = {}
    keys: dict[str, tuple[str, ...]] = {}
    lines = {}
    for key, table in flat(sample.axes, mark="min"):
        axis = to_type(table, Range, key=f"{PLACE}.{key}")
        _check(key, axis)
        name = key if axis.keys else short_name(key)
        if name in names or name == POINT:
            raise SceneError(f"two axes would be called {name!r}: name one as NAME = {{ keys = [..], .. }}", key=PLACE)
        names[name], keys[name] = axis, tuple(axis.keys) or (key,)
        lines[name] = source.line(f"{PLACE}.{key}")
    units = _points(sample, len(names))
    if chosen is not None:
        units = np.concatenate([units, chosen])
    found = []
    for number, row in enumerate(units):
        values = {name: _value(axis, float(u)) for (name, axis), u in zip(names.items(), row, strict=True)}
        overrides = tuple(
            Override(key, {"factor": value} if names[name].factor else value, lines[name])
            for name, value in values.items() for key in keys[name]
        )  # fmt: skip
        of_scene = {name: () if axis.factor else keys[name] for name, axis in names.items()}
        found.append(Choice(POINT, float(number), overrides, beside=values, keys_beside=of_scene))
    return Sampled(found, units, tuple(names))


def _check(key: str, axis: Range) -> None:
    """Raise SceneError if there is nothing between the limits of an axis."""
    if not (math.isfinite(axis.min) and math.isfinite(axis.max) and axis.min < axis.max):
        raise SceneError(f"min must be below max, not {axis.min:g} and {axis.max:g}", key=f"{PLACE}.{key}")
    if axis.scale == "log" and axis.min <= 0.0:
        raise SceneError("a logarithmic scale begins above 0", key=f"{PLACE}.{key}.min")
    if any(one in ("seed", "scene") or one.startswith(("search.", "training.")) for one in (axis.keys or [key])):
        raise SceneError("only numbers of the scene are sampled: put this into [grid]", key=f"{PLACE}.{key}")


def _value(axis: Range, unit: float) -> float:
    """What stands at a place of the unit interval."""
    if axis.scale == "log":
        low, high = math.log(axis.min), math.log(axis.max)
        return min(max(math.exp(low + unit * (high - low)), axis.min), axis.max)
    return axis.min + unit * (axis.max - axis.min)


def _points(sample: Sample, dimensions: int) -> Floats:
    """Points of the unit cube, (n, dimensions); fewer of the same seed are the first of these."""
    rng = np.random.default_rng(sample.seed)
    if sample.method == "random":
        return rng.random((sample.points, dimensions))
    from scipy.stats import qmc  # takes a second

    count = rounds_of(sample, dimensions)[0] if sample.method == "adaptive" else sample.points
    shift = rng.random(dimensions)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of a number that is no power of two, which the manual says
        points: Floats = qmc.Sobol(dimensions, scramble=False).random(count)
    return (points + shift) % 1.0
