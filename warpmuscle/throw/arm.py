"""What a fit knows of a scene: which angles its muscles move, how strong these are, and what may change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.pose import about, conjugate, from_rotation_vector, multiply, rotate
from warpmuscle.model.path_table import joints_of_muscles
from warpmuscle.scene import Actuation, Drive, Joint, Motion, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.muscles.settings import special_settings
from warpmuscle.scene.parameters import Parameter, free_parameters, start_values, substitute
from warpmuscle.scene.topology import Topology, topology
from warpmuscle.studies.inverse_dynamics import inverse_dynamics, points_of
from warpmuscle.studies.muscle_table import MuscleTable, PathGeometry
from warpmuscle.studies.poses import initial_coordinates
from warpmuscle.throw.motion import ArmMotions

X_AXIS = np.array([1.0, 0.0, 0.0])
RATIO = 2.0  # a parameter whose bounds are further apart than this, on one side of 0, changes by factors


@dataclass(frozen=True)
class Arm:
    """A scene whose muscles, M in all, move J angles: hinges, or one angle each of universal joints.

    An angle goes by the name of its joint; they are in the order of the tree.
    """

    scene: Scene
    prescribed: tuple[str, ...] = ()  # joints of those that move as recorded

    def __post_init__(self) -> None:
        wrong = [name for name in self.prescribed if name not in self.joints]
        if wrong:
            raise Error(f"joint {wrong[0]!r} cannot be prescribed: muscles move {', '.join(self.joints)}")
        if not self.driven:
            raise Error("all joints that muscles move are prescribed; leave one to the muscles")
        if special := special_settings(self.scene.character.muscles, self.scene.muscle_model):
            raise SceneError("muscles of an arm that is fitted and thrown with have none; leave it out", key=special[0])
        bent = [p.name for p in self.parameters if p.name.startswith("character.surfaces.") or ".path." in p.name]
        if bent:
            raise SceneError("the paths of an arm that is fitted and thrown with are not free; give one number",
                             key=bent[0])  # fmt: skip

    @cached_property
    def plain(self) -> Scene:
        """The scene with numbers for its free parameters."""
        return substitute(self.scene, start_values(self.scene))

    @cached_property
    def names(self) -> Topology:
        return topology(self.scene.character)

    @cached_property
    def crossed(self) -> dict[str, list[str]]:
        """Joints that every muscle acts on."""
        return joints_of_muscles(self.scene.character, self.names)

    @cached_property
    def axes(self) -> dict[str, int]:
        """Which angle of each joint muscles move, in the order of the tree."""
        character, found = self.scene.character, dict[str, int]()
        for name in self.names.joints:
            pulled = {p.axis for m in character.muscles.values() for p in m.pulleys if p.joint == name}
            if not pulled and any(name in crossed for crossed in self.crossed.values()):
                pulled = self._muscle_driven(name)
            if not pulled:
                continue
            if kind_of(character.joints[name]) not in ("hinge", "universal") or len(pulled) > 1:
                raise SceneError(
                    f"muscles of {self.scene.name} move {name}, which is neither a hinge nor a universal joint with one"
                    " angle that they move; make it hinges, as those of `throw`", key=f"character.joints.{name}",
                )  # fmt: skip
            found[name] = pulled.pop()
        if not found:
            raise SceneError(f"{self.scene.name} has no joint that muscles move", key="character.muscles")
        return found

    def _muscle_driven(self, joint: str) -> set[int]:
        """Degrees of freedom of a joint that muscles drive where it is not pulleys that say so."""
        count = len(joint_type(self.scene.character.joints[joint]).speeds)
        drive = self.scene.actuation.get(joint, Actuation("muscle")).drive
        words = [drive] * count if isinstance(drive, str) else drive
        if "muscle" not in words and "assisted" not in words and joint in self.scene.motion:
            raise SceneError("muscles run over a joint that moves as prescribed; let them drive it",
                             key=f"motion.{joint}")  # fmt: skip
        return {axis for axis, word in enumerate(words) if word in ("muscle", "assisted")}

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """Joints that muscles move, prescribed or not."""
        return tuple(self.axes)

    @cached_property
    def driven(self) -> tuple[str, ...]:
        """Joints that muscles move and that are not prescribed."""
        return tuple(name for name in self.joints if name not in self.prescribed)

    @cached_property
    def free(self) -> list[int]:
        """Places of the driven joints among all."""
        return [self.joints.index(name) for name in self.driven]

    @cached_property
    def hips(self) -> tuple[str, ...]:
        """Balls from which bodies hang down from the root: legs, which stay upright where the trunk leans."""
        points, root = points_of(self.plain.character, start_coordinates(self)[None]), self.scene.character.root
        height = {name: float(place[0, 1]) for name, (place, _) in points.items()}
        joints = self.scene.character.joints.items()
        balls = [(name, joint.child) for name, joint in joints if joint.parent == root and kind_of(joint) == "ball"]
        return tuple(name for name, child in balls if height[child] < height[root])

    @cached_property
    def muscles(self) -> tuple[str, ...]:
        return tuple(self.scene.character.muscles)

    @cached_property
    def acting(self) -> list[int]:
        """Places of the muscles that pull on a driven joint."""
        return [i for i, name in enumerate(self.muscles) if any(joint in self.driven for joint in self.crossed[name])]

    @cached_property
    def speed_places(self) -> list[int]:
        """Places of the angles' rates in a state."""
        start = self.names.speed_start
        return [start[self.names.body_of_joint(name)] + axis for name, axis in self.axes.items()]

    @cached_property
    def coordinate_places(self) -> list[int]:
        start = self.names.coordinate_start
        return [start[self.names.body_of_joint(name)] + axis for name, axis in self.axes.items()]

    @cached_property
    def limits(self) -> tuple[Floats, Floats]:
        """Least and greatest angle of each joint, (J,) rad; infinite where it has no limits."""
        joints = self.plain.character.joints
        ends = np.tile([-np.inf, np.inf], (len(self.joints), 1))
        for row, name in enumerate(self.joints):
            limits = joints[name].limits
            if limits:
                ends[row] = [first_number(end) for end in limits[self.axes[name]]]
        return ends[:, 0], ends[:, 1]

    @cached_property
    def damping(self) -> Floats:
        """Of the joints, (J,) N m s/rad."""
        plain = self.plain
        return np.array([first_number(plain.actuation.get(name, Actuation("muscle")).damping) for name in self.joints])

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
        motion = {
            name: individual
            for name, individual in self.scene.motion.items()
            if name not in self.joints or self._beside(name)
        }
        if root_type(self.scene.character).speeds:
            motion["root"] = Motion([0.0], position=[self.scene.initial_state.root_position])
        drives = {name: "kinematic" if name in self.prescribed else "muscle" for name in self.joints}
        return msgspec.structs.replace(self.scene, actuation=self.actuation(drives), motion=motion)

    def _beside(self, joint: str) -> bool:
        """Whether a joint has an angle beside the one that muscles move, which goes on moving as the scene says."""
        return len(joint_type(self.scene.character.joints[joint]).speeds) > 1 and joint not in self.prescribed

    def actuation(self, drives: Mapping[str, str]) -> dict[str, Actuation]:
        """The scene's actuation with other drives of the angles that muscles move."""
        table = dict(self.scene.actuation)
        for name, drive in drives.items():
            individual = table.get(name, Actuation("muscle"))
            count = len(joint_type(self.scene.character.joints[name]).speeds)
            words: list[Drive] = (
                [individual.drive] * count if isinstance(individual.drive, str) else list(individual.drive)
            )
            words[self.axes[name]] = cast("Drive", drive)
            table[name] = msgspec.structs.replace(individual, drive=words if count > 1 else words[0])
        return table

    @cached_property
    def geometry(self) -> PathGeometry:
        """Lengths and moment arms of muscles through points."""
        return PathGeometry(self.scene, start_coordinates(self), self.coordinate_places, self.speed_places)

    def muscle_table(self, unknowns: Floats) -> MuscleTable:
        """The muscles as arrays, for parameters (Z, P)."""
        plain = substitute(self.scene, self.values(np.atleast_2d(unknowns)))
        return MuscleTable.of(plain, self.joints, len(np.atleast_2d(unknowns)), self.geometry)


