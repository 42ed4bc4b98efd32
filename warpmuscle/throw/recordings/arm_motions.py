"""Motions that an arm is fitted to: whether it can make them, and what is worth knowing of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError, SignalError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import few_of, number_of
from warpmuscle.core.pose import twist_angle
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.studies.poses import prescribed_coordinates
from warpmuscle.throw.arm import X_AXIS, Arm, joint_positions
from warpmuscle.throw.motion import PITCH, PLACE, RATE, ArmMotion, without_stillness
from warpmuscle.throw.recordings.motion_files import TO_GRAVITY, read
from warpmuscle.throw.recordings.smoothing import NOISY, noise, removed

LEAST_RANGE = np.radians(3.0)  # of the angle of a joint that muscles move
LATE = 1e-6  # of a sample, by which the last one may miss the end of a scene
BEYOND = np.radians(1.0)  # by which a recorded angle may exceed a joint's limits
CONVENTIONS = (
    ("its negative", -1.0, 0.0), ("180 deg less it", -1.0, 180.0), ("90 deg more", 1.0, 90.0),
    ("90 deg less", 1.0, -90.0), ("180 deg more", 1.0, 180.0),
)  # fmt: skip


def read_motions(paths: Sequence[str | Path], arm: Arm) -> list[ArmMotion]:
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


def motion_of(scene: Scene, arm: Arm) -> ArmMotion:
    """The motion of a scene whose joints are all kinematic.

    Raises:
        SceneError: a joint that the arm's muscles move has no motion in it.
    """
    for name in arm.joints:
        if name not in scene.motion or not _complete(scene, name):
            raise SceneError(f"{scene.name} has no motion of {name!r}; name files with motions", key="motion")
    actuation = arm.actuation(dict.fromkeys(arm.joints, "kinematic"))
    time = np.arange(int(first_number(arm.plain.duration) * RATE + LATE) + 1) / RATE
    coordinates = prescribed_coordinates(msgspec.structs.replace(scene, actuation=actuation), time)
    root = root_type(scene.character)
    pitch = np.unwrap(twist_angle(root.motion(coordinates).orientation, X_AXIS)) if root.speeds else np.zeros(len(time))
    place = joint_positions(arm, coordinates)[0][:, [2, 1]]
    return ArmMotion(scene.name, 0.0, time, coordinates[:, arm.coordinate_places], pitch, place - place[0])


def _complete(scene: Scene, name: str) -> bool:
    """Whether the motion of a joint is one of all its angles, not of those alone beside what muscles move."""
    count, value = len(joint_type(scene.character.joints[name]).speeds), scene.motion[name].value
    return count == 1 or not value or len(value) == count


def notes(
    read: Sequence[ArmMotion], passed: Sequence[ArmMotion], arm: Arm, low_pass: float | None, chosen: bool = False
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


def _of(names: Sequence[str], motions: Sequence[ArmMotion]) -> str:
    """Which of some motions are meant."""
    if len(names) == 1 or len(names) < len(motions):
        return few_of(names, 3)
    return f"all {number_of(len(motions), 'motion')}"


def _rms(values: Floats) -> Floats:
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))


def check_limits(arm: Arm, motion: ArmMotion) -> None:
    """SignalError if a recorded angle is beyond the limits of its joint."""
    plain = arm.plain
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


def check_range(arm: Arm, motion: ArmMotion) -> None:
    """SignalError if a joint that muscles are to move stands still: there is nothing to tell its muscles by."""
    for column, name in zip(arm.free, arm.driven, strict=True):
        extent = float(np.ptp(motion.angles[:, column]))
        if extent < LEAST_RANGE:
            raise SignalError(
                f"motion {motion.name}: {name} moves by no more than {np.degrees(extent):.2g} deg, too little to fit "
                f"muscles to; are its angles in radians? If it stands still, give it to --prescribe {name}"
            )


def mean_motion(motions: Sequence[ArmMotion]) -> ArmMotion:
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

    return ArmMotion("mean", first.start, time, mean("angles"), mean("pitch")[:, 0], mean("place"))
