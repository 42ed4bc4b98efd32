"""A joint that turns and moves as functions of one coordinate say: OpenSim's CustomJoint with one coordinate."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import about, conjugate, multiply, normalized, rotate
from warpmuscle.scene import Displacement, Joint, JointState
from warpmuscle.scene.joints.coordinate import Coordinate
from warpmuscle.scene.joints.displacement import TURN, Span, depends, rates
from warpmuscle.scene.joints.joint_type import OTHER_AXIS, JointKinematics
from warpmuscle.scene.joints.two_coordinates import depends_on_two, rates_of_two
from warpmuscle.scene.validation.checks import Checks

MOST_POWER = 20  # of a coordinate
FAR = 100.0  # rad or m: knots from there on only hold what is at the ends

_SAMPLES = 361  # of the coordinate, among which the one nearest to a pose is looked for
_REFINED = 6  # times
_LENGTH = 0.1  # m, that counts as much as a radian in that


class Coupled(Coordinate):
    """The child turns about `rotations` in their order, each axis riding on those before; its joint point moves along
    `translations`, in the parent's axes. The coordinate is an angle if a rotation depends on it, else a length.
    """

    displaced = True

    def check(self, checks: Checks, key: str, joint: Joint) -> None:
        super().check(checks, key, joint)
        for field in ("rotations", "translations"):
            given = getattr(joint, field)
            if len(given) > 3:
                raise SceneError(f"a {self.name} joint takes 3 {field} at most, got {len(given)}", key=f"{key}.{field}")
            for index, displacement in enumerate(given):
                check_displacement(checks, f"{key}.{field}.{index}", displacement)
        if joint.beside:
            check_two(key, joint)
        elif not any(map(depends, (*joint.rotations, *joint.translations))):
            message = "depends on no coordinate; give a rotation or translation a `slope`, a `polynomial`, or knots"
            raise SceneError(message, key=key)

    def unit(self, joint: Joint) -> str:
        changes = depends_on_two if joint.beside else depends
        return "rad" if any(map(changes, joint.rotations)) else "m"

    def frame(self, joint: Joint) -> tuple[Floats, Floats]:
        changes = depends_on_two if joint.beside else depends
        axis = next(d.axis for d in (*joint.rotations, *joint.translations) if changes(d))
        return normalized(rows(axis)), rows(OTHER_AXIS)

    def motion(self, joint: Joint, q: Floats, v: Floats) -> JointKinematics:
        if joint.beside:
            return motion_of_two(joint, q, v)
        zero = np.zeros((len(q), 3))
        orientation = np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1))
        turning, bending, place, moving, curving = zero, zero, zero, zero, zero
        for rotation in joint.rotations:
            angle, first, second = rates(rotation, q[:, 0])
            own = normalized(rows(rotation.axis))
            axis = rotate(orientation, own)
            bending = bending + axis * second[:, None] + np.cross(turning, axis) * first[:, None]
            turning = turning + axis * first[:, None]
            orientation = multiply(orientation, about(own, angle))
        for translation in joint.translations:
            axis = normalized(rows(translation.axis))
            value, first, second = (rate[:, None] for rate in rates(translation, q[:, 0]))
            place, moving, curving = place + axis * value, moving + axis * first, curving + axis * second
        return JointKinematics(orientation, place, [turning], [moving], bending * v**2, curving * v**2)

    def shown(self, joint: Joint, orientation: Floats, place: Floats, breaks: ArrayLike = ()) -> Floats:
        """The coordinate whose pose comes nearest."""
        samples = np.linspace(*span_of(joint, joint), _SAMPLES)[:, None]
        motion = self.motion(joint, samples, np.zeros_like(samples))
        turn = np.arccos(np.clip(np.abs(orientation @ motion.orientation.T), 0.0, 1.0))
        away = np.sum(place**2, axis=1)[:, None] - 2.0 * place @ motion.place.T + np.sum(motion.place**2, axis=1)
        q = samples[np.argmin(4.0 * turn**2 + away / _LENGTH**2, axis=1)]
        for _ in range(_REFINED):
            motion = self.motion(joint, q, np.zeros_like(q))
            missing = multiply(orientation, conjugate(motion.orientation))
            missing = 2.0 * missing[:, :3] * np.where(missing[:, 3:] < 0.0, -1.0, 1.0)
            s = np.concatenate([motion.turning[0], motion.moving[0] / _LENGTH], axis=1)
            error = np.concatenate([missing, (place - motion.place) / _LENGTH], axis=1)
            q = q + np.sum(s * error, axis=1, keepdims=True) / np.maximum(np.sum(s * s, axis=1, keepdims=True), 1e-12)
        return np.asarray(q)


def check_displacement(checks: Checks, key: str, displacement: Displacement) -> None:
    """Raise SceneError unless a displacement has a direction, and knots, a polynomial or a line."""
    checks.not_zero(f"{key}.axis", displacement.axis, "axis")
    if len(displacement.x) != len(displacement.y):
        raise SceneError(
            f"{number_of(len(displacement.y), 'value')} for {number_of(len(displacement.x), 'knot')}", key=f"{key}.y"
        )
    check_terms(key, displacement)
    what = "knots `x` and `y`" if displacement.x else "a `polynomial`"
    if displacement.x:
        if len(displacement.x) < 2:
            raise SceneError("there are two knots at least", key=f"{key}.x")
        checks.increasing(f"{key}.x", displacement.x, "knots")
        if displacement.polynomial:
            raise SceneError(f"give either {what}, or `polynomial`", key=f"{key}.polynomial")
    for field in ("value", "slope") if displacement.x or displacement.polynomial else ():
        if getattr(displacement, field) != 0.0:
            raise SceneError(f"give either {what}, or `{field}`", key=f"{key}.{field}")


def span_of(joint: Joint, driver: Joint) -> Span:
    """Coordinates that a joint may have: within the limits, or what its knots reach over, and half as wide beyond.

    Args:
        driver: the joint whose coordinate and limits these are, itself or the one that it follows.
    """
    every = itertools.chain.from_iterable(d.x for d in (*joint.rotations, *joint.translations))
    knots = [x for x in every if abs(x) < FAR]
    limits = [first_number(number) for pair in driver.limits for number in pair]
    ends = limits or knots or TURN
    beyond = 0.5 * (max(ends) - min(ends))
    return min(ends) - beyond, max(ends) + beyond


def check_terms(key: str, displacement: Displacement) -> None:
    """Raise SceneError unless powers are none that are negative, and a rod has its three numbers."""
    for index, (_, m, n) in enumerate(displacement.terms):
        if not (0 <= m <= MOST_POWER and 0 <= n <= MOST_POWER):
            raise SceneError(f"powers are from 0 to {MOST_POWER}, not {m} and {n}", key=f"{key}.terms.{index}")
    if displacement.rod and len(displacement.rod) != 3:
        raise SceneError("a rod has a length and two angles", key=f"{key}.rod")


def check_two(key: str, joint: Joint) -> None:
    """Raise SceneError unless a joint of two coordinates turns about one axis, or moves along some."""
    given = [*joint.rotations, *joint.translations]
    if len(joint.rotations) > 1 or (joint.rotations and joint.translations):
        message = "a joint of two coordinates turns about one axis or moves along some; put several in a row"
        raise SceneError(message, key=f"{key}.beside")
    if joint.rotations and joint.rotations[0].rod:
        raise SceneError("a rod's end moves along `translations`", key=f"{key}.rotations.0.rod")
    for field in ("rotations", "translations"):
        for index, one in enumerate(getattr(joint, field)):
            if one.x or one.polynomial or one.slope != 0.0 or (one.rod and (one.terms or one.value != 0.0)):
                message = "of two coordinates it is `value` and `terms`, or a `rod`"
                raise SceneError(message, key=f"{key}.{field}.{index}")
    if any(one.rod for one in given) and not all(one.rod for one in given):
        raise SceneError("a `rod` is of all translations, or of none", key=f"{key}.translations")
    if not any(map(depends_on_two, given)):
        raise SceneError("depends on no coordinate; give it `terms` or a `rod`", key=key)
    for field in ("armature", "damping"):
        if getattr(joint, field) != 0.0:
            raise SceneError("a joint of two coordinates takes none", key=f"{key}.{field}")


def motion_of_two(joint: Joint, q: Floats, v: Floats) -> JointKinematics:
    """The motion of a joint at its own coordinate and that beside it, both columns of (n, 2)."""
    zero = np.zeros((len(q), 3))
    orientation = np.tile([0.0, 0.0, 0.0, 1.0], (len(q), 1))
    turning, bending, place, moving, curving = zero, zero, zero, zero, zero
    for rotation in joint.rotations:
        own = normalized(rows(rotation.axis))
        of = rates_of_two(rotation, 0, joint.rate_only, q[:, 0], q[:, 1])
        turning = own * of.first[:, None]
        bending = own * (of.second * v[:, 0] + of.mixed * v[:, 1])[:, None]
        orientation = orientation if joint.rate_only else about(own, of.value)
    for component, translation in enumerate(joint.translations):
        axis = normalized(rows(translation.axis))
        of = rates_of_two(translation, component, joint.rate_only, q[:, 0], q[:, 1])
        place = place if joint.rate_only else place + axis * of.value[:, None]
        moving = moving + axis * of.first[:, None]
        curving = curving + axis * (of.second * v[:, 0] + of.mixed * v[:, 1])[:, None]
    own_speed = v[:, :1]
    return JointKinematics(orientation, place, [turning], [moving], bending * own_speed, curving * own_speed)


class Follower(Coupled):
    """A coupled joint whose functions are of another joint's coordinate: its `motion` is given that."""

    def check(self, checks: Checks, key: str, joint: Joint) -> None:
        super().check(checks, key, joint)
        if joint.limits:
            raise SceneError(f"it has no coordinate; limit the joint {joint.follows!r}", key=f"{key}.limits")

    def check_state(self, checks: Checks, key: str, state: JointState) -> None:
        raise SceneError("a joint that follows another one starts where that one says", key=key)

    def start(self, joint: Joint, state: JointState) -> tuple[Floats, Floats]:
        return np.zeros((1, 0)), np.zeros((1, 0))

    def nearest(self, joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
        return np.zeros((len(orientation), 0)), np.zeros((len(orientation), 0))

    def shown(self, joint: Joint, orientation: Floats, place: Floats, breaks: ArrayLike = ()) -> Floats:
        return np.zeros((len(orientation), 0))


COUPLED = Coupled(
    name="coupled",
    kernel="warpmuscle.kernels.body.joint_motion:coupled_motion",
    coordinates=("",),
    speeds=("",),
    axes=0,
    limits=1,
    angles=("",),
    angle_names=("coordinate",),
)
FOLLOWER = Follower(
    name=COUPLED.name,
    device="FOLLOWER",
    kernel=COUPLED.kernel,
    coordinates=(),
    speeds=(),
    axes=0,
    limits=1,
    angles=(),
    angle_names=(),
)
