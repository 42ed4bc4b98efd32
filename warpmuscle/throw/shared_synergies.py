"""Synergies that all motions share, fitted to the torques that the motions need as well as to activations.

Factors of activations that least squares found muscle by muscle account for most of these, but need not make the
torques of the motion any more. So weights W and signals C are found in turn, each by least squares within its bounds: C
of each motion, straight between its knots and passed through activation dynamics, given W; and W given all C. The sum
of squares is that of the torques' errors, in parts of what each joint's torque varies by, and of the distance from the
activations, at a price. Samples are weighed alike in all motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.motion import RATE, ArmMotions
from warpmuscle.throw.signals import Knots, Synergies, time_constants

STRIDE = 3  # samples
ROUNDS = 4
PRICE = 1.0  # of a squared distance from an activation, against a squared torque in parts of its deviation
ROUGH = 1e-5  # price of a squared second difference of a signal at its knots, a sample
TIE = 1e-6  # so that signals that nothing tells of are 0
NNLS_STEPS = 50  # an unknown, at most


@dataclass(frozen=True)
class SharedSynergies:
    """W and signals at the knots, and what they account for."""

    weights: Floats  # (M, N), the greatest of each synergy 1
    values: Floats  # (n, N, K) at the knots
    start: Floats  # (n, N)
    explained: float  # of the activations
    torque_r2: Floats  # (J,) of the torques that muscles are to make

    def synergies(self, knots: Knots, source: str) -> Synergies:
        """The same with signals at all samples."""
        return Synergies(self.weights, knots.sampled(self.values), self.start, self.explained, source)


def share(
    arm: Arm,
    motions: ArmMotions,
    activation: Floats,
    weights: Floats,
    knots: Knots,
    unknowns: Floats,
    training: Sequence[int],
) -> SharedSynergies:
    """Fit synergies to the motions `training`, and signals of them to all motions.

    Args:
        activation: (n, T, M). weights: (M, N) to start from. unknowns: (P,) parameters of the muscles.
    """
    problem = _Problem(arm, motions, activation, knots, unknowns)
    used = list(training)
    for _ in range(ROUNDS):
        weights = problem.weights(problem.signals(weights, used), used)
        weights = weights / np.maximum(weights.max(axis=0), 1e-12)
    signals = problem.signals(weights, range(len(motions)))
    explained, torque_r2 = problem.account(weights, signals)
    return SharedSynergies(weights, signals[:, :, :-1], signals[:, :, -1], explained, torque_r2)


class _Problem:
    """Torques of motions by unit activation of each muscle, and how knots become activations."""

    def __init__(self, arm: Arm, motions: ArmMotions, activation: Floats, knots: Knots, unknowns: Floats) -> None:
        count, samples = motions.pitch[0].shape
        table = arm.muscle_table(unknowns[None])
        angle, speed = (motions.angles[order].reshape(count * samples, -1) for order in (0, 1))
        passive, full = (table.torques(level, angle, speed)[0][..., arm.free] for level in (0.0, 1.0))
        needed = needed_torques(arm, motions)[:, :, arm.free].reshape(count * samples, -1) - passive.sum(axis=1)
        inside = motions.valid.reshape(-1) > 0.0
        self._scale = np.maximum(needed[inside].std(axis=0), 1e-6)
        shape = (count, samples)
        rows = slice(0, samples, STRIDE)
        self._gain = ((full - passive) / self._scale).transpose(0, 2, 1).reshape(*shape, len(arm.free), -1)[:, rows]
        self._needed = (needed / self._scale).reshape(*shape, -1)[:, rows]
        self._activation, self._inside = activation[:, rows], motions.valid[:, rows]
        self._basis = activation_basis(knots, time_constants(arm)[0], samples)[rows]
        second = np.zeros((len(knots) - 2, len(knots) + 1))
        second[:, :-1] = np.diff(np.eye(len(knots)), 2, axis=0)
        self._smooth = ROUGH * len(self._basis) * second.T @ second

    def signals(self, weights: Floats, which: Sequence[int]) -> Floats:
        """Signals (n, N, K + 1) at the knots and the start of some motions, given W (M, N)."""
        return np.array([self._signals_of(weights, number) for number in which])

    def _signals_of(self, weights: Floats, number: int) -> Floats:
        inside, basis, count = self._inside[number], self._basis, weights.shape[1]
        gain = (self._gain[number] @ weights) * inside[:, None, None]
        design = (gain[:, :, :, None] * basis[:, None, None, :]).reshape(-1, count * basis.shape[1])
        target = (self._needed[number] * inside[:, None]).ravel()
        counted = basis * inside[:, None]
        normal = design.T @ design + PRICE * np.kron(weights.T @ weights, counted.T @ counted)
        normal += np.kron(np.eye(count), self._smooth)
        wanted = weights.T @ (self._activation[number] * inside[:, None]).T @ counted
        found = _not_negative(normal, design.T @ target + PRICE * wanted.ravel())
        return np.asarray(np.minimum(found, 1.0).reshape(count, -1))

    def weights(self, signals: Floats, which: Sequence[int]) -> Floats:
        """W (M, N) given signals (n, N, K + 1) of some motions."""
        muscles, count = self._gain.shape[3], signals.shape[1]
        normal, right = np.zeros((muscles * count, muscles * count)), np.zeros(muscles * count)
        for number, individual in zip(which, signals, strict=True):
            inside = self._inside[number]
            active = (self._basis @ individual.T) * inside[:, None]
            design = (self._gain[number][:, :, :, None] * active[:, None, None, :]).reshape(-1, muscles * count)
            normal += design.T @ design + PRICE * np.kron(np.eye(muscles), active.T @ active)
            right += design.T @ (self._needed[number] * inside[:, None]).ravel()
            right += PRICE * (self._activation[number].T @ active).ravel()
        return _not_negative(normal, right).reshape(muscles, count)

    def account(self, weights: Floats, signals: Floats) -> tuple[float, Floats]:
        """Variance of the activations that is accounted for, and r2 (J,) of the torques."""
        inside = self._inside[:, :, None]
        active = np.minimum(np.einsum("tk,ink,mn->itm", self._basis, signals, weights), 1.0)
        rest = (active - self._activation) * inside
        explained = 1.0 - float(np.sum(rest**2) / np.sum((self._activation * inside) ** 2))
        error = (np.einsum("itjm,itm->itj", self._gain, active) - self._needed) * inside
        mean = np.sum(self._needed * inside, axis=(0, 1)) / np.sum(inside)
        spread = np.sum((self._needed - mean) ** 2 * inside, axis=(0, 1))
        return explained, np.asarray(1.0 - np.sum(error**2, axis=(0, 1)) / spread)


def activation_basis(knots: Knots, lag: float, samples: int) -> Floats:
    """Activations (T, K + 1) by a signal of 1 at each knot, and by a start at 1: a first-order lag, s.

    Rise and fall are taken to last as long, as in eq. 11 of Cruz Ruiz 2015; excitations step from sample to sample.
    """
    gain = 1.0 - np.exp(-1.0 / (RATE * max(lag, 1e-6)))
    basis = np.zeros((samples, len(knots) + 1))
    basis[0, -1] = 1.0
    for k in range(1, samples):
        basis[k] = (1.0 - gain) * basis[k - 1]
        basis[k, :-1] += gain * knots.hats[k - 1]
    return basis


def _not_negative(normal: Floats, right: Floats) -> Floats:
    """x >= 0 of least x^T normal x / 2 - right^T x."""
    matrix = normal + TIE * np.trace(normal) / len(normal) * np.eye(len(normal))
    upper = np.linalg.cholesky(matrix).T
    return np.asarray(nnls(upper, np.linalg.solve(upper.T, right), maxiter=NNLS_STEPS * len(right))[0])