def states(arm: Arm, motions: ArmMotions) -> tuple[Floats, Floats, Floats]:
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
    upright = about(X_AXIS, -motions.pitch[0])
    for body in (arm.names.body_of_joint(name) for name in arm.hips):
        at, rate = arm.names.coordinate_start[body], arm.names.speed_start[body]
        start = q[0, 0, at : at + 4].copy()
        q[:, :, at : at + 4] = multiply(upright, np.broadcast_to(start, upright.shape))
        axis = rotate(conjugate(start), X_AXIS)  # along the child's axes, as speeds are
        v[:, :, rate : rate + 3], a[:, :, rate : rate + 3] = (-part[:, :, None] * axis for part in motions.pitch[1:])
    return q, v, a


def kind_of(joint: Joint) -> str:
    """The type of a joint; "" if it follows another one."""
    return "" if joint.follows else joint.type


def start_coordinates(arm: Arm) -> Floats:
    """Coordinates (C,) of the scene's initial state, its root where the scene's own motion of it begins."""
    plain = arm.plain
    if "root" in plain.motion and plain.motion["root"].position:
        state = msgspec.structs.replace(plain.initial_state, root_position=plain.motion["root"].position[0])
        plain = msgspec.structs.replace(plain, initial_state=state)
    return initial_coordinates(plain)


