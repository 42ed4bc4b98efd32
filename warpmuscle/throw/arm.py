"""What a fit knows of a scene: which hinges its muscles move, how strong these are, and what may change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import msgspec
import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.pose import about, from_rotation_vector, rotate
from warpmuscle.core.warp_start import start_warp
from warpmuscle.kernels.curve_sets import CURVES
from warpmuscle.kernels.muscle import rigid_force
from warpmuscle.model.build import start_of
from warpmuscle.scene import Actuation, Drive, Motion, Muscle, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.joints.turning import HINGE
from warpmuscle.scene.muscles.curves import OWN, SHAPED
from warpmuscle.scene.parameters import Parameter, free_parameters, start_values, substitute
from warpmuscle.scene.topology import Topology, topology
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics
from warpmuscle.throw.motion import Motions

X_AXIS = np.array([1.0, 0.0, 0.0])
RATIO = 2.0  # a parameter whose bounds are further apart than this, on one side of 0, changes by factors


@dataclass(frozen=True)
class Arm:
    """A scene whose hinges are moved by pulley muscles, M in all, over J joints in the order of the tree."""

    scene: Scene
    prescribed: tuple[str, ...] = ()  # joints of those that move as recorded

    def __post_init__(self) -> None:
        wrong = [name for name in self.prescribed if name not in self.joints]
        if wrong:
            raise Error(f"joint {wrong[0]!r} cannot be prescribed: muscles move {', '.join(self.joints)}")
        if not self.driven:
            raise Error("all joints that muscles move are prescribed; leave one to the muscles")
        character, common = self.scene.character, self.scene.muscle_model
        own = [f"character.muscles.{name}.{field}" for name, m in character.muscles.items() for field in OWN
               if getattr(m, field) is not None]  # fmt: skip
        own += [f"muscle_model.{field}" for field in SHAPED if getattr(common, field) is not None]
        own += ["muscle_model.minimum_activation"] if common.minimum_activation != 0.0 else []
        if own:
            raise SceneError("muscles of an arm that is fitted and thrown with have none; leave it out", key=own[0])
        moved = {p.joint: name for name, muscle in character.muscles.items() for p in muscle.pulleys}
        left = [joint for joint in moved if joint not in self.joints]
        if left:
            raise SceneError(
                f"muscles of {self.scene.name} move {', '.join(left)}, which "
                f"{'is no hinge' if len(left) == 1 else 'are no hinges'}: only arms of hinges can be fitted and thrown "
                "with, such as `throw`", key="character.muscles",
            )  # fmt: skip

    @cached_property
    def names(self) -> Topology:
        return topology(self.scene.character)

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Hinges that a muscle moves, prescribed or not."""
        character = self.scene.character
        moved = {pulley.joint for muscle in character.muscles.values() for pulley in muscle.pulleys}
        hinges = {name for name, joint in character.joints.items() if joint_type(joint) is HINGE}
        found = tuple(name for name in self.names.joints if name in moved and name in hinges)
        if not found:
            raise SceneError(f"{self.scene.name} has no hinge with pulley muscles on it", key="character.muscles")
        return found

    @cached_property
    def driven(self) -> tuple[str, ...]:
        """Hinges that muscles move and that are not prescribed."""
        return tuple(name for name in self.joints if name not in self.prescribed)

    @cached_property
    def free(self) -> list[int]:
        """Places of the driven joints among all."""
        return [self.joints.index(name) for name in self.driven]

    @cached_property
    def muscles(self) -> tuple[str, ...]:
        return tuple(self.scene.character.muscles)

    @cached_property
    def acting(self) -> list[int]:
        """Places of the muscles that pull on a driven joint."""
        table = self.scene.character.muscles
        return [i for i, name in enumerate(self.muscles) if any(p.joint in self.driven for p in table[name].pulleys)]

    @cached_property
    def speed_places(self) -> list[int]:
        """Places of the joints' speeds in a state."""
        return [self.names.speed_start[self.names.body_of_joint(name)] for name in self.joints]

    @cached_property
    def coordinate_places(self) -> list[int]:
        return [self.names.coordinate_start[self.names.body_of_joint(name)] for name in self.joints]

    @cached_property
    def damping(self) -> Floats:
        """Of the joints, (J,) N m s/rad."""
        plain = substitute(self.scene, start_values(self.scene))
        return np.array(
            [float(rows(plain.actuation.get(name, Actuation("muscle")).damping).flat[0]) for name in self.joints]
        )

    @cached_property
    def parameters(self) -> list[Parameter]:
        return free_parameters(self.scene)

    @cached_property
    def _by_factor(self) -> Any:
        low, high = (np.array([getattr(p, end) for p in self.parameters]) for end in ("min", "max"))
        ratio = np.maximum(np.abs(low), np.abs(high)) / np.maximum(np.minimum(np.abs(low), np.abs(high)), 1e-12)
        return (low * high > 0.0) & (ratio > RATIO)

    @cached_property
    def _ends(self) -> tuple[Floats, Floats]:
        """Of the parameters' intervals, in the scale in which they change."""
        low, high = (self._scaled([getattr(p, end) for p in self.parameters]) for end in ("min", "max"))
        return low, np.where(high != low, high, low + 1.0)

    def _scaled(self, values: ArrayLike) -> Floats:
        array = np.asarray(values, dtype=np.float64)
        return np.where(self._by_factor, np.log(np.maximum(np.abs(array), 1e-300)), array)

    def unknowns(self, values: ArrayLike) -> Floats:
        """Values of the free parameters (..., P) as a fit sees them: 0..1 over their intervals."""
        low, high = self._ends
        return np.asarray((self._scaled(values) - low) / (high - low))

    def values(self, unknowns: ArrayLike) -> Floats:
        """The inverse of `unknowns`."""
        low, high = self._ends
        x = low + np.asarray(unknowns, dtype=np.float64) * (high - low)
        sign = np.sign([p.min + p.max for p in self.parameters])
        return np.asarray(np.where(self._by_factor, sign * np.exp(np.where(self._by_factor, x, 0.0)), x))

    @cached_property
    def simulated(self) -> Scene:
        """The scene with muscles on the driven joints, its prescribed joints kinematic, and its root if it can move."""
        actuation, motion = dict(self.scene.actuation), dict(self.scene.motion)
        for name in self.joints:
            own = actuation.get(name, Actuation("muscle"))
            drive: Drive = "kinematic" if name in self.prescribed else "muscle"
            actuation[name] = msgspec.structs.replace(own, drive=drive)
            motion.pop(name, None)
        if root_type(self.scene.character).speeds:
            motion["root"] = Motion([0.0], position=[self.scene.initial_state.root_position])
        return msgspec.structs.replace(self.scene, actuation=actuation, motion=motion)

    def muscle_table(self, unknowns: Floats) -> MuscleTable:
        """The muscles as arrays, for parameters (Z, P)."""
        plain = substitute(self.scene, self.values(np.atleast_2d(unknowns)))
        return MuscleTable.of(plain, self.muscles, self.joints, len(np.atleast_2d(unknowns)))


