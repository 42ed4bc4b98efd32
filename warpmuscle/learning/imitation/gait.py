"""The gait that is imitated: of the scene's own controller over a cycle, perhaps with the angles of a norm.

Angles of a norm may change with the wanted speed, and so does the vertical force that people's feet carry.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.core.number_rows import first_row
from warpmuscle.core.pose import about, conjugate, multiply, normalized, rotate, twist_angle
from warpmuscle.gait.cycles import PERCENT, body_weight, over_strides
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.likeness import dimensionless_speed, leg_length, trend
from warpmuscle.learning.imitation.pelvis import people_obliquity, turn_sideways, with_obliquity, with_tilt
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.results.partial_motion import motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.anatomy import joint_place, leg_joints
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.symmetry import VECTOR
from warpmuscle.scene.learning import ImitatedRun, Imitation
from warpmuscle.scene.norms import FLEXION, IMITATED, LEG_ANGLES, is_run
from warpmuscle.scene.people.fukuchi import gained_by_speed
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.checks import near
from warpmuscle.simulation.rollout import Rollout

BINS = 100  # of the cycle
SEEN = 8.0  # s of the gait, however long the scene lasts
LEFT = np.array([1.0, 0.0, 0.0])
NEWTON_STEPS, SMALL_TURN, LEAST_SLOPE, GREATEST_STEP = 20, 1e-4, 1e-3, 0.3  # where a joint follows another one; rad
CARRYING = BINS * 6 // 10  # bins in which the left foot carries


@dataclass(frozen=True)
class Gait:
    """One cycle of a gait, from a contact of the left foot to its next.

    Attributes:
        coordinate: (BINS, coordinates) of all joints, means over the cycles. up: (BINS, 3) the vertical in the root.
        cycle_time: s, of the clock. landings: (n,) s, when the left foot touched down in the gait.
        right: part of the cycle after which the right foot touches down.
        runs: whether it is a run. running: what it becomes where the body is to be fast.
    """

    coordinate: Floats
    up: Floats
    cycle_time: float
    landings: Floats
    right: float
    runs: bool = False
    running: Gait | None = None

    def phases(self, times: Floats) -> Floats:
        """Parts of the cycle, 0 to 1, at times of the gait, s."""
        mean = float(np.diff(self.landings).mean())
        inside = np.interp(times, self.landings, np.arange(len(self.landings)))
        before, after = np.minimum(times - self.landings[0], 0.0), np.maximum(times - self.landings[-1], 0.0)
        return np.asarray((inside + (before + after) / mean) % 1.0)

    def nearest(self, coordinates: Floats, rollout: Rollout) -> Floats:
        """Parts of the cycle (n,) where the joints are nearest to how they are at coordinates (n, C), at any speed."""
        cycles = self.coordinate if self.running is None else np.concatenate([self.coordinate, self.running.coordinate])
        poses, first = np.array(coordinates, dtype=float), rollout.names.coordinate_start[1]
        for span in quaternions(rollout.numeric, rollout.names):
            poses[:, span] *= np.where(poses[:, span] @ self.coordinate[0, span] < 0.0, -1.0, 1.0)[:, None]
        apart = poses[:, None, first:] - cycles[None, :, first:]
        return np.asarray(np.argmin(np.square(apart).sum(axis=2), axis=1) % BINS / BINS)


def seen_time(imitation: Imitation | None) -> float:
    """How much of the gait of the scene's controller a task that imitates it looks at, s; 0 if it does not."""
    return 0.0 if imitation is None or imitation.file else imitation.settle + SEEN


def imitated(measured: Gait, rollout: Rollout, imitation: Imitation, body: BodySymmetry | None = None) -> Gait:
    """The gait that a task imitates, of that which the scene's own controller makes, see `measured_gait`.

    Both sides are alike where the body is symmetric.
    """
    gait = measured if imitation.cycle_time is None else replace(measured, cycle_time=imitation.cycle_time)
    return changed(gait, rollout, imitation, body)


def measured_gait(recording: Recording, rollout: Rollout, imitation: Imitation) -> Gait:
    """One cycle of a gait as it is, recorded by `starts.controller_gait`; SceneError if it has no two whole cycles."""
    weight = body_weight(rollout.numeric)
    left, right = (touch_downs(recording, side, weight) for side in SIDES)
    steady = left[left >= imitation.settle]
    if len(steady) < 3 or len(right) < 1:
        raise SceneError(
            "the gait of the scene's controller has no two whole cycles to imitate", key="learning.imitation"
        )
    cycles = list(zip(steady[:-1].tolist(), steady[1:].tolist(), strict=True))
    up = rotate(conjugate(recording.root_orientation.astype(float)), np.array([0.0, 1.0, 0.0]))
    lags = [
        (float(right[right >= begin][0]) - begin) / (end - begin) for begin, end in cycles if (right >= begin).any()
    ]
    return Gait(
        cycle_means(recording.coordinate, quaternions(rollout.numeric, rollout.names), recording.time, cycles),
        over_strides(recording.time, up, cycles).mean(axis=0)[:BINS], float(np.diff(steady).mean()), left,
        float(np.median(lags)) % 1.0,
    )  # fmt: skip