def root_motion(arm: Arm, motions: ArmMotions) -> tuple[Floats, Floats, Floats]:
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
    at, turned = points_of(arm.plain.character, start_coordinates(arm)[None])[body]
    root, root_turned = points_of(arm.plain.character, start_coordinates(arm)[None])[arm.scene.character.root]
    number = arm.names.bodies.index(body)
    com = (
        np.zeros(3) if number == 0 else rows(arm.scene.character.joints[arm.names.joints[number - 1]].position_in_child)
    )
    from_root = at[0] + rotate(turned[0], position - com) - root[0]
    return rotate(root_turned[0] * [-1.0, -1.0, -1.0, 1.0], from_root)


def needed_torques(arm: Arm, motions: ArmMotions) -> Floats:
    """Torques (n, T, J), N m, that muscles must make along recorded motions, the joints' damping included."""
    q, v, a = states(arm, motions)
    count, samples = q.shape[:2]
    forces = inverse_dynamics(arm.scene, *(x.reshape(count * samples, -1) for x in (q, v, a)))
    return forces[:, arm.speed_places].reshape(count, samples, -1) + arm.damping * motions.angles[1]


def past_limits(arm: Arm, angle: Floats) -> Floats:
    """By how much angles (..., J), rad, are beyond the limits of their joints; 0 where they are not."""
    low, high = arm.limits
    return np.asarray(np.maximum(np.maximum(low - angle, angle - high), 0.0))


def hand_position(arm: Arm, coordinates: Floats) -> Floats:
    """Position (n, 3), m, of the ball in the hand.

    It is the centre of what is fixed to the last body; if there is nothing, it is taken to be as far beyond the hand's
    centre of mass as the wrist lies before it.
    """
    joints, points = arm.scene.character.joints, points_of(arm.plain.character, coordinates)
    hand = joints[arm.joints[-1]]
    for joint in joints.values():
        if not joint_type(joint).moves and joint.parent == hand.child:
            position, turned = points[joint.child]
            return np.asarray(position - rotate(turned, rows(joint.position_in_child)))
    position, turned = points[hand.child]
    return np.asarray(position - rotate(turned, 2.0 * rows(hand.position_in_child)))


def joint_positions(arm: Arm, coordinates: Floats) -> list[Floats]:
    """Positions (n, 3), m, of the arm's joints, from the first one on."""
    points = points_of(arm.plain.character, coordinates)
    return [points[arm.scene.character.joints[name].child][0] for name in arm.joints]