@dataclass(frozen=True)
class MuscleTable:
    """Numbers (Z, M) of M muscles for Z sets of parameters."""

    model: int
    f_max: Floats  # N
    l_opt: Floats  # m
    l_slack: Floats  # m
    width: Floats  # m
    rest_length: Floats  # m
    moment_arm: Floats  # (Z, M, J) m
    rest_angle: Floats  # (Z, M, J) rad
    v_max: float  # l_opt/s
    fibre_damping: float

    @staticmethod
    def of(plain: Scene, muscles: tuple[str, ...], joints: tuple[str, ...], count: int) -> MuscleTable:
        table = [plain.character.muscles[name] for name in muscles]

        def column(get: Any) -> Floats:
            return np.stack([np.broadcast_to(np.asarray(get(m), dtype=np.float64), (count,)) for m in table], axis=1)

        def pulleys(field: str) -> Floats:
            out = np.zeros((count, len(table), len(joints)))
            for i, muscle in enumerate(table):
                for pulley in muscle.pulleys:
                    if pulley.joint in joints:
                        out[:, i, joints.index(pulley.joint)] = getattr(pulley, field)
            return out

        model = plain.muscle_model
        l_opt = column(lambda m: m.l_opt)
        return MuscleTable(
            CURVES[model.curves], column(lambda m: m.f_max), l_opt, column(lambda m: m.l_slack),
            l_opt * np.sin(column(lambda m: m.pennation)), column(_rest_length), pulleys("moment_arm"),
            pulleys("rest_angle"), float(rows(model.v_max).flat[0]), float(rows(model.damping).flat[0]),
        )  # fmt: skip

    def forces(self, activation: Floats | float, angle: Floats, speed: Floats) -> Floats:
        """Tensions (Z, S, M), N, at activations (S, M) or one for all, angles and speeds (S, J)."""
        start_warp()
        arm = self.moment_arm[:, None]
        offset = angle[None, :, None, :] - self.rest_angle[:, None]
        length = self.rest_length[:, None] - np.sum(arm * offset, axis=-1)
        rate = -np.sum(arm * speed[None, :, None, :], axis=-1)

        def flat(values: Floats | float) -> wp.array:
            full = np.broadcast_to(np.asarray(values, dtype=np.float32), length.shape)
            return wp.array(full.ravel(), dtype=float, device="cpu")

        per_muscle = [flat(values[:, None]) for values in (self.l_opt, self.l_slack, self.width)]
        out = wp.map(
            rigid_force, self.model, flat(activation), flat(length), flat(rate), *per_muscle, self.v_max,
            self.fibre_damping,
        )  # fmt: skip
        return np.asarray(out.numpy().reshape(length.shape).astype(np.float64) * self.f_max[:, None])

    def torques(self, activation: Floats | float, angle: Floats, speed: Floats) -> Floats:
        """Torques (Z, S, M, J), N m, of every muscle about every joint."""
        return np.asarray(self.forces(activation, angle, speed)[..., None] * self.moment_arm[:, None])


