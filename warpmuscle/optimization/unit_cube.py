"""Parameters as points of the unit cube, in which searches work, and to the precision that they have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene.parameters import Parameter


def snap(parameters: Sequence[Parameter], values: Floats) -> Floats:
    """Values rounded to the precision of their parameters, min + k step, and kept within their intervals.

    Args:
        parameters: P parameters.
        values: (..., P).

    Returns:
        (..., P); free of rounding noise: 0.7 rather than 0.7000000000000001.
    """
    snapped = np.array(values, dtype=np.float64)
    if snapped.shape[-1:] != (len(parameters),):
        raise Error(
            f"expected {number_of(len(parameters), 'value')} in the last dimension, got an array of shape "
            f"{snapped.shape}"
        )
    low, high = np.array([p.min for p in parameters]), np.array([p.max for p in parameters])
    stepped = np.array([index for index, p in enumerate(parameters) if p.step > 0.0], dtype=np.intp)
    if len(stepped):
        step, least = np.array([parameters[index].step for index in stepped]), low[stepped]
        last = np.floor((high[stepped] - least) / step * (1.0 + 1e-12) + 1e-9)
        steps = np.clip(np.rint((snapped[..., stepped] - least) / step), 0.0, last)
        columns = least + steps * step
        digits = np.maximum(12, 3 - np.floor(np.log10(step)).astype(int))
        for number in np.unique(digits):
            columns[..., digits == number] = np.round(columns[..., digits == number], number)
        snapped[..., stepped] = columns
    return np.clip(snapped, low, high)


def from_unit(parameters: Sequence[Parameter], unit: Floats) -> Floats:
    """Values of the parameters at points of the unit cube, in which searches work, to the parameters' precision.

    Args:
        parameters: P parameters.
        unit: (..., P), 0 at a parameter's min and 1 at its max, linear or logarithmic between them.

    Returns:
        (..., P), snapped (see `snap`).
    """
    given = np.array(unit, dtype=np.float64)
    low, high = np.array([p.min for p in parameters]), np.array([p.max for p in parameters])
    values = low + given * (high - low)
    for index, parameter in enumerate(parameters):
        if parameter.scale == "log":
            values[..., index] = parameter.min * np.exp(given[..., index] * np.log(parameter.max / parameter.min))
    return snap(parameters, values)


def to_unit(parameters: Sequence[Parameter], values: Floats) -> Floats:
    """Points of the unit cube where the parameters have these values, (..., P); 0.5 where an interval has no width."""
    unit = np.full(np.shape(values), 0.5)
    for index, parameter in enumerate(parameters):
        if parameter.max > parameter.min:
            column = np.asarray(values, dtype=np.float64)[..., index]
            if parameter.scale == "log":
                unit[..., index] = np.log(column / parameter.min) / np.log(parameter.max / parameter.min)
            else:
                unit[..., index] = (column - parameter.min) / (parameter.max - parameter.min)
    return np.asarray(np.clip(unit, 0.0, 1.0))
