"""A recorded gait as a reference: mean joint orientations over the phase of a step, in left and in right stance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import conjugate, multiply, normalized
from warpmuscle.formats import load
from warpmuscle.model.build import ReferenceGait
from warpmuscle.model.structure import Structure
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene, Tracking
from warpmuscle.scene.initial_pose import initial_pose
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import Topology

if TYPE_CHECKING:
    from warpmuscle.formats.npz import JointMotion

BINS = 50  # of the phase


def motion_in_file(tracking: Tracking, scene: Scene) -> Recording | JointMotion:
    """The motion of a file that a scene names; raises Error if the file has no such motion, or cannot be read.

    Args:
        scene: without free parameters.
    """
    # What reads files takes longer to import than most scenes to start, which track none.
    from warpmuscle.formats import motion_table, npz
    from warpmuscle.results.partial_motion import demanding
    from warpmuscle.results.result import read

    replays: Sequence[Recording | JointMotion]
    suffix = Path(tracking.file).suffix.lower()
    if suffix == ".npz":
        replays = [npz.read(tracking.file, scene.character)]
    elif suffix in motion_table.SUFFIXES:
        replays = [motion_table.read(tracking.file, scene)]
    else:
        recorded = read(tracking.file, replay=tracking.replay).replays
        replays = [demanding(motion, tracking.file) for motion in recorded]
    if tracking.replay >= len(replays):
        raise RolloutError(
            f"{tracking.file} has {number_of(len(replays), 'motion')}, none with number {tracking.replay}"
        )
    return replays[tracking.replay]


def reference_of(scene: Scene, structure: Structure, record: Callable[[Scene], Recording]) -> ReferenceGait | None:
    """The gait that the objective of a scene tracks; None if it tracks none.

    Args:
        record: simulates a scene and gives its motion.

    Raises:
        Error: the tracked scene or file cannot be read, or has no such motion or joints.
    """
    tracking = scene.tracking
    if tracking is None or "tracking" not in structure.objective.body:
        return None
    motion: Recording | JointMotion
    if tracking.file:
        motion = motion_in_file(tracking, at_start(scene))
    else:
        tracked = load(tracking.scene)
        if tracked.tracking is not None:  # perhaps this one; what it tracks itself does not move it
            objective = msgspec.structs.replace(tracked.objective, tracking=0.0)
            tracked = msgspec.structs.replace(tracked, tracking=None, objective=objective)
        motion = record(tracked)
    part = motion.window(tracking.start)
    if isinstance(part, Recording) and "phase" in part.missing:
        motion = part = _by_contact(part, at_start(scene), tracking.file or tracking.scene)
    if not len(part.phase):
        source = tracking.file or tracking.scene
        raise RolloutError(f"{source} has no motion from {tracking.start:g} s on, which `tracking.start` asks for")
    orientation, counts = reference_table(part, structure.names, tracking.joints, tracking.weights)
    if isinstance(motion, Recording) or not motion.by_contact:
        return ReferenceGait(orientation, counts, False)
    begin = nearest_part(orientation, counts, at_start(scene), structure.names)
    return ReferenceGait(orientation, counts, True, motion.period, begin)


def nearest_part(table: Floats, counts: Floats, scene: Scene, names: Topology) -> float:
    """The part of a gait's cycle, 0 to 1, that is nearest to the initial pose of a numeric scene.

    Args:
        table, counts: as `reference_table` gives them.
    """
    poses, _ = initial_pose(scene)
    away = np.zeros(len(table))
    for joint in scene.character.joints.values():
        body = names.bodies.index(joint.child)
        relative = multiply(conjugate(poses[joint.parent][1]), poses[joint.child][1])
        away += counts[body] * np.arccos(np.clip(np.abs(table[:, body] @ relative), 0.0, 1.0)) ** 2
    return float((np.argmin(away) + 0.5) / len(table))


def _by_contact(motion: Recording, scene: Scene, source: str) -> JointMotion:
    """A motion without phases of a controller, over the gait cycles between touch-downs of the left foot.

    Raises:
        RolloutError: it has no whole one.
    """
    from warpmuscle.formats.npz import JointMotion, steps
    from warpmuscle.gait.cycles import body_weight
    from warpmuscle.gait.foot_contact import contacts

    there = "foot_force_left" not in motion.missing
    force = motion.foot_force_left[:, 1] if there else np.zeros(motion.frames)
    spells = contacts(motion.time, force, body_weight(scene))
    down = [spell.touch_down for spell in spells if spell.touch_down is not None]
    if len(down) < 2:
        raise RolloutError(
            f"the motion of {source} has no phases, which a simbicon controller gives it, nor ground forces of a whole "
            "gait cycle of the left foot; track a table of it with a column `cycle`"
        )
    inside = (motion.time >= down[0]) & (motion.time < down[-1])
    time = motion.time[inside]
    cycle = np.interp(time, down, np.arange(len(down))) % 1.0
    phase, stance = steps({"cycle": cycle})
    orientation = np.asarray(motion.joint_orientation, np.float64)[inside]
    return JointMotion(motion.joint_names, time, phase, stance, orientation, True, float(np.diff(down).mean()))


def reference_table(
    motion: Recording | JointMotion,
    names: Topology,
    joints: list[str],
    weights: Mapping[str, float] = MappingProxyType({}),
) -> tuple[Floats, Floats]:
    """Mean orientations (2 BINS, bodies, 4) of each body's joint, left stance first, and their weights (bodies,).

    Bins of the phase that the motion never comes to take those of the nearest bin that it does.

    Args:
        motion: with the phases of a controller. joints: those that count; all that both have if empty.
        weights: how much, by joint; 1 where none is given.

    Raises:
        RolloutError: the motion lacks one of the joints, or has no steps of one side.
    """
    table = np.zeros((2 * BINS, len(names.bodies), 4))
    table[..., 3] = 1.0
    counts = np.zeros(len(names.bodies))
    tracked = joints or [joint for joint in names.joints if joint in motion.joint_names]
    rows = motion.stance.astype(int) * BINS + np.clip((motion.phase * BINS).astype(int), 0, BINS - 1)
    for side in (0, 1):
        if not np.any(rows // BINS == side):
            raise RolloutError(f"the tracked motion never stands on the {'right' if side else 'left'} foot")
    for joint in tracked:
        if joint not in motion.joint_names:
            raise RolloutError(f"the tracked motion has no joint {joint!r}; it has {', '.join(motion.joint_names)}")
        body = names.body_of_joint(joint)
        counts[body] = weights.get(joint, 1.0)
        table[:, body] = _means(motion.joint_orientation[:, motion.joint_names.index(joint)].astype(float), rows)
    return table, counts


def _means(orientation: Floats, rows: Any) -> Floats:
    """Mean unit quaternion of the frames in each row, (2 BINS, 4); empty rows take the nearest of their side."""
    aligned = orientation * np.where(orientation @ orientation[0] < 0.0, -1.0, 1.0)[:, None]
    total = np.zeros((2 * BINS, 4))
    np.add.at(total, rows, aligned)
    for side in (0, 1):
        here = np.arange(side * BINS, (side + 1) * BINS)
        full = here[np.linalg.norm(total[here], axis=1) > 0.0]
        nearest = full[np.abs(here[:, None] - full[None]).argmin(axis=1)]
        total[here] = total[nearest]
    return normalized(total)
