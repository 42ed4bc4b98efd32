"""Quadratic programmes of wanted accelerations, many at once, from arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.program.program_batch import ProgramBatch

AT_ONCE = 65536  # programmes


@dataclass(frozen=True)
class ProgramSolutions:
    """What P programmes of n coordinates and m controls come to.

    Attributes:
        control: (P, m) within their bounds. acceleration: (P, n) that follow from them.
        iterations: (P,) of Newton's method; -1 where forces are not balanced.
    """

    control: Floats
    acceleration: Floats
    iterations: Integers


def quadratic_program(
    mass: ArrayLike,
    bias: ArrayLike,
    forces: ArrayLike,
    wanted: ArrayLike,
    *,
    weight: ArrayLike = 1.0,
    cost: ArrayLike = 1.0,
    low: ArrayLike = 0.0,
    high: ArrayLike = 1.0,
    device: str | None = None,
) -> ProgramSolutions:
    """Bounded controls of minimum effort that best achieve wanted accelerations, for P problems at once.

    Each is: minimise 1/2 |wanted - q''|^2_W + 1/2 sum of c u^2, so that M q'' + h = B u and low <= u <= high
    (after Lee and others 2014). Controls are whatever makes forces: muscles at full activation, torques, edges of
    friction cones. Solutions are those of double precision; numbers are taken in single precision.

    Args:
        mass: M, (P, n, n), symmetric and positive definite. bias: h, (P, n): forces that no control makes, on the side
            of accelerations, such as weight. forces: B, (P, n, m), generalised forces of controls at 1.
        wanted: (P, n) accelerations. weight: W, (P, n, n), symmetric and positive definite, or its diagonal (P, n).
        cost: c, positive. low, high: bounds, which may be infinite; all three (m,), (P, m) or one number.
        device: by default a GPU if there is one.

    Raises:
        ArgumentError: shapes do not fit, numbers are not finite, a matrix is not symmetric or not positive definite,
            a cost is not positive, or a bound is above the other one.
        RolloutError: no such device.
    """
    b = _finite(forces, "forces", 3)
    count, n, m = b.shape
    if not (count and n and m):
        raise ArgumentError(f"forces must have a programme, a coordinate and a control, not the shape {b.shape}")
    matrices = {"mass": _matrix(mass, "mass", count, n), "weight": _weight(weight, count, n)}
    vectors = {"bias": _rows(bias, "bias", count, n), "wanted": _rows(wanted, "wanted", count, n)}
    own = {
        name: _of_controls(values, name, count, m) for name, values in (("cost", cost), ("low", low), ("high", high))
    }
    if not np.all((own["cost"] > 0.0) & np.isfinite(own["cost"])):
        raise ArgumentError("cost must be positive and finite")
    if np.any(own["low"] > own["high"]):
        raise ArgumentError("low must not be greater than high")
    if np.any(own["low"] == np.inf) or np.any(own["high"] == -np.inf):
        raise ArgumentError("a bound leaves no control: low is infinite, or high minus infinity")
    rows = [np.flatnonzero(np.any(b[:, :, j] != 0.0, axis=0)).tolist() for j in range(m)]
    found, place = [], find_device(device)
    for first in range(0, count, AT_ONCE):
        part = slice(first, min(first + AT_ONCE, count))
        found.append(_solved(part, b, rows, matrices, vectors, own, place))
    return ProgramSolutions(*(np.concatenate(arrays) for arrays in zip(*found, strict=True)))


def _solved(
    part: slice, b: Floats, rows: list[list[int]], matrices: dict[str, Floats], vectors: dict[str, Floats],
    own: dict[str, Floats], device: Any,
) -> tuple[Any, ...]:  # fmt: skip
    """Controls, accelerations and iterations of some of the programmes."""
    count, n = part.stop - part.start, b.shape[1]
    shared = all(len(values) == 1 for values in own.values())
    batch = ProgramBatch(count, n, rows, device, bounds=1 if shared else count)
    given: dict[str, Floats] = {name: values[part].reshape(count, n * n) for name, values in matrices.items()}
    given |= {name: values[part] for name, values in vectors.items()}
    if batch.columns.row.size:
        given["entry"] = np.concatenate([b[part, :, j][:, one] for j, one in enumerate(rows)], axis=1)
    for name, values in (("gain", 1.0 / own["cost"]), ("low", own["low"]), ("high", own["high"])):
        given[name] = values if len(values) == 1 else values[part]
    for name, values in given.items():
        target = getattr(batch.numbers, name)
        target.assign(np.broadcast_to(values, target.shape).astype(np.float32))
    batch.solve()
    arrays = batch.control, batch.acceleration
    return (*(array.numpy().astype(np.float64) for array in arrays), batch.iterations.numpy().astype(np.int64))


def _finite(values: ArrayLike, name: str, axes: int) -> Floats:
    array = as_array(values, name).astype(np.float64)
    if array.ndim != axes:
        raise ArgumentError(f"{name} must have {number_of(axes, 'axis')}, not the shape {array.shape}")
    if not np.all(np.abs(array) <= np.finfo(np.float32).max):
        raise ArgumentError(f"a number of {name} is not finite, or too great")
    return array


def _rows(values: ArrayLike, name: str, count: int, n: int) -> Floats:
    array = _finite(values, name, 2)
    if array.shape != (count, n):
        raise ArgumentError(f"{name} has the shape {array.shape}, not {(count, n)} as forces ask for")
    return array


def _matrix(values: ArrayLike, name: str, count: int, n: int) -> Floats:
    array = _finite(values, name, 3)
    if array.shape != (count, n, n):
        raise ArgumentError(f"{name} has the shape {array.shape}, not {(count, n, n)} as forces ask for")
    size = np.abs(array).max(axis=(1, 2), keepdims=True)
    if np.any(np.abs(array - array.transpose(0, 2, 1)) > 1e-5 * size):
        raise ArgumentError(f"{name} must be symmetric")
    array = 0.5 * (array + array.transpose(0, 2, 1))
    try:
        np.linalg.cholesky(array)
    except np.linalg.LinAlgError:
        raise ArgumentError(f"{name} must be positive definite") from None
    return array


def _weight(values: ArrayLike, count: int, n: int) -> Floats:
    """Weights as matrices, from these, their diagonals, or one number."""
    array = as_array(values, "weight").astype(np.float64)
    if array.ndim == 3:
        return _matrix(array, "weight", count, n)
    try:
        diagonal = np.broadcast_to(array, (count, n))
    except ValueError:
        raise ArgumentError(f"weight has the shape {array.shape}, not {(count, n, n)} or {(count, n)}") from None
    return _matrix(diagonal[:, :, None] * np.eye(n), "weight", count, n)


def _of_controls(values: ArrayLike, name: str, count: int, m: int) -> Floats:
    """Numbers of controls, (1, m) or (P, m)."""
    array = as_array(values, name).astype(np.float64)
    if np.isnan(array).any():
        raise ArgumentError(f"{name} has something that is not a number")
    for shape in ((1, m), (count, m)):
        if array.ndim < 2 or array.shape == shape:
            try:
                return np.array(np.broadcast_to(array, shape))
            except ValueError:
                break
    raise ArgumentError(f"{name} has the shape {array.shape}, not {(m,)} or {(count, m)}")
