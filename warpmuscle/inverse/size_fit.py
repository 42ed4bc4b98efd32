"""Sizes of bodies and places of markers fitted with all frames together, the coordinates of each frame among them.

Least squares over factors s of bodies, offsets d of markers, and coordinates q of F frames,

    1/F sum_f sum_k w_k |e_fk|^2 / ERROR^2 + sum_k |d_k|^2 / OFFSET^2 + sum_b |s_b - mean|^2 / SPREAD^2,

by Gauss and Newton: q is solved in each frame for the sizes as they are, and its step eliminated from theirs (variable
projection; Golub, Pereyra 2003, Inverse Problems 19: R1-R26). A marker that is far from where the model has it counts
less, by Cauchy's weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.inverse.chain import Chain
from warpmuscle.inverse.marker_fit import Fit, MarkerFitter, Problem
from warpmuscle.inverse.sized_chain import SizedChain, Sizes

ERROR = 0.003  # m, of a marker: what skin moves, in the mean of many frames
OFFSET = 0.01  # m, from where a model has a marker to where a subject wears it
SPREAD = 0.3  # of factors about their mean
FARTHER = 0.02  # m, from which on an offset counts less
MOST_FRAMES = 60
MOST_STEPS = 25
CLOSE = 2.0e-5  # of factors, and m: a step that ends the fit
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
    steps, converged = 0, False
    while True:
        own = chain.chain(sizes)
        fit = _posed(chain, own, frames, weights, device)
        if converged or steps >= MOST_STEPS:
            return SizeFit(sizes, own, steps, converged, fit)
        change = _step(chain, own, sizes, fit, weights, move_markers)
        count = sizes.factors.size
        factors = np.clip(sizes.factors + change[:count].reshape(-1, 3), SMALLEST, LARGEST)
        sizes = Sizes(factors, sizes.offsets + change[count:].reshape(-1, 3))
        steps += 1
        converged = bool(np.abs(change).max() < CLOSE)


def _frames(positions: Floats) -> Floats:
    """Frames that count: at most so many, over all of the time, of those that show most markers."""
    seen = np.isfinite(positions).all(axis=2).sum(axis=1)
    good = np.flatnonzero(seen >= 0.8 * seen.max())
    chosen = np.unique(np.linspace(0, len(good) - 1, min(MOST_FRAMES, len(good))).round().astype(int))
    return positions[good[chosen]]


def _posed(chain: SizedChain, own: Chain, frames: Floats, weights: Floats, device: Any) -> Fit:
    """Coordinates of each frame alone, from afar."""
    count = len(own.coordinates)
    places = [own.markers[name] for name in chain.markers]
    problem = Problem(frames, weights, tuple(range(len(frames))), np.zeros(count), np.array([own.neutral]))
    return MarkerFitter(own, places, device).fit(problem)


def _step(
    chain: SizedChain, own: Chain, sizes: Sizes, fit: Fit, weights: Floats, move_markers: Floats
) -> Floats:  # fmt: skip
    """The step of factors and offsets, (G * 3 + K * 3,)."""
    poses = own.poses(fit.values)
    places = [own.markers[name] for name in chain.markers]
    frames, markers = fit.errors.shape[:2]
    rows = 3 * markers
    seen = np.repeat(np.isfinite(fit.errors[..., 0]), 3, axis=1)
    w = np.where(seen, np.repeat(weights, 3), 0.0)
    e = np.nan_to_num(fit.errors).reshape(frames, rows)
    by_q = own.jacobian(fit.values, places).reshape(frames, rows, -1)
    at_limit = (fit.values <= own.low) | (fit.values >= own.high)
    by_q = np.where((at_limit | fit.loose.astype(bool))[:, None], 0.0, by_q)
    by_s = chain.by_factor(poses, fit.values).reshape(frames, rows, -1)
    by_d = np.zeros((frames, rows, rows))
    axes = chain.by_offset(poses)
    for k in range(markers):
        by_d[:, 3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = axes[:, k]
    by_sizes = np.concatenate([by_s, by_d], axis=2)
    weighted = by_q.transpose(0, 2, 1) * w[:, None]
    square = weighted @ by_q + 1e-9 * np.eye(by_q.shape[2])
    free = by_sizes - by_q @ np.linalg.solve(square, weighted @ by_sizes)
    turned = free.transpose(0, 2, 1) * (w[:, None] / (frames * ERROR**2))
    matrix = np.sum(turned @ free, axis=0)
    slope = np.einsum("fpr,fr->p", turned, e)
    prior, centre = _prior(sizes, move_markers)
    now = np.concatenate([sizes.factors.ravel() - sizes.factors.mean(), sizes.offsets.ravel()])
    return np.asarray(np.linalg.solve(matrix + prior, slope - centre @ now))


def _prior(sizes: Sizes, move_markers: Floats) -> tuple[Floats, Floats]:
    """Matrix of what is known beforehand, and what multiplies factors less their mean and offsets in its slope."""
    count = sizes.factors.size
    about_mean = (np.eye(count) - np.full((count, count), 1.0 / count)) / SPREAD**2
    away = np.sum(sizes.offsets**2, axis=1)
    firm = np.where(move_markers, 1.0 / (OFFSET**2 * (1.0 + away / FARTHER**2)), 1.0e12)
    prior = np.zeros((count + 3 * len(firm),) * 2)
    prior[:count, :count] = about_mean + 1e-9 * np.eye(count)
    prior[count:, count:] = np.diag(np.repeat(firm, 3))
    return prior, prior
