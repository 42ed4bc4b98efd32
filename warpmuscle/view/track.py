"""What is shown of one simulated instance: a doll made of its scene, and its motion; numbers only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about, multiply, normalized, rotate, twist_angle
from warpmuscle.gait.foot_sliding import foot_points
from warpmuscle.gait.relative_to_belts import belt_shift, over_belts
from warpmuscle.model.controllers.simbicon import trajectory_bodies
from warpmuscle.results.joint_poses import joint_places
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.objects.motion import ObjectMotion
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.topology import Topology, topology
from warpmuscle.view.curves import FULL_FORCE
from warpmuscle.view.measured.content import at_times, moved_back
from warpmuscle.view.muscle_lines import MuscleLines, Routes, muscle_lines, point_weights, world_points
from warpmuscle.view.objects import motions_of
from warpmuscle.view.packing import encodable

if TYPE_CHECKING:
    from warpmuscle.inverse.recordings.measured import Measured

UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Doll:
    """What stays the same while a character moves; B bodies."""

    muscles: MuscleLines
    parent: NDArray[np.int64]  # (B,) -1 for the root
    in_parent: Floats  # (B, 3) m, a body's joint in its parent's frame
    in_child: Floats  # (B, 3) m, and in its own
    sliding: tuple[int, ...]  # (K,) bodies whose joint point moves in their parent
    weight: float  # N, of the whole body, in standard gravity
    wraps: bool  # whether there are surfaces that its muscles wrap around
    names: Topology
    objects: tuple[str, ...] = ()  # beside the character

    def positions(self, root: Floats, orientation: Floats, slid: Floats) -> Floats:
        """Centres of mass (F, B, 3), m.

        Args:
            root: the root's (F, 3), m. orientation: of all bodies (F, B, 4). slid: see `Track.slid`.
        """
        position = np.empty((*orientation.shape[:2], 3))
        position[:, 0] = root
        for body, parent in enumerate(self.parent[1:], 1):
            place = self.in_parent[body]
            if body in self.sliding:
                place = place + slid[:, self.sliding.index(body)]
            anchor = position[:, parent] + rotate(orientation[:, parent], place)
            position[:, body] = anchor - rotate(orientation[:, body], self.in_child[body])
        return position


@dataclass(frozen=True)
class Track:
    """The motion of a doll over F frames."""

    label: str
    doll: Doll
    recording: Recording  # of these frames
    slid: Floats  # (F, K, 3) m, how far the joint points of the doll's sliding bodies are from their parents'
    desired: Floats | None  # (F, B, 4) orientations that the controller wants, or that were recorded, if any
    point_weight: Floats  # (F, C) of the muscles' conditional points
    routes: Routes  # those of the muscles that do not run from point to point
    muscle_load: Floats  # (F, M) force over `FULL_FORCE` f_max, 0..1
    foot_force: Floats  # (F, 2, 3) N, on the left and the right foot
    foot_center: Floats  # (F, 2, 3) m, where these act
    objects: tuple[ObjectMotion, ...] = ()  # of the doll's objects
    measured: Measured | None = None  # in the same frames

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.recording.frames

    def muscle_points(self) -> Floats:
        """Via points (F, P, 3) of all muscles, m, world."""
        r = self.recording
        routed = self.routes.all()
        return world_points(self.doll.muscles, r.body_position, r.body_orientation, self.point_weight, routed)


def doll_of(scene: Scene, muscles: tuple[str, ...]) -> Doll:
    """The doll of a scene without free parameters (see `parameters.substitute`), with some of its muscles."""
    names, character = topology(scene.character), scene.character
    joints = [character.joints[name] for name in names.joints]
    zero = (0.0, 0.0, 0.0)
    return Doll(
        muscles=muscle_lines(character, muscles, names.bodies),
        parent=np.array(names.parents, dtype=np.int64),
        in_parent=np.array([zero, *(joint.position_in_parent for joint in joints)], dtype=np.float64),
        in_child=np.array([zero, *(joint.position_in_child for joint in joints)], dtype=np.float64),
        sliding=tuple(i for i, joint in enumerate(joints, 1) if joint_type(joint).by_coordinate),
        weight=9.81 * body_mass(character),
        wraps=any(character.muscles[name].wraps for name in muscles),
        names=names,
        objects=tuple(scene.objects),
    )


def track_of(
    recording: Recording, scene: Scene, label: str = "", rate: float | None = None, doll: Doll | None = None,
    measured: Measured | None = None,
) -> Track:  # fmt: skip
    """What is shown of a recording; on a treadmill as it is seen from the belts.

    Args:
        scene: that made it, without free parameters (see `parameters.substitute`).
        rate: frames a second at most, of those recorded.
        doll: of that scene and these muscles, if there is one already.
        measured: what was measured of the motion; it is left out where it is of other times.

    Raises:
        Error: the recording has no frames, or is of another character.
    """
    doll = doll if doll is not None else _checked_doll(recording, scene)
    recording = thinned(recording, rate)
    seen = at_times(measured, recording.time)
    shift = belt_shift(recording, scene)
    if shift is not None:
        recording, seen = over_belts(recording, scene), None if seen is None else moved_back(seen, shift)
    f_max = np.array([scene.character.muscles[name].f_max for name in recording.muscle_names], dtype=np.float64)
    return Track(
        label=encodable(label or scene.name),
        doll=doll,
        recording=recording,
        slid=_slid(recording, scene, doll),
        desired=desired_pose(recording, scene, doll.names),
        point_weight=point_weights(doll.muscles, recording, scene.character),
        routes=Routes(doll.muscles, recording, scene.character),
        muscle_load=np.clip(recording.muscle_force / (FULL_FORCE * f_max), 0.0, 1.0),
        foot_force=np.stack([recording.foot_force_left, recording.foot_force_right], axis=1),
        foot_center=foot_centers(recording, scene),
        objects=motions_of(recording, scene),
        measured=seen,
    )


def _slid(recording: Recording, scene: Scene, doll: Doll) -> Floats:
    """See `Track.slid`."""
    joints = [doll.names.joints[body - 1] for body in doll.sliding]
    places = [joint_places(recording, scene.character, joint) for joint in joints]
    return np.stack(places, axis=1) if places else np.zeros((recording.frames, 0, 3))


def _checked_doll(recording: Recording, scene: Scene) -> Doll:
    if recording.frames == 0:
        raise Error("there is nothing to show: the motion has no frames")
    names = topology(scene.character)
    unknown = [name for name in recording.muscle_names if name not in scene.character.muscles]
    if names.bodies != recording.body_names or names.joints != recording.joint_names or unknown:
        raise Error(f"the motion is of another character than that of the scene {scene.name!r}")
    check_motion_of(recording, scene)
    return doll_of(scene, recording.muscle_names)


def thinned(recording: Recording, rate: float | None) -> Recording:
    """Every k-th frame, so that there are `rate` frames a second or a few more; all of them without a rate."""
    if rate is None or recording.frames < 3:
        return recording
    interval = float(recording.time[-1] - recording.time[0]) / (recording.frames - 1)
    every = max(int(1.0 / (rate * interval) + 1e-6), 1)
    return recording.at(slice(None, None, every))


def desired_pose(recording: Recording, scene: Scene, names: Topology) -> Floats | None:
    """Orientations (F, B, 4) that the controller wants for all bodies, or that were recorded, from the root's outwards.

    Joints without a controller of their own stay as they are. Targets in the character's frame, those of the swing hip
    among them, do not depend on the parent.
    """
    controller = scene.simbicon
    if controller is None:
        return _recorded_pose(recording, names) if recording.has_targets else None
    wanted = np.array(recording.body_orientation, dtype=np.float64)
    facing = about(UP, twist_angle(recording.root_orientation, UP))
    by_character = _in_character_frame(recording, scene, names)
    for body, joint in enumerate(names.joints, 1):
        parent = wanted[:, names.parents[body]]
        if joint in controller.pd and not joint_type(scene.character.joints[joint]).by_coordinate:
            base = np.where(by_character[:, body, None], facing, parent)
            wanted[:, body] = multiply(base, normalized(recording.joint_target[:, body - 1]))
        else:
            wanted[:, body] = multiply(parent, recording.joint_orientation[:, body - 1])
    return wanted


def _recorded_pose(recording: Recording, names: Topology) -> Floats:
    """Orientations (F, B, 4) of all bodies in the recorded motion that was to be met, the root as it moved."""
    wanted = np.array(recording.body_orientation, dtype=np.float64)
    for body in range(1, len(names.bodies)):
        wanted[:, body] = multiply(wanted[:, names.parents[body]], normalized(recording.joint_target[:, body - 1]))
    return wanted


def _in_character_frame(recording: Recording, scene: Scene, names: Topology) -> NDArray[np.bool_]:
    """Whether the target of each body is in the character's frame, (F, B)."""
    controller = scene.simbicon
    assert controller is not None
    states, hips = controller.states, controller.hips
    table = np.zeros((len(states), 2, len(names.bodies)), dtype=bool)  # by state and stance
    for number, state in enumerate(states):
        driven = trajectory_bodies(state, controller, names)
        for trajectory, bodies in zip(state.trajectories.values(), driven, strict=True):
            for stance, body in enumerate(bodies):
                if body >= 0:
                    table[number, stance, body] = trajectory.frame == "character"
    for stance, swing_hip in enumerate(reversed(hips)):
        table[:, stance, names.body_of_joint(swing_hip)] = True
    return np.asarray(table[recording.state, recording.stance])


def foot_centers(recording: Recording, scene: Scene) -> Floats:
    """Where the ground forces act on both feet, (F, 2, 3), m, world: on the ground, contact points weighted by depth.

    A foot that does not touch the ground has its lowest point instead.
    """
    feet = scene.feet or ()
    ground = surface(scene.ground)
    centers = np.zeros((recording.frames, 2, 3))
    for side, foot in enumerate(feet):
        points = foot_points(recording, scene, foot)
        if not points:
            centers[:, side] = recording.position_of(foot)
            continue
        place, depth = (np.stack([getattr(point, name) for point in points], axis=1) for name in ("position", "depth"))
        share = np.maximum(depth, 0.0)
        lowest = depth >= depth.max(axis=1, keepdims=True)
        share = np.where(share.sum(axis=1, keepdims=True) > 0.0, share, lowest)
        center = np.sum(share[..., None] * place, axis=1) / share.sum(axis=1, keepdims=True)
        centers[:, side] = center - ground.above(center)[:, None] * ground.normal_at(center[:, 0], center[:, 2])
    return centers