def _rest_length(muscle: Muscle) -> Any:
    if muscle.rest_length is None:
        raise SceneError("a muscle without pulleys cannot be fitted to motions", key="character.muscles")
    return muscle.rest_length


def states(arm: Arm, motions: Motions) -> tuple[Floats, Floats, Floats]:
    """Coordinates (n, T, C), speeds and accelerations (n, T, S) of the whole character along recorded motions."""
    count, samples = motions.pitch[0].shape
    q = np.tile(start_coordinates(arm), (count, samples, 1))
    v, a = (np.zeros((count, samples, arm.names.speeds)) for _ in range(2))
    for order, target in ((0, q), (1, v), (2, a)):
        places = arm.coordinate_places if order == 0 else arm.speed_places
        target[:, :, places] = motions.angles[order]
    root = root_type(arm.scene.character)
    if not root.speeds:
        return q, v, a
    place, rates, bends = (part.reshape(count * samples, 3) for part in root_motion(arm, motions))
    turned, turning, accelerating = (part.reshape(-1, 1) * X_AXIS for part in motions.pitch)
    for velocity, angular, target in ((rates, turning, v), (bends, accelerating, a)):
        coordinates, speeds = root.coordinates_of(place, from_rotation_vector(turned), velocity, angular)
        target[:, :, : speeds.shape[1]] = speeds.reshape(count, samples, -1)
    q[:, :, : coordinates.shape[1]] = coordinates.reshape(count, samples, -1)
    return q, v, a