def recorded_gait(rollout: Rollout, imitation: Imitation, body: BodySymmetry | None = None) -> Gait:
    """The gait of the recorded motion that a task names; both sides are alike where the body is symmetric.

    Raises:
        Error: the file cannot be read. RolloutError: it has no such motion, its joints are others, or there is no whole
            cycle.
    """
    path = imitation.file
    result = read(path, replay=imitation.replay)
    motion = motion_of(result, path, imitation.replay)
    first, names = rollout.names.coordinate_start[1], rollout.coordinate_names
    for name in names[first:]:
        if name not in motion.coordinate_names:
            lacks = f"{path}: its motion has no coordinate {name!r}, which {rollout.scene.name} has"
            raise RolloutError(lacks + near(name, motion.coordinate_names))
    columns = [motion.coordinate_names.index(name) for name in names[first:]]
    coordinate = np.zeros((motion.frames, len(names)))
    coordinate[:, first:] = motion.coordinate[:, columns]
    left, right = (touch_downs(motion, side) for side in SIDES)
    cycles = list(zip(left[:-1].tolist(), left[1:].tolist(), strict=True))
    lags = [(right[(right > begin) & (right <= end)] - begin) / (end - begin) for begin, end in cycles]
    if not cycles or not any(len(lag) for lag in lags):
        raise RolloutError(
            f"{path}: its motion has no whole gait cycle of the left foot in which the right one lands, by the forces "
            "on them"
        )
    up = rotate(conjugate(motion.root_orientation.astype(float)), np.array([0.0, 1.0, 0.0]))
    gait = Gait(
        cycle_means(coordinate, quaternions(rollout.numeric, rollout.names), motion.time, cycles),
        over_strides(motion.time, up, cycles).mean(axis=0)[:BINS],
        imitation.cycle_time or float(np.diff(left).mean()), left, float(np.median(np.concatenate(lags))) % 1.0,
    )  # fmt: skip
    return changed(gait, rollout, imitation, body)


def changed(gait: Gait, rollout: Rollout, imitation: Imitation, body: BodySymmetry | None) -> Gait:
    """The gait with all that a task changes of it."""
    gait = gait if body is None else evened(gait, body, rollout)
    if imitation.pelvis_tilt is not None:
        coordinate, up = with_tilt(gait.coordinate, gait.up, np.radians(imitation.pelvis_tilt), rollout)
        gait = replace(gait, coordinate=coordinate, up=up)
    if imitation.pelvis:
        gait = _leaning(gait, np.zeros(BINS), rollout)  # so that its axes are those of the ground
    if imitation.step_width is not None:
        gait = with_step_width(gait, imitation.step_width, rollout)
    if imitation.pelvis:
        gait = _leaning(gait, people_obliquity(PERCENT[:BINS]), rollout)
    gait = with_norm(gait, imitation.norm, rollout) if imitation.norm else gait
    return gait if imitation.run is None else replace(gait, running=_running(gait, imitation.run, rollout))


def _running(gait: Gait, run: ImitatedRun, rollout: Rollout) -> Gait:
    """The gait as a run: the same but for the legs and the clock."""
    return replace(with_norm(gait, run.norm, rollout), cycle_time=run.cycle_time, runs=True)


def _leaning(gait: Gait, wanted: Floats, rollout: Rollout) -> Gait:
    """The gait with another obliquity of the root, (BINS,) rad."""
    coordinate, up = with_obliquity(gait.coordinate, gait.up, wanted, rollout)
    return replace(gait, coordinate=coordinate, up=up)


def quaternions(scene: Scene, names: Topology) -> list[slice[int, int, None]]:
    """Coordinates of every ball joint."""
    spans = [names.joint_coordinates(body) for body in range(1, len(names.bodies))]
    return [
        span
        for span, name in zip(spans, names.joints, strict=True)
        if joint_type(scene.character.joints[name]).quaternion
    ]


def cycle_means(values: Floats, balls: list[slice[int, int, None]], time: Floats, cycles: Any) -> Floats:
    """Mean coordinates (BINS, C) over cycles, from a recording's (F, C)."""
    aligned = values.astype(float)
    for span in balls:
        q = aligned[:, span]
        aligned[:, span] = q * np.where(q @ q[0] < 0.0, -1.0, 1.0)[:, None]
    mean: Floats = over_strides(time, aligned, cycles).mean(axis=0)[:BINS]
    for span in balls:
        mean[:, span] = normalized(mean[:, span])
    return mean


