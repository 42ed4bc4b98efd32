"""Functions of one coordinate as cubic pieces: constant, linear, a polynomial, or through knots."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.scene import Displacement

Span = tuple[float, float]  # lowest and highest coordinate that counts
TURN: Span = (-math.pi, math.pi)
MANY = 64  # knots, from which on a spline's equations are solved by its three diagonals
_CUBIC = 4  # coefficients
_MISS = 1.0e-9  # rad or m, by which the pieces of a polynomial may miss it
_MOST_PIECES = 4096
_SAMPLES = 1001


def depends(displacement: Displacement) -> bool:
    """Whether a displacement changes with the coordinate."""
    polynomial = any(c != 0.0 for c in displacement.polynomial[1:])
    return bool(displacement.x) or displacement.slope != 0.0 or polynomial


def pieces(displacement: Displacement, span: Span = TURN) -> tuple[Floats, Floats]:
    """Where the pieces start (P,), and their coefficients (rows, P, 4) over the distance from there, constant first.

    What goes through knots goes on straight beyond its ends, as OpenSim's functions do; the first piece leads back from
    the first knot. A polynomial of a degree over 3 becomes pieces that miss it by no more than 1e-9 within the span.
    """
    if displacement.polynomial:
        return _polynomial(rows(displacement.polynomial), span)
    if not displacement.x:
        line = rows([displacement.value, displacement.slope])
        return np.zeros(1), np.concatenate([line, np.zeros_like(line)], axis=1)[:, None]
    if all(isinstance(value, float) for value in displacement.y):
        start, c = _through_numbers(tuple(displacement.x), tuple(displacement.y), displacement.ends)
        return start.copy(), c.copy()
    return _through(np.array(displacement.x), rows(displacement.y), displacement.ends)


@lru_cache(maxsize=1024)
def _through_numbers(x: tuple[float, ...], y: tuple[float, ...], ends: str) -> tuple[Floats, Floats]:
    """Those of one row, kept, since a viewer asks for them at every picture."""
    return _through(np.array(x), rows(list(y)), ends)


def _through(x: Floats, y: Floats, ends: str) -> tuple[Floats, Floats]:
    """The pieces through knots at x (K,) with values y (rows, K)."""
    width = np.diff(x)
    slope = np.diff(y, axis=1) / width
    bend = np.zeros_like(y) if ends == "linear" else _second_derivatives(x, y, ends)
    c = np.zeros((len(y), len(x) + 1, 4))
    inner = c[:, 1:-1]
    inner[..., 0] = y[:, :-1]
    inner[..., 1] = slope - width * (2.0 * bend[:, :-1] + bend[:, 1:]) / 6.0
    inner[..., 2] = 0.5 * bend[:, :-1]
    inner[..., 3] = np.diff(bend, axis=1) / (6.0 * width)
    c[:, 0, :2] = inner[:, 0, :2]
    c[:, -1, 0] = y[:, -1]
    c[:, -1, 1] = slope[:, -1] + width[-1] * (bend[:, -2] + 2.0 * bend[:, -1]) / 6.0
    return np.concatenate([x[:1], x]), c


def held_beyond(start: Floats, c: Floats, low: float, high: float) -> tuple[Floats, Floats]:
    """Pieces of a function as in `pieces` that stays as it is at two coordinates below the one and above the other."""
    inside = start[(start > low) & (start < high)]
    begins = np.array([low, *inside])
    kept = np.maximum(np.searchsorted(start, begins, side="right") - 1, 0)
    cubics = [_from(c[:, piece], begin - start[piece]) for piece, begin in zip(kept, begins, strict=True)]
    first, last = cubics[0].copy(), _from(cubics[-1], high - begins[-1])
    first[:, 1:] = last[:, 1:] = 0.0
    return np.array([low, *begins, high]), np.stack([first, *cubics, last], axis=1)


def _from(c: Floats, by: float) -> Floats:
    """Coefficients (rows, 4) of a cubic over the distance from a place that is farther by so much."""
    c0, c1, c2, c3 = c.T
    value = c0 + by * (c1 + by * (c2 + by * c3))
    return np.stack([value, c1 + by * (2.0 * c2 + 3.0 * by * c3), c2 + 3.0 * by * c3, c3], axis=1)


def _polynomial(c: Floats, span: Span) -> tuple[Floats, Floats]:
    """The pieces of a polynomial: itself, or cubics with its values and slopes at both ends."""
    degree = c.shape[1] - 1
    if degree < _CUBIC:
        return np.zeros(1), np.concatenate([c, np.zeros((len(c), _CUBIC - 1 - degree))], axis=1)[:, None]
    low, high = span
    fourth = float(np.abs(_powers(np.linspace(low, high, _SAMPLES), degree, 4) @ c.T).max())
    widest = (384.0 * _MISS / max(fourth, 1e-300)) ** 0.25  # Hermite's cubics miss by h^4/384 fourth derivatives
    count = int(min(max(math.ceil((high - low) / widest), 1), _MOST_PIECES))
    x, h = np.linspace(low, high, count + 1), (high - low) / count
    y, slope = ((_powers(x, degree, order) @ c.T).T for order in (0, 1))
    rise, first, last = np.diff(y, axis=1) / h, slope[:, :-1], slope[:, 1:]
    cubics = [y[:, :-1], first, (3.0 * rise - 2.0 * first - last) / h, (first + last - 2.0 * rise) / h**2]
    return x[:-1], np.stack(cubics, axis=-1)


def _powers(x: Floats, degree: int, order: int) -> Floats:
    """What multiplies the coefficients in a derivative of a polynomial at x (n,): (n, degree + 1)."""
    k = np.arange(degree + 1)
    factor = np.prod([k - j for j in range(order)], axis=0)
    return np.asarray(factor * x[:, None] ** np.maximum(k - order, 0))


def _second_derivatives(x: Floats, y: Floats, ends: str) -> Floats:
    """Second derivatives (rows, K) at the knots of a cubic spline with continuous ones.

    `natural`: none at the ends. `simm`: there the third derivative is that of the cubic through the four knots next to
    them (Forsythe, Malcolm, Moler 1977, section 4.4), as in SIMM and OpenSim.
    """
    count, width = len(x), np.diff(x)
    slope = np.diff(y, axis=1) / width
    matrix, right = np.zeros((count, count)), np.zeros_like(y)
    for i in range(1, count - 1):
        matrix[i, i - 1 : i + 2] = width[i - 1], 2.0 * (width[i - 1] + width[i]), width[i]
        right[:, i] = 6.0 * (slope[:, i] - slope[:, i - 1])
    matrix[0, 0] = matrix[-1, -1] = 1.0
    if ends == "simm" and count > 2:
        matrix[0, :2] = matrix[-1, :-3:-1] = -1.0, 1.0
        if count > 3:
            third = np.diff(np.diff(slope, axis=1) / (x[2:] - x[:-2]), axis=1) / (x[3:] - x[:-3])
            right[:, 0], right[:, -1] = 6.0 * width[0] * third[:, 0], -6.0 * width[-1] * third[:, -1]
    if count > MANY:
        return _tridiagonal(matrix, right)
    return np.asarray(np.linalg.solve(matrix, right.T).T)


def _tridiagonal(matrix: Floats, right: Floats) -> Floats:
    """Solutions (rows, K) of equations with a matrix (K, K) of three diagonals, which takes no time of K^3."""
    below, middle, above = (np.diagonal(matrix, k) for k in (-1, 0, 1))
    pivot, found = middle.copy(), right.copy()
    for k in range(1, len(pivot)):
        factor = below[k - 1] / pivot[k - 1]
        pivot[k] = middle[k] - factor * above[k - 1]
        found[:, k] -= factor * found[:, k - 1]
    found[:, -1] /= pivot[-1]
    for k in range(len(pivot) - 2, -1, -1):
        found[:, k] = (found[:, k] - above[k] * found[:, k + 1]) / pivot[k]
    return found


def rates(displacement: Displacement, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Value, first and second derivative (n,) at coordinates (n,)."""
    if displacement.polynomial:
        c = rows(displacement.polynomial)
        value, first, second = (np.sum(_powers(q, c.shape[1] - 1, order) * c, axis=1) for order in range(3))
        return value, first, second
    start, c = pieces(displacement)
    piece = np.maximum(np.searchsorted(start, q, side="right") - 1, 0)
    c0, c1, c2, c3 = np.moveaxis(c[np.arange(len(q)) if len(c) > 1 else 0, piece], -1, 0)
    t = q - start[piece]
    return c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3), 2.0 * c2 + 6.0 * t * c3
