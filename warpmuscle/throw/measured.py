"""Measured EMG in place of computed signals: synergies from a file, and calibration of channels and muscles.

Nobody knows what of an envelope is full activation, nor how late it comes. So gains and delays of the channels are
calibrated together with the muscles (f_max, l_slack and whatever of the arm is free), to the torques that recorded
motions need (Lloyd and Besier 2003, Pizzolato 2015): along each motion muscles under the delayed and scaled envelopes
make these torques in least squares. What muscles do against each other changes no torque, so a small price on their
activations squared, the effort, decides on it; gains near 1, delays alike and muscles as they were are preferred.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.files import SynergyResult
from warpmuscle.synergy.files import read as read_synergies
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.equation_error import HINGE, SPARE, STRIDE, shortfall
from warpmuscle.throw.motion import ArmMotion, ArmMotions, resample
from warpmuscle.throw.signals import Synergies, to_activation

COVERED = 0.9  # part of a motion that samples must cover
GAIN = 8.0  # a channel's gain is at most this, and at least its inverse
EARLIEST, LATEST = -0.05, 0.15  # s, delays; one below 0 says that envelope or activation dynamics lag too much
EFFORT = 0.05  # price of the mean square activation, against a torque's squared error in parts of its deviation
PRIOR = 0.02  # of a squared change of a parameter by its interval, of a gain by 8, of a delay by LATE from the others
COMMON = 1e-3  # of their mean's by LATE: muscles are late alike, and nobody knows by how much
LATE = 0.05  # s
STARTS = (0.0, 0.04, 0.08, -0.04)  # s, of all delays: there are several minima, of which the deepest counts
STEP = 1e-3  # of difference quotients, in those parts


@dataclass(frozen=True)
class Calibration:
    """Channels and muscles that suit the torques of recorded motions.

    Attributes:
        muscles: (A,) names of those that act on a joint that muscles move.
        gain: (A,) of each one's envelope. delay: (A,) s, of its activation behind it.
        unknowns: (P,) parameters of the arm, see `Arm.unknowns`.
        excitation: (n, T, M) delayed and scaled envelopes. start: (n, M) the first of them.
        torque_r2: (2, J) of the torques of all motions before and after.
        effort: mean square activation before and after.
    """

    muscles: tuple[str, ...]
    gain: Floats
    delay: Floats
    unknowns: Floats
    excitation: Floats
    start: Floats
    torque_r2: Floats
    effort: tuple[float, float]


def measured_synergies(
    arm: Arm, recorded: Sequence[ArmMotion], path: str | Path, names: Mapping[str, str]
) -> Synergies:
    """Synergies from a file of `warpmuscle synergies extract`, of the muscles that the arm has.

    Args:
        recorded: n motions as they were read; trial k of the file goes with the k-th.
        names: channel of the file for a muscle of the arm; others go by their own name, letter case aside.

    Raises:
        Error: the file cannot be used, has no channel for a muscle that moves a joint, or no samples for a motion.
    """
    result = read_synergies(path)
    weights = np.zeros((len(arm.muscles), result.synergies.weights.shape[1]))
    weights[arm.acting] = result.synergies.weights[_channels(arm, result, path, names)]
    motions = resample(recorded)
    signals = _along(motions, recorded, result, result.synergies.coefficients.T, path)
    # Where a synergy's greatest weight is a muscle that the arm lacks, what is left of it is brought back to 1.
    scale = np.maximum(weights.max(axis=0), 1e-12)
    signals = np.clip(signals * scale * motions.valid[:, :, None], 0.0, 1.0)
    return Synergies(weights / scale, signals, signals[:, 0], result.synergies.account.vaf, str(path))


def measured_envelopes(arm: Arm, recorded: Sequence[ArmMotion], path: str | Path, names: Mapping[str, str]) -> Floats:
    """Envelopes (n, T, M) of the muscles that act, from the same file; see `measured_synergies`."""
    result = read_synergies(path)
    motions = resample(recorded)
    channels = _along(motions, recorded, result, result.activations.values, path)
    found = np.zeros((*motions.valid.shape, len(arm.muscles)))
    found[:, :, arm.acting] = channels[:, :, _channels(arm, result, path, names)]
    return np.maximum(found, 0.0)


def _channels(arm: Arm, result: SynergyResult, path: str | Path, names: Mapping[str, str]) -> list[int]:
    """Places (A,) of the channels of the muscles that act."""
    channels = {name.lower(): k for k, name in enumerate(result.activations.muscles)}
    unknown = [name for name in names if name not in arm.muscles]
    if unknown:
        raise Error(f"the arm has no muscle {unknown[0]!r}; it has {', '.join(arm.muscles)}")
    found = []
    for muscle in (arm.muscles[row] for row in arm.acting):
        channel = names.get(muscle, muscle).lower()
        if channel not in channels:
            raise SignalError(
                f"no channel for muscle {muscle!r}; say `--channel {muscle}=NAME` with one of "
                f"{', '.join(result.activations.muscles)}", file=path,
            )  # fmt: skip
        found.append(channels[channel])
    return found


def _along(
    motions: ArmMotions, recorded: Sequence[ArmMotion], result: SynergyResult, values: Floats, path: str | Path
) -> Floats:
    """Values (S, k) of the file's samples at the times of n motions, (n, T, k)."""
    trials = np.unique(result.activations.trial)
    if len(trials) != len(recorded):
        raise SignalError(
            f"{number_of(len(trials), 'trial', 'do')} not go with {number_of(len(recorded), 'motion')}", file=path
        )
    found = np.zeros((*motions.valid.shape, values.shape[1]))
    for row, (trial, motion) in enumerate(zip(trials, recorded, strict=True)):
        individual = result.activations.trial == trial
        time = result.activations.time[individual] - motion.start
        covered = min(time[-1], motion.time[-1]) - max(time[0], 0.0)
        if covered < COVERED * motion.time[-1]:
            raise SignalError(
                f"its samples from {time[0] + motion.start:g} to {time[-1] + motion.start:g} s do not cover motion "
                f"{motion.name}, {motion.start:g} to {motion.start + motion.time[-1]:g} s", file=path,
            )  # fmt: skip
        for k in range(values.shape[1]):
            found[row, :, k] = np.interp(motions.time, time, values[individual, k])
    return found