def with_norm(gait: Gait, source: str, rollout: Rollout, speed: float | None = None) -> Gait:
    """The gait, whose hips, knees and ankles bend as in a norm of that name, moved to a speed, m/s, if one is given."""
    angles = next(norm.angles for norm in IMITATED if norm.source == source)
    scene, names = rollout.numeric, rollout.names
    relative = None if speed is None else dimensionless_speed(speed, leg_length(scene))
    coordinate = gait.coordinate.copy()
    for side, lag in enumerate((0.0, gait.right)):
        percent = 100.0 * ((PERCENT[:BINS] / 100.0 - lag) % 1.0)
        for title, sign, name in zip(LEG_ANGLES, FLEXION, leg_joints(scene, side), strict=True):
            wanted = angles[title].mean(percent)
            if speed is not None and is_run(source):
                wanted = wanted + gained_by_speed(title, percent, speed)
            elif relative is not None:
                wanted = wanted + np.interp(percent, PERCENT, trend(title, relative))
            _bend(scene.character.joints[name], names.body_of_joint(name), sign * np.radians(wanted), coordinate, names)
    return replace(gait, coordinate=coordinate)


def _bend(joint: Joint, body: int, wanted: Floats, coordinate: Floats, names: Topology) -> None:
    """Bend a joint to angles (BINS,), rad, about the axis to the left; one that follows another by moving that."""
    kind, (columns, speeds) = joint_type(joint), names.arguments_of(body)
    still = np.zeros((BINS, len(speeds)))

    def bent(q: Floats) -> Floats:
        return np.asarray(twist_angle(kind.motion(joint, q, still).orientation, LEFT))

    q = coordinate[:, columns]
    if kind.quaternion:
        coordinate[:, columns] = multiply(q, about(LEFT, wanted - bent(q)))
    elif not joint.follows:
        coordinate[:, columns[0]] += (wanted - bent(q)) * np.sign(kind.frame(joint)[0][0, 0])
    else:
        small = np.eye(len(columns))[0] * SMALL_TURN
        for _ in range(NEWTON_STEPS):
            slope = (bent(q + small) - bent(q - small)) / (2.0 * SMALL_TURN)
            step = np.divide(wanted - bent(q), slope, out=np.zeros(BINS), where=np.abs(slope) > LEAST_SLOPE)
            q[:, 0] += np.clip(step, -GREATEST_STEP, GREATEST_STEP)
        coordinate[:, columns] = q


def evened(gait: Gait, body: BodySymmetry, rollout: Rollout) -> Gait:
    """The mean of a gait and of its mirror image half a cycle later."""
    names, scene = rollout.coordinate_names, rollout.numeric
    later, image = np.roll(gait.coordinate, -BINS // 2, axis=0), gait.coordinate.copy()
    for k, name in enumerate(names):
        if name in body.coordinates:
            other, sign = body.coordinates[name]
            image[:, k] = sign * later[:, names.index(other)]
    balls = quaternions(scene, rollout.names)
    for span in balls:
        image[:, span] *= np.where(np.sum(image[:, span] * gait.coordinate[:, span], axis=1) < 0.0, -1.0, 1.0)[:, None]
    coordinate = 0.5 * (gait.coordinate + image)
    for span in balls:
        coordinate[:, span] = normalized(coordinate[:, span])
    up = normalized(gait.up + np.roll(gait.up, -BINS // 2, axis=0) * VECTOR)
    return replace(gait, coordinate=coordinate, up=up, right=0.5)


def with_step_width(gait: Gait, width: float, rollout: Rollout) -> Gait:
    """The gait, whose hips turn sideways, and ankles back, until ankles that carry are so far apart, m.

    It is measured in axes of the pelvis: a pelvis that sways over the feet sets them farther apart on the ground.
    """
    coordinate = gait.coordinate.copy()
    for side, outwards in enumerate((1.0, -1.0)):
        joints = leg_joints(rollout.numeric, side)
        ankle = _ankle_below_hip(joints, coordinate, rollout)
        carrying = np.roll(ankle, -round(side * gait.right * BINS), axis=0)[:CARRYING]
        hip = joint_place(rollout.numeric.character.joints[joints[0]])
        place = outwards * (hip[0] + carrying[:, 0].mean())
        turn = outwards * float(np.arctan2(0.5 * width - place, -carrying[:, 1].mean()))
        for name, angle in ((joints[0], turn), (joints[-1], -turn)):
            turn_sideways(name, np.full(BINS, angle), coordinate, rollout)
    return replace(gait, coordinate=coordinate)


def _ankle_below_hip(joints: list[str], coordinate: Floats, rollout: Rollout) -> Floats:
    """From hip to ankle of a leg of these joints, m, in axes of the pelvis: (BINS, 3)."""
    legs = [rollout.numeric.character.joints[name] for name in joints]
    ends = [joint_place(below) - first_row(above.position_in_child) for above, below in pairwise(legs)]
    place: Floats = np.zeros((BINS, 3))
    for name, joint, end in reversed(list(zip(joints, legs, ends, strict=False))):
        columns, speeds = rollout.names.arguments_of(rollout.names.body_of_joint(name))
        motion = joint_type(joint).motion(joint, coordinate[:, columns], np.zeros((BINS, len(speeds))))
        place = rotate(motion.orientation, place + end)
    return place
