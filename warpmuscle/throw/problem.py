"""What is to be fitted: recorded motions, an arm, and synergies that were measured or are computed from the motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.arrays import Floats
from warpmuscle.errors import Error, SignalError
from warpmuscle.parameters import start_values, substitute
from warpmuscle.synergy.factorization import factorize
from warpmuscle.synergy.files import read as read_synergies
from warpmuscle.synergy.static_optimization import StaticOptimization
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.motion import Motion, Motions, read, resample
from warpmuscle.throw.signals import Synergies, computed_activation, to_excitation

BEYOND = np.radians(1.0)  # by which a recorded angle may exceed a joint's limits
SPIKE = 0.01  # part of the frames in which muscles may fall short without a word: noise of twice differentiated angles
COMPUTED = "computed"


@dataclass(frozen=True)
class Lack:
    """What the muscles lack for a motion."""

    motion: str
    explanation: str  # of `StaticOptimization.explanation`
    frames: float  # part of the frames in which they do not suffice


def read_motions(paths: Sequence[str | Path], arm: Arm) -> list[Motion]:
    """The motions in files, checked against the limits of the arm's joints.

    Raises:
        SignalError: a file cannot be used, or a motion goes beyond a joint's limits.
    """
    motions = [motion for path in paths for motion in read(path, arm.joints)]
    if not motions:
        raise SignalError("there are no motions")
    for motion in motions:
        check_limits(arm, motion)
    return motions


def check_limits(arm: Arm, motion: Motion) -> None:
    """SignalError if a recorded angle is beyond the limits of its joint."""
    plain = substitute(arm.scene, start_values(arm.scene))
    for column, name in enumerate(arm.joints):
        limits = plain.character.joints[name].limits
        if not limits:
            continue
        low, high = (float(end) for end in limits[0])  # type: ignore[arg-type]
        angle = motion.angles[:, column]
        frame = int(np.argmax(np.maximum(angle - high, low - angle)))
        if angle[frame] > high + BEYOND or angle[frame] < low - BEYOND:
            raise SignalError(
                f"motion {motion.name}: {name} is at {np.degrees(angle[frame]):.1f} deg after "
                f"{motion.time[frame]:.3g} s, beyond its limits of {np.degrees(low):.0f} and {np.degrees(high):.0f} deg"
            )


def mean_motion(motions: Sequence[Motion]) -> Motion:
    """The mean of motions, sampled as the first one, over the time that all of them have."""
    first = motions[0]
    time = first.time[first.time <= min(motion.time[-1] for motion in motions) + 1e-9]

    def mean(name: str) -> Floats:
        parts = []
        for motion in motions:
            values = getattr(motion, name).reshape(len(motion.time), -1)
            columns = [np.interp(time, motion.time, column) for column in (values - (name == "place") * values[0]).T]
            parts.append(np.stack(columns, axis=1))
        return np.asarray(np.mean(parts, axis=0))

    return Motion("mean", first.start, time, mean("angles"), mean("pitch")[:, 0], mean("place"))


def computed_synergies(
    arm: Arm, motions: Motions, strong: Arm, count: int, seed: int = 0
) -> tuple[Synergies, list[Lack]]:
    """Synergies of computed excitations, and what the muscles that these were computed with lack.

    Args:
        strong: the same arm with the muscles that activations are computed with; not those that the fit starts from.
        count: N.
    """
    excitation, found = computed_excitation(strong, motions)
    lacks = lacking(strong, motions, found)
    acting = arm.acting
    if count > len(acting):
        raise Error(f"{count} synergies are more than the {len(acting)} muscles that move {', '.join(arm.driven)}")
    return factorized(arm, motions, excitation, count, COMPUTED, seed), lacks


def computed_excitation(strong: Arm, motions: Motions) -> tuple[Floats, StaticOptimization]:
    """Excitations (n, T, M) by static optimisation."""
    activation, found = computed_activation(strong, motions, strong.unknowns(start_values(strong.scene)))
    return to_excitation(strong, activation), found


def factorized(arm: Arm, motions: Motions, excitation: Floats, count: int, source: str, seed: int = 0) -> Synergies:
    """Synergies of excitations (n, T, M) of the muscles that act."""
    acting, inside = arm.acting, motions.valid > 0.0
    found = factorize(excitation[:, :, acting][inside], count, seed=seed)
    weights = np.zeros((len(arm.muscles), count))
    weights[acting] = found.weights
    signals = np.zeros((*motions.valid.shape, count))
    signals[inside] = found.coefficients.T
    return Synergies(weights, np.clip(signals, 0.0, 1.0), found.account.vaf, source)


def lacking(arm: Arm, motions: Motions, found: StaticOptimization) -> list[Lack]:
    """Motions for which the muscles do not suffice in more than a spike."""
    samples = len(motions.time)
    lacks = []
    for row, name in enumerate(motions.names):
        part = slice(row * samples, (row + 1) * samples)
        own = StaticOptimization(
            found.activation[part], found.needed[part], found.torque_error[part], found.unreachable[part],
            found.feasible[part],
        )  # fmt: skip
        missing = float((~own.feasible).sum() / motions.valid[row].sum())
        if missing > SPIKE:
            text = own.explanation(arm.muscles, arm.driven, motions.time)
            lacks.append(Lack(name, text, missing))
    return lacks


def measured_synergies(arm: Arm, recorded: Sequence[Motion], path: str | Path, names: Mapping[str, str]) -> Synergies:
    """Synergies from a file of `warpmuscle synergies`, of the muscles that the arm has.

    Args:
        recorded: n motions as they were read; trial k of the file goes with the k-th.
        names: channel of the file for a muscle of the arm; others go by their own name, letter case aside.

    Raises:
        Error: the file cannot be used, has no channel for a muscle that moves a joint, or no samples for a motion.
    """
    result = read_synergies(path)
    channels = {name.lower(): k for k, name in enumerate(result.activations.muscles)}
    unknown = [name for name in names if name not in arm.muscles]
    if unknown:
        raise Error(f"the arm has no muscle {unknown[0]!r}; it has {', '.join(arm.muscles)}")
    weights = np.zeros((len(arm.muscles), result.synergies.weights.shape[1]))
    for row in arm.acting:
        muscle = arm.muscles[row]
        channel = names.get(muscle, muscle)
        if channel.lower() not in channels:
            raise SignalError(
                f"no channel for muscle {muscle!r}; say `--channel {muscle}=NAME` with one of "
                f"{', '.join(result.activations.muscles)}", file=path,
            )  # fmt: skip
        weights[row] = result.synergies.weights[channels[channel.lower()]]
    motions = resample(recorded)
    signals = np.zeros((*motions.valid.shape, weights.shape[1]))
    trials = np.unique(result.activations.trial)
    if len(trials) != len(recorded):
        raise SignalError(f"{len(trials)} trials do not go with {len(recorded)} motions", file=path)
    for row, (trial, motion) in enumerate(zip(trials, recorded, strict=True)):
        own = result.activations.trial == trial
        time = result.activations.time[own] - motion.start
        covered = min(time[-1], motion.time[-1]) - max(time[0], 0.0)
        if covered < 0.9 * motion.time[-1]:
            raise SignalError(
                f"its samples from {time[0] + motion.start:g} to {time[-1] + motion.start:g} s do not cover motion "
                f"{motion.name}, {motion.start:g} to {motion.start + motion.time[-1]:g} s", file=path,
            )  # fmt: skip
        for k in range(weights.shape[1]):
            signals[row, :, k] = np.interp(motions.time, time, result.synergies.coefficients[k, own])
    # Where a synergy's greatest weight is a muscle that the arm lacks, what is left of it is brought back to 1.
    scale = np.maximum(weights.max(axis=0), 1e-12)
    return Synergies(
        weights / scale, np.clip(signals * scale * motions.valid[:, :, None], 0.0, 1.0),
        result.synergies.account.vaf, str(path),
    )  # fmt: skip