def calibrate(arm: Arm, motions: ArmMotions, envelope: Floats, start: Floats, training: Sequence[int]) -> Calibration:
    """Gains and delays of channels and parameters of muscles, for the torques of the motions `training`.

    Args:
        envelope: (n, T, M). start: (P,) parameters to start from.
    """
    problem = _Problem(arm, motions.rows(training), envelope[list(training)], start)
    count, muscles = len(start), len(arm.acting)
    tries = []
    for late in STARTS:
        x = problem.first.copy()
        x[count + muscles :] = late / LATE
        tries.append(
            least_squares(problem.residuals, x, problem.jacobian, problem.bounds, max_nfev=100, ftol=1e-6, xtol=1e-6)
        )
    found = min(tries, key=lambda one: float(one.cost))
    gain, delay = GAIN ** found.x[count : count + muscles], LATE * found.x[count + muscles :]
    excitation = driven(motions, envelope, arm.acting, gain[None], delay[None])[0]
    r2, effort = zip(*(problem.account(values) for values in (problem.first, found.x)), strict=True)
    return Calibration(
        tuple(arm.muscles[k] for k in arm.acting), gain, delay, found.x[:count], excitation, excitation[:, 0],
        np.array(r2), (effort[0], effort[1]),
    )  # fmt: skip


def driven(motions: ArmMotions, envelope: Floats, acting: Sequence[int], gain: Floats, delay: Floats) -> Floats:
    """Excitations (Z, n, T, M) of envelopes (n, T, M) under Z sets of gains and delays, s, of the acting muscles."""
    found = np.zeros((len(gain), *envelope.shape))
    for column, muscle in enumerate(acting):
        for row in range(len(envelope)):
            late = motions.time[None] - delay[:, column, None]
            found[:, row, :, muscle] = np.interp(late, motions.time, envelope[row, :, muscle])
        found[..., muscle] *= gain[:, column, None, None]
    return np.clip(found, 0.0, 1.0)


