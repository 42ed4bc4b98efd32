"""Sizes of bodies and places of markers fitted with all frames together, the coordinates of each frame among them.

Least squares over factors s of bodies, offsets d of markers, and coordinates q of F frames,

    1/F sum_f sum_k w_k |e_fk|^2 / ERROR^2 + sum_k |d_k|^2 / OFFSET^2 + sum_b |s_b - mean|^2 / SPREAD^2,

by Gauss and Newton: q is solved in each frame for the sizes as they are, and its step eliminated from theirs (variable
projection; Golub, Pereyra 2003, Inverse Problems 19: R1-R26). A marker that is far from where the model has it counts
less, by Cauchy's weights. ERROR is the root mean square of the errors e themselves, step by step, so that bodies are
taken as alike where markers tell little.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.inverse.chain import Chain
from warpmuscle.inverse.fit_plan import Problem, Recorded, seen_in
from warpmuscle.inverse.marker_fit import Fit, MarkerFitter
from warpmuscle.inverse.sized_chain import SizedChain, Sizes

LEAST_ERROR, MOST_ERROR = 1.0e-4, 0.01  # m, within which the errors of the fit tell ERROR
OFFSET = 0.01  # m, from where a model has a marker to where a subject wears it
SPREAD = 0.3  # of factors about their mean
FARTHER = 0.02  # m, from which on an offset counts less
MOST_FRAMES = 50
MOST_STEPS = 20
CLOSE, SETTLED = 2.0e-3, 0.01  # of factors, and m: a step that ends the fit, and one that is small enough
SMALLEST, LARGEST = 0.3, 3.0  # factors


@dataclass(frozen=True)
class SizeFit:
    """What was found."""

    sizes: Sizes
    chain: Chain
    steps: int
    converged: bool
    fit: Fit  # of the frames that counted


def fit_sizes(chain: SizedChain, positions: Floats, weights: Floats, move_markers: Floats, device: Any) -> SizeFit:
    """Fit factors and offsets.

    Args:
        positions: (F, K, 3) m, world axes of scenes, NaN where a marker is missing. weights: (K,).
        move_markers: (K,) whether a marker may be elsewhere than the model has it.
    """
    sizes = chain.usual
    frames = _frames(positions)
    steps, largest = 0, np.inf
    while True:
        own = chain.chain(sizes)
        fit = _posed(chain, own, frames, weights, device)
        if largest < CLOSE or steps >= MOST_STEPS:
            return SizeFit(sizes, own, steps, largest < SETTLED, fit)
        change = _step(chain, own, sizes, fit, weights, move_markers)
        count = sizes.factors.size
        factors = np.clip(sizes.factors + change[:count].reshape(-1, 3), SMALLEST, LARGEST)
        sizes = Sizes(factors, sizes.offsets + change[count:].reshape(-1, 3))
        steps += 1
        largest = float(np.abs(change).max())


def _frames(positions: Floats) -> Floats:
    """Frames that count: at most so many, over all of the time, of those that show most markers."""
    seen = seen_in(positions).sum(axis=1)
    good = np.flatnonzero(seen >= 0.8 * seen.max())
    chosen = np.unique(np.linspace(0, len(good) - 1, min(MOST_FRAMES, len(good))).round().astype(int))
    return np.asarray(positions[good[chosen]])


def _posed(chain: SizedChain, own: Chain, frames: Floats, weights: Floats, device: Any) -> Fit:
    """Coordinates of each frame alone, from afar."""
    count = len(own.coordinates)
    places = [own.markers[name] for name in chain.markers]
    recordings = [Recorded(frame[None], list(range(len(places)))) for frame in frames]
    problem = Problem(recordings, weights, np.zeros(count), np.array([own.neutral]))
    return MarkerFitter(own, places, device).fit(problem)


def _step(
    chain: SizedChain, own: Chain, sizes: Sizes, fit: Fit, weights: Floats, move_markers: Floats
) -> Floats:  # fmt: skip
    """The step of factors and offsets, (G * 3 + K * 3,)."""
    matrix, slope, error = _equations(chain, own, fit, weights)
    prior = _prior(sizes, move_markers)
    now = np.concatenate([sizes.factors.ravel() - sizes.factors.mean(), sizes.offsets.ravel()])
    return np.asarray(np.linalg.solve(matrix / error + prior, slope / error - prior @ now))


def _equations(chain: SizedChain, own: Chain, fit: Fit, weights: Floats) -> tuple[Floats, Floats, float]:
    """Matrix and slope of factors and offsets once coordinates are eliminated, in the mean of all frames; and the mean
    square of an error, m^2.

    With J of coordinates, S of factors and offsets: S' W S - S' W J (J' W J)^-1 J' W S; offsets turn with their bodies,
    so that their own part is diagonal. Coordinates are at their best, so that J' W e is nothing.
    """
    poses, places = own.poses(fit.values), [own.markers[name] for name in chain.markers]
    frames, markers = fit.errors.shape[:2]
    w = np.where(seen_in(fit.errors), weights, 0.0)  # (F, K)
    e = np.nan_to_num(fit.errors.astype(np.float64))
    at_limit = (fit.values <= own.low) | (fit.values >= own.high) | fit.loose.astype(bool)
    by_q = np.where(at_limit[:, None, None], 0.0, own.jacobian(fit.values, places))
    by_s, axes = chain.by_factor(poses, fit.values), chain.by_offset(poses)
    factors = by_s.shape[3]
    weighted_q = (by_q * w[..., None, None]).reshape(frames, 3 * markers, -1).transpose(0, 2, 1)
    square = weighted_q @ by_q.reshape(frames, 3 * markers, -1) + 1e-9 * np.eye(by_q.shape[3])
    mixed = np.concatenate(
        [
            weighted_q @ by_s.reshape(frames, 3 * markers, -1),
            np.einsum("fk,fkic,fkij->fckj", w, by_q, axes).reshape(frames, -1, 3 * markers),
        ],
        axis=2,
    )
    half = np.linalg.solve(np.linalg.cholesky(square), mixed).reshape(-1, mixed.shape[2])
    matrix = -half.T @ half
    weighted_s = by_s * w[..., None, None]
    matrix[:factors, :factors] += weighted_s.reshape(-1, factors).T @ by_s.reshape(-1, factors)
    both = np.einsum("fkip,fkij->pkj", weighted_s, axes).reshape(factors, -1)
    matrix[:factors, factors:] += both
    matrix[factors:, :factors] += both.T
    matrix[factors:, factors:] += np.diag(np.repeat(w.sum(axis=0), 3))
    slope = np.concatenate(
        [weighted_s.reshape(-1, factors).T @ e.ravel(), np.einsum("fk,fkij,fki->kj", w, axes, e).ravel()]
    )
    error = float(np.sum(w[..., None] * e**2) / max(3.0 * w.sum(), 1e-12))
    return matrix / frames, slope / frames, float(np.clip(error, LEAST_ERROR**2, MOST_ERROR**2))


def _prior(sizes: Sizes, move_markers: Floats) -> Floats:
    """Matrix of what is known beforehand, of factors less their mean and of offsets."""
    count = sizes.factors.size
    about_mean = (np.eye(count) - np.full((count, count), 1.0 / count)) / SPREAD**2
    away = np.sum(sizes.offsets**2, axis=1)
    firm = np.where(move_markers, 1.0 / (OFFSET**2 * (1.0 + away / FARTHER**2)), 1.0e12)
    prior = np.zeros((count + 3 * len(firm),) * 2)
    prior[:count, :count] = about_mean + 1e-9 * np.eye(count)
    prior[count:, count:] = np.diag(np.repeat(firm, 3))
    return prior