def start_coordinates(arm: Arm) -> Floats:
    """Coordinates (C,) of the scene's initial state, its root where the scene's own motion of it begins."""
    plain = substitute(arm.scene, start_values(arm.scene))
    if "root" in plain.motion and plain.motion["root"].position:
        state = msgspec.structs.replace(plain.initial_state, root_position=plain.motion["root"].position[0])
        plain = msgspec.structs.replace(plain, initial_state=state)
    return np.asarray(start_of(plain, arm.names).coordinates[0])


def root_motion(arm: Arm, motions: Motions) -> tuple[Floats, Floats, Floats]:
    """Position (n, T, 3), m, of the root so that the first joint moves as the shoulder did; its two derivatives."""
    start = start_coordinates(arm)
    home = root_type(arm.scene.character).motion(start[None]).place[0]
    joint = arm.scene.character.joints[arm.joints[0]]
    offset = _offset_from_root(arm, joint.parent, rows(joint.position_in_parent))
    turned = rotate(about(X_AXIS, motions.pitch[0]), np.broadcast_to(offset, (*motions.pitch[0].shape, 3)))
    place, rate, bend = (_forward_and_up(part) for part in motions.place)
    _, pitch_rate, pitch_bend = (part[..., None] for part in motions.pitch)
    across = np.cross(X_AXIS, turned)  # by how much it moves with the pitch
    inwards = np.cross(X_AXIS, across)
    position = home + offset + place - place[:, motions.time.searchsorted(-1e-9)][:, None] - turned
    return position, rate - pitch_rate * across, bend - pitch_bend * across - pitch_rate**2 * inwards


def _forward_and_up(place: Floats) -> Floats:
    """Forwards and up (..., 2) as x, y and z."""
    return np.stack([np.zeros_like(place[..., 0]), place[..., 1], place[..., 0]], axis=-1)


def _offset_from_root(arm: Arm, body: str, position: Floats) -> Floats:
    """A point of a body, m, from the root's centre of mass, in the initial pose."""
    at, turned = body_points(arm.scene, start_coordinates(arm)[None])[body]
    root, root_turned = body_points(arm.scene, start_coordinates(arm)[None])[arm.scene.character.root]
    number = arm.names.bodies.index(body)
    com = (
        np.zeros(3) if number == 0 else rows(arm.scene.character.joints[arm.names.joints[number - 1]].position_in_child)
    )
    from_root = at[0] + rotate(turned[0], position - com) - root[0]
    return rotate(root_turned[0] * [-1.0, -1.0, -1.0, 1.0], from_root)


def needed_torques(arm: Arm, motions: Motions) -> Floats:
    """Torques (n, T, J), N m, that muscles must make along recorded motions, the joints' damping included."""
    q, v, a = states(arm, motions)
    count, samples = q.shape[:2]
    forces = inverse_dynamics(arm.scene, *(x.reshape(count * samples, -1) for x in (q, v, a)))
    return forces[:, arm.speed_places].reshape(count, samples, -1) + arm.damping * motions.angles[1]


def hand_position(arm: Arm, coordinates: Floats) -> Floats:
    """Position (n, 3), m, of the ball in the hand.

    It is the centre of what is fixed to the last body; if there is nothing, it is taken to be as far beyond the hand's
    centre of mass as the wrist lies before it.
    """
    joints, points = arm.scene.character.joints, body_points(arm.scene, coordinates)
    hand = joints[arm.joints[-1]]
    for joint in joints.values():
        if not joint_type(joint).moves and joint.parent == hand.child:
            position, turned = points[joint.child]
            return np.asarray(position - rotate(turned, rows(joint.position_in_child)))
    position, turned = points[hand.child]
    return np.asarray(position - rotate(turned, 2.0 * rows(hand.position_in_child)))


def joint_positions(arm: Arm, coordinates: Floats) -> list[Floats]:
    """Positions (n, 3), m, of the arm's joints, from the first one on."""
    points = body_points(arm.scene, coordinates)
    return [points[arm.scene.character.joints[name].child][0] for name in arm.joints]