class _Problem:
    """Residuals (R,) by x: parameters (P,), logarithms of gains (A,), delays (A,) in their parts."""

    def __init__(self, arm: Arm, motions: ArmMotions, envelope: Floats, start: Floats) -> None:
        self._arm, self._motions, self._envelope, self._start = arm, motions, envelope, start
        self._counted = motions.valid > 0.0
        self._counted[:, np.arange(self._counted.shape[1]) % STRIDE != 0] = False
        self._angle, self._speed = (part[self._counted] for part in motions.angles[:2])
        self._needed = needed_torques(arm, motions)[self._counted][:, arm.free]
        self._scale = np.maximum(self._needed.std(axis=0), 1e-6)
        muscles = len(arm.acting)
        self.first = np.concatenate([np.clip(start, 1e-6, 1.0 - 1e-6), np.zeros(2 * muscles)])
        self.bounds = (
            np.concatenate([np.zeros(len(start)), -np.ones(muscles), np.full(muscles, EARLIEST / LATE)]),
            np.concatenate([np.ones(len(start)), np.ones(muscles), np.full(muscles, LATEST / LATE)]),
        )

    def residuals(self, x: Floats) -> Floats:
        return np.asarray(self._batch(x[None])[0])

    def jacobian(self, x: Floats) -> Floats:
        """(R, U) by differences, all at once."""
        step = np.where(x > 0.5 * (self.bounds[0] + self.bounds[1]), -STEP, STEP)
        values = self._batch(np.concatenate([x[None], x + np.diag(step)]))
        return np.asarray(((values[1:] - values[0]) / step[:, None]).T)

    def account(self, x: Floats) -> tuple[Floats, float]:
        """r2 (J,) of the torques, and the effort."""
        made, activation, _ = self._made(x[None])
        error = np.sum((made[0] - self._needed) ** 2, axis=0)
        spread = np.sum((self._needed - self._needed.mean(axis=0)) ** 2, axis=0)
        return np.asarray(1.0 - error / np.maximum(spread, 1e-12)), float(np.mean(activation[0] ** 2))

    def _made(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Torques (Z, S, J), activations (Z, S, A), and what torque is needed beyond the muscles' strength."""
        arm, count, muscles = self._arm, len(self._start), len(self._arm.acting)
        gain, delay = GAIN ** x[:, count : count + muscles], LATE * x[:, count + muscles :]
        excitation = driven(self._motions, self._envelope, arm.acting, gain, delay)
        shape = excitation.shape
        whole = to_activation(arm, excitation.reshape(-1, *shape[2:]), excitation[:, :, 0].reshape(-1, shape[3]))
        activation = whole.reshape(shape)[:, self._counted]
        table = arm.muscle_table(x[:, :count])
        made = table.torques(activation, self._angle, self._speed)[..., arm.free].sum(axis=-2)
        beyond = shortfall(table, self._angle, self._speed, self._needed, arm.free, SPARE)
        return made, activation[..., arm.acting], beyond

    def _batch(self, x: Floats) -> Floats:
        made, activation, beyond = self._made(x)
        rows = np.sqrt(len(self._needed))
        effort = np.sqrt(EFFORT / activation.shape[2]) * activation / rows
        parts = [(made - self._needed) / self._scale / rows, HINGE * beyond / self._scale / rows, effort]
        late = x[:, -activation.shape[2] :]
        common = late.mean(axis=1, keepdims=True)
        change = x - self.first
        change[:, -activation.shape[2] :] = late - common
        prior = np.concatenate([np.sqrt(PRIOR) * change, np.sqrt(COMMON) * common], axis=1)
        return np.concatenate([*(part.reshape(len(x), -1) for part in parts), prior], axis=1)
