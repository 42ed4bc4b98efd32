"""What is to be fitted: recorded motions or a scene's own, an arm, and synergies that are computed from the motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError, SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import twist_angle
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.synergy.factorization import factorize, reconstruct
from warpmuscle.synergy.static_optimization import StaticOptimization
from warpmuscle.throw.arm import X_AXIS, Arm, joint_positions, needed_torques
from warpmuscle.throw.motion import PITCH, PLACE, RATE, Motion, Motions, without_stillness
from warpmuscle.throw.motion_files import TO_GRAVITY, read
from warpmuscle.throw.signals import Synergies, computed_activation, to_excitation
from warpmuscle.throw.smoothing import NOISY, noise, removed

LEAST_RANGE = np.radians(3.0)  # of the angle of a joint that muscles move
BEYOND = np.radians(1.0)  # by which a recorded angle may exceed a joint's limits
CONVENTIONS = (
    ("its negative", -1.0, 0.0), ("180 deg less it", -1.0, 180.0), ("90 deg more", 1.0, 90.0),
    ("90 deg less", 1.0, -90.0), ("180 deg more", 1.0, 180.0),
)  # fmt: skip
SPIKE = 0.01  # part of the frames in which muscles may fall short without a word: noise of twice differentiated angles
COMPUTED = "computed"
ALONE = 2  # muscles a joint, up to which none shares its work with others
HOPELESS = 1.5  # times what muscles make, beyond which it is not their strength alone that an arm lacks
PURE = 0.05  # most of other muscles' weights, in parts of its own, in a synergy that is one muscle alone


@dataclass(frozen=True)
class Lack:
    """What the muscles lack for a motion."""

    motion: str
    explanation: str  # of `StaticOptimization.explanation`
    frames: float  # part of the frames in which they do not suffice
    joint: str  # where most is missing, in parts of what it needs, and when
    time: float  # s
    needed: float  # N m
    missing: float  # N m
    least: float  # N m that the muscles make there at least, by passive forces too, and at most
    most: float
    others: tuple[str, ...] = ()  # joints that need torque at the same time, where this one's could be had alone

    @property
    def bound(self) -> float:
        """N m, of those that the muscles make the nearest to what is needed."""
        return float(np.clip(self.needed, self.least, self.most))

    @property
    def weak(self) -> bool:
        """Whether the muscles pull the right way, but not enough; else their passive forces pull too much."""
        return not self.others and self.needed * self.bound >= 0.0 and abs(self.needed) > abs(self.bound)

    @property
    def made(self) -> str:
        """What the muscles make there."""
        if self.others:
            others = " and ".join(name.replace("_", " ") for name in self.others)
            return f"which they do not make together with the torques of {others}"
        if self.weak:
            return f"and they make at most {self.bound:.3g}"
        if self.needed * self.bound >= 0.0:
            return f"and stretched as they are they make at least {self.bound:.3g}"
        return f"and stretched as they are they make {self.bound:.3g} or more the other way"


def read_motions(paths: Sequence[str | Path], arm: Arm) -> list[Motion]:
    """The motions in files, checked against the limits of the arm's joints.

    Raises:
        SignalError: a file cannot be used, a motion goes beyond a joint's limits, or a joint that muscles are to move
            stands still.
    """
    motions = [without_stillness(motion) for path in paths for motion in read(path, arm.joints)]
    if not motions:
        raise SignalError("there are no motions")
    for motion in motions:
        check_limits(arm, motion)
        check_range(arm, motion)
    return motions


def motion_of(scene: Scene, arm: Arm) -> Motion:
    """The motion of a scene whose joints are all kinematic.

    Raises:
        SceneError: a joint that the arm's muscles move has no motion in it.
    """
    for name in arm.joints:
        if name not in scene.motion or not _whole(scene, name):
            raise SceneError(f"{scene.name} has no motion of {name!r}; name files with motions", key="motion")
    actuation = arm.actuation(dict.fromkeys(arm.joints, "kinematic"))
    rollout = Rollout(
        msgspec.structs.replace(scene, actuation=actuation), 1, "cpu", record=[0], record_rate=RATE,
        quantities=["coordinates", "speeds"],
    )  # fmt: skip
    rollout.run()
    coordinates = np.concatenate([rollout.recorded("coordinates")[0], rollout.state.coordinates.numpy()]).astype(float)
    time = np.arange(len(coordinates)) / RATE
    root = root_type(scene.character)
    pitch = np.unwrap(twist_angle(root.motion(coordinates).orientation, X_AXIS)) if root.speeds else np.zeros(len(time))
    place = joint_positions(arm, coordinates)[0][:, [2, 1]]
    return Motion(scene.name, 0.0, time, coordinates[:, arm.coordinate_places], pitch, place - place[0])


def _whole(scene: Scene, name: str) -> bool:
    """Whether the motion of a joint is one of all its angles, not of those alone beside what muscles move."""
    count, value = len(joint_type(scene.character.joints[name]).speeds), scene.motion[name].value
    return count == 1 or not value or len(value) == count


def notes(
    read: Sequence[Motion], passed: Sequence[Motion], arm: Arm, low_pass: float | None, chosen: bool = False
) -> list[str]:
    """What is worth knowing of motions: what a filter took from them, noise, and what their files do not say.

    Args:
        read: before, passed: after the filter, see `smoothing.usable`.
    """
    found = []
    if low_pass is not None:
        parts = np.degrees([removed(before, after) for before, after in zip(read, passed, strict=True)])
        taken = ", ".join(f"{value:.2g} deg of {name}" for name, value in zip(arm.joints, _rms(parts), strict=True))
        why = " (chosen by residual analysis, as accelerations are lost in noise; --low-pass 0 for none)"
        found.append(
            f"low-pass at {low_pass:.3g} Hz{why if chosen else ''}, second order, forwards and backwards, took {taken} "
            "(rms)"
        )
    noisy = [motion.name for motion in passed if max(noise(motion), default=0.0) > NOISY]
    if noisy:
        found.append(
            f"{_of(noisy, passed)}: a good part of the acceleration is noise, which the computed signals have in "
            "them; --low-pass takes it away"
        )
    gaps = [motion.name for motion in read if motion.bridged]
    if gaps:
        count = sum(motion.bridged for motion in read)
        found.append(
            f"{_of(gaps, read)}: interpolated by cubic splines: {number_of(count, 'missing value')} in short gaps"
        )
    still = [motion.name for motion in read if motion.cut > 0.0]
    if still:
        longest = max(motion.cut for motion in read)
        found.append(f"{_of(still, read)}: up to {longest:.2g} s at the ends, in which nothing moves, were left out")
    absent = {name: [motion.name for motion in read if name in motion.absent] for name in (PITCH, *PLACE)}
    if absent[PITCH]:
        found.append(
            f"{_of(absent[PITCH], read)}: no {PITCH}_deg or {TO_GRAVITY}_deg, so the trunk is taken to stand upright "
            "and gravity pulls at a false angle where it leans"
        )
    unknown = [name for name in PLACE if absent[name]]
    if unknown:
        columns = " and ".join(f"{name}_m" for name in unknown)
        found.append(
            f"{_of(absent[unknown[0]], read)}: no {columns}, so the shoulder is taken to stand still and what its "
            "acceleration asks of the muscles is missing"
        )
    return found


def _of(names: Sequence[str], motions: Sequence[Motion]) -> str:
    """Which of some motions are meant."""
    if len(names) == 1 or len(names) < len(motions):
        return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    return f"all {number_of(len(motions), 'motion')}"


def _rms(values: Floats) -> Floats:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))


def check_limits(arm: Arm, motion: Motion) -> None:
    """SignalError if a recorded angle is beyond the limits of its joint."""
    plain = substitute(arm.scene, start_values(arm.scene))
    for column, name in enumerate(arm.joints):
        limits = plain.character.joints[name].limits
        if not limits:
            continue
        low, high = (float(end) for end in limits[arm.axes[name]])  # type: ignore[arg-type]
        angle = motion.angles[:, column]
        frame = int(np.argmax(np.maximum(angle - high, low - angle)))
        if angle[frame] > high + BEYOND or angle[frame] < low - BEYOND:
            raise SignalError(
                f"motion {motion.name}: {name} is at {np.degrees(angle[frame]):.1f} deg after "
                f"{motion.time[frame]:.3g} s, beyond its limits of {np.degrees(low):.0f} and {np.degrees(high):.0f} deg"
                f"{_other_conventions(angle, low - BEYOND, high + BEYOND)}"
            )


def _other_conventions(angle: Floats, low: float, high: float) -> str:
    """Which usual ways of counting an angle would bring it within its limits, as the end of an error."""
    found = [
        what for what, sign, zero in CONVENTIONS
        if low <= (counted := sign * angle + np.radians(zero)).min() and counted.max() <= high
    ]  # fmt: skip
    return f"; is 0 deg a straight arm that hangs down? Within them would be {' or '.join(found)}" if found else ""


def check_range(arm: Arm, motion: Motion) -> None:
    """SignalError if a joint that muscles are to move stands still: there is nothing to tell its muscles by."""
    for column, name in zip(arm.free, arm.driven, strict=True):
        extent = float(np.ptp(motion.angles[:, column]))
        if extent < LEAST_RANGE:
            raise SignalError(
                f"motion {motion.name}: {name} moves by no more than {np.degrees(extent):.2g} deg, too little to fit "
                f"muscles to; are its angles in radians? If it stands still, give it to --prescribe {name}"
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
    activation, excitation, found = computed_excitation(strong, motions)
    lacks = lacking(strong, motions, found, strong.unknowns(start_values(strong.scene)))
    acting = arm.acting
    if count > len(acting):
        raise Error(
            f"{number_of(count, 'synergy')} are more than the {number_of(len(acting), 'muscle')} that move "
            f"{', '.join(arm.driven)}"
        )
    return factorized(arm, motions, excitation, activation[:, 0], count, COMPUTED, seed), lacks


def computed_excitation(strong: Arm, motions: Motions) -> tuple[Floats, Floats, StaticOptimization]:
    """Activations and excitations (n, T, M) by static optimisation."""
    activation, found = computed_activation(strong, motions, strong.unknowns(start_values(strong.scene)))
    return activation, to_excitation(strong, activation), found


def factorized(
    arm: Arm, motions: Motions, excitation: Floats, start: Floats, count: int, source: str, seed: int = 0
) -> Synergies:
    """Synergies of excitations (n, T, M) of the muscles that act, whose activations start at (n, M)."""
    acting, inside = arm.acting, motions.valid > 0.0
    given = excitation[:, :, acting][inside]
    scale = torque_scale(arm, motions)
    sparse = sparsest(factorize(given * scale, count, seed=seed).weights / scale[:, None])
    sparse /= sparse.max(axis=0)
    coefficients = reconstruct(given * scale, sparse * scale[:, None])
    weights = np.zeros((len(arm.muscles), count))
    weights[acting] = sparse
    signals = np.zeros((*motions.valid.shape, count))
    signals[inside] = coefficients.T
    first = reconstruct(start[:, acting] * scale, sparse * scale[:, None]).T
    explained = 1.0 - float(np.sum((given - (sparse @ coefficients).T) ** 2) / np.sum(given**2))
    return Synergies(weights, np.clip(signals, 0.0, 1.0), np.clip(first, 0.0, 1.0), explained, source)


def torque_scale(arm: Arm, motions: Motions) -> Floats:
    """What an excitation counts in the factorisation: (muscles that act,), 1 with up to two muscles a joint.

    Where more muscles share a joint, errors count by the torque that they make, in parts of what the joint needs: else
    synergies explain strong muscles well and leave the wrist, whose muscles hardly act, to chance.
    """
    if len(arm.acting) <= ALONE * len(arm.driven):
        return np.ones(len(arm.acting))
    inside = motions.valid > 0.0
    angle, speed = (part[inside] for part in motions.angles[:2])
    table = arm.muscle_table(arm.unknowns(start_values(arm.scene))[None])
    torque = table.torques(1.0, angle, speed)[0] - table.torques(0.0, angle, speed)[0]
    spread = needed_torques(arm, motions)[inside].std(axis=0)
    part = (torque / np.maximum(spread, 1e-6))[:, :, arm.free]
    scale = np.sqrt(np.mean(np.sum(part**2, axis=2), axis=0))[arm.acting]
    return np.asarray(scale / scale.max())


def sparsest(weights: Floats) -> Floats:
    """Weights (M, N) without those that other synergies can take over.

    Where a synergy is one muscle alone, what other synergies hold of that muscle can as well be in its own signal: all
    such factorisations account for the same. Only the one with the fewest ties leaves signals free to change alone.
    """
    weights = weights.copy()
    main = weights.argmax(axis=0)
    for k, muscle in enumerate(main):
        others = np.arange(weights.shape[1]) != k
        if np.sum(weights[:, k]) - weights[muscle, k] <= PURE * weights[muscle, k]:
            weights[muscle, others & (main != muscle)] = 0.0
    return weights


def lacking(arm: Arm, motions: Motions, found: StaticOptimization, unknowns: Floats) -> list[Lack]:
    """Motions for which the muscles do not suffice in more than a spike.

    Args:
        found: what `computed_activation` found with the parameters `unknowns` (P,).
    """
    samples = len(motions.time)
    lacks = []
    for row in range(len(motions)):
        part = slice(row * samples, (row + 1) * samples)
        own = StaticOptimization(
            found.activation[part], found.needed[part], found.torque_error[part], found.unreachable[part],
            found.feasible[part],
        )  # fmt: skip
        missing = float((~own.feasible).sum() / motions.valid[row].sum())
        if missing > SPIKE:
            text = own.explanation(arm.muscles, arm.driven, motions.time)
            lacks.append(_worst(arm, motions, row, own.torque_error, unknowns, text, missing))
    return lacks


def _worst(arm: Arm, motions: Motions, row: int, error: Floats, unknowns: Floats, text: str, frames: float) -> Lack:
    """The joint and the time where most of what a motion needs of a joint is missing."""
    needed = needed_torques(arm, motions.rows([row]))[0][:, arm.free]
    part = np.abs(error) / np.maximum(np.abs(needed).max(axis=0), 1e-9)
    frame, joint = (int(k) for k in np.unravel_index(part.argmax(), part.shape))
    table = arm.muscle_table(unknowns[None])
    angle, speed = (motions.angles[order][row, frame : frame + 1] for order in (0, 1))
    passive, full = (table.torques(level, angle, speed)[0, 0][:, arm.free] for level in (0.0, 1.0))
    least, most = (passive + bound(full - passive, 0.0) for bound in (np.minimum, np.maximum))
    low, high, at = float(least.sum(axis=0)[joint]), float(most.sum(axis=0)[joint]), float(needed[frame, joint])
    others = tuple(name for k, name in enumerate(arm.driven) if k != joint) if low <= at <= high else ()
    return Lack(
        motions.names[row], text, frames, arm.driven[joint], float(motions.time[frame]), at,
        float(abs(error[frame, joint])), low, high, others,
    )  # fmt: skip


def shortcoming(arm: Arm, lacks: Sequence[Lack], count: int, whose: str) -> str:
    """One sentence about what an arm lacks for some of `count` motions; empty if nothing.

    Args:
        whose: what the muscles are called.
    """
    if not lacks:
        return ""
    worst = max(lacks, key=lambda lack: lack.missing / max(abs(lack.needed), 1e-9))
    which = worst.motion if count == 1 else f"{len(lacks)} of {number_of(count, 'motion')}"
    text = (
        f"{whose} cannot make {which}: the {worst.joint.replace('_', ' ')} needs {worst.needed:.3g} N m"
        f"{f' in {worst.motion}' if count > 1 else ''} at {worst.time:.2f} s, {worst.made}"
    )
    turning = any("rotation" in name for name in arm.joints)
    if not turning and worst.weak and abs(worst.needed) > HOPELESS * max(abs(worst.bound), 1e-9):
        text += (
            "; pitches and serves get their speed from turning trunk, upper arm and forearm about themselves, which "
            f"an arm of {', '.join(arm.driven)} does not do"
        )
    return text
