"""Prescribed motion: which coordinates of a scene are kinematic, and the curves that they follow.

Kinematic coordinates are numbered as in the state: those of the root if it moves as prescribed, then joint by joint.
A free root has its position, m, and its orientation as a quaternion x, y, z, w; a planar one y, z and its turn about x;
a ball joint has the quaternion of its child in its parent, other joints their kinematic angles, rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import rows, to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import conjugate, from_rotation_vector, multiply, normalized, twist_angle
from warpmuscle.kernels import structs
from warpmuscle.model.joints import joint_number
from warpmuscle.scene import Motion, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.topology import Topology, coordinate_names

DEGREE = 5  # of the splines
LATE = 1.0e-9  # s, by which knots may miss the ends of the simulated time
X_AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Kinematic:
    """The kinematic coordinates of a scene: C of them."""

    names: tuple[str, ...] = ()  # (C,)
    angle: list[tuple[int, int, int]] = field(default_factory=list)  # see `kernels.structs.PrescribedMotion`
    turn: list[tuple[int, int, int, int]] = field(default_factory=list)
    joint: list[tuple[int, int]] = field(default_factory=list)
    remaining: tuple[int, ...] = ()


@dataclass(frozen=True)
class Moved:
    """Where kinematic coordinates are at a time, one row a motion."""

    coordinates: Floats  # (rows, C)
    speeds: Floats  # (rows, speeds of the kinematic coordinates), in the order of `speed_numbers`
    accelerations: Floats


@dataclass(frozen=True)
class Curves:
    """Polynomials of fifth degree, piece by piece."""

    start: Floats  # (pieces,) s, where they start
    coefficients: Floats  # (rows, pieces, C, 6), the constant first, over the time since the start of the piece
    row: Integers | None = None  # (instances,) which row an instance follows; its own, or the only one, if None

    def rates(self, time: float) -> Floats:
        """Values and first and second derivatives at a time, s, (3, rows, C)."""
        piece = max(int(np.searchsorted(self.start, time, side="right")) - 1, 0)
        c, x = self.coefficients[:, piece], time - self.start[piece]
        power = x ** np.arange(DEGREE + 1)
        weights = np.zeros((3, DEGREE + 1))
        for order in range(3):
            for k in range(order, DEGREE + 1):
                weights[order, k] = factorial(k) / factorial(k - order) * power[k - order]
        return np.asarray(np.einsum("rck,ok->orc", c, weights))


def kinematic(scene: Scene, names: Topology, drives: dict[str, list[str]]) -> Kinematic:
    """The kinematic coordinates of a scene.

    Args:
        drives: by joint one word a degree of freedom, see `muscles.ActuationMap`.
    """
    character = scene.character
    every = coordinate_names(names, character)[0]
    chosen: list[str] = []
    found = Kinematic(remaining=())
    remaining = [structs.FIXED] * len(names.bodies)

    def angles(body: int, which: Sequence[int]) -> None:
        for k in which:
            coordinate = names.coordinate_start[body] + k
            found.angle.append((coordinate, names.speed_start[body] + k, len(chosen)))
            chosen.append(every[coordinate])

    def turn(coordinate: int, speed: int, world: int) -> None:
        found.turn.append((coordinate, speed, len(chosen), world))
        chosen.extend(every[coordinate : coordinate + 4])

    root = root_type(character)
    remaining[0] = getattr(structs, root.device)
    if "root" in scene.motion and root.speeds:
        remaining[0] = structs.ROOT_PRESCRIBED
        angles(0, range(3))
        if root.placed:
            turn(3, 3, 1)
    for body, name in enumerate(names.joints, 1):
        entry = joint_type(character.joints[name])
        axes = [axis for axis, word in enumerate(drives[name]) if word == "kinematic"]
        remaining[body] = joint_number(name, character) if len(axes) < len(drives[name]) else structs.FIXED
        if not axes:
            continue
        movers = [i for i, driver in enumerate(names.driver) if driver == body]
        found.joint.extend((mover, sum(1 << axis for axis in axes)) for mover in movers)
        if entry.quaternion:
            turn(names.coordinate_start[body], names.speed_start[body], 0)
            continue
        angles(body, axes)
        if len(axes) < len(entry.speeds):
            remaining[body] = structs.SECOND_HINGE if axes == [0] else structs.HINGE
    return Kinematic(tuple(chosen), found.angle, found.turn, found.joint, tuple(remaining))


def speed_numbers(moving: Kinematic) -> list[int]:
    """Numbers of the speeds of the kinematic coordinates: angles and positions first, then those of quaternions."""
    return [entry[1] for entry in moving.angle] + [entry[1] + k for entry in moving.turn for k in range(3)]


def coordinate_numbers(moving: Kinematic) -> list[int]:
    """Numbers of the kinematic coordinates in the state, in their order, (C,)."""
    numbers = {entry[2]: entry[0] for entry in moving.angle}
    numbers |= {entry[2] + k: entry[0] + k for entry in moving.turn for k in range(4)}
    return [numbers[curve] for curve in range(len(moving.names))]


def moved(moving: Kinematic, curves: Curves, time: float) -> Moved:
    """Coordinates, speeds and accelerations of the kinematic coordinates at a time, s; see `kernels/body/motion.py`."""
    value, rate, bend = curves.rates(time)
    coordinates = value.copy()
    plain = [entry[2] for entry in moving.angle]
    speeds, accelerations = [rate[:, plain]], [bend[:, plain]]
    for _, _, curve, world in moving.turn:
        part = slice(curve, curve + 4)
        p = value[:, part]
        inverse = conjugate(p) / np.sum(p * p, axis=1, keepdims=True)
        a, b = (multiply(d, inverse) if world else multiply(inverse, d) for d in (rate[:, part], bend[:, part]))
        speeds.append(2.0 * a[:, :3])
        accelerations.append(2.0 * b[:, :3] - 4.0 * a[:, 3:] * a[:, :3])
        coordinates[:, part] = normalized(p)
    return Moved(coordinates, np.concatenate(speeds, axis=1), np.concatenate(accelerations, axis=1))


def spline_curves(moving: Kinematic, motions: Sequence[tuple[Floats, Floats, Sequence[int]]]) -> Curves:
    """Splines of fifth degree through knots, or of one less than there are knots.

    Args:
        motions: times (K,), s, values (rows, K, curves), and the numbers of those curves; all of them together.
    """
    from scipy.interpolate import make_interp_spline  # takes half a second, which only prescribed motions cost

    count = max((len(values) for _, values, _ in motions), default=1)
    quaternions = [entry[2] for entry in moving.turn]
    held, splines = [], []
    for time, values, numbers in motions:
        values = values.copy()
        for first in set(numbers).intersection(quaternions):
            at = list(numbers).index(first)
            values[:, :, at : at + 4] = _continuous(values[:, :, at : at + 4])
        if len(time) == 1:
            held.append((list(numbers), values))
        else:
            splines.append((list(numbers), make_interp_spline(time, values, k=min(DEGREE, len(time) - 1), axis=1)))
    start = np.zeros(1)
    if splines:
        start = np.unique(np.concatenate([np.unique(spline.t)[:-1] for _, spline in splines]))
    c = np.zeros((count, len(start), len(moving.names), DEGREE + 1))
    for numbers, values in held:
        c[:, :, numbers, 0] = values
    for numbers, spline in splines:
        for order in range(spline.k + 1):
            c[:, :, numbers, order] = spline(start, nu=order) / factorial(order)
    return Curves(start, c)


def _continuous(quaternions: Floats) -> Floats:
    """Quaternions (rows, K, 4) of unit length, each with the sign that is nearer to the one before."""
    q = normalized(quaternions)
    flips = np.where(np.sum(q[:, 1:] * q[:, :-1], axis=2) < 0.0, -1.0, 1.0)
    q[:, 1:] *= np.cumprod(flips, axis=1)[:, :, None]
    return q


def scene_curves(scene: Scene, names: Topology, moving: Kinematic, held: Floats) -> Curves:
    """The curves of a scene's motion; coordinates without one stay as they are held.

    Args:
        scene: checked scene whose numbers are floats, or (n,) arrays with one value an instance.
        held: (rows, coordinates) of the initial state.
    """
    numbers, motions = coordinate_numbers(moving), []
    place = {coordinate: curve for curve, coordinate in enumerate(numbers)}
    done: set[int] = set()
    for name, motion in scene.motion.items():
        body = names.body_of_joint(name)
        first, end = names.coordinate_start[body], names.coordinate_start[body + 1]
        own = [place[k] for k in range(first, end) if k in place]
        if not own:
            continue
        values = _knots(scene, name, motion, held[:, first:end])
        motions.append((np.asarray(motion.time, dtype=np.float64), values, own))
        done.update(own)
    rest = [curve for curve in range(len(numbers)) if curve not in done]
    if rest:
        motions.append((np.zeros(1), held[:, None, [numbers[curve] for curve in rest]], rest))
    return spline_curves(moving, motions)


def _knots(scene: Scene, name: str, motion: Motion, held: Floats) -> Floats:
    """Values (rows, K, coordinates) of a motion at its knots."""
    count = len(motion.time)
    if name != "root":
        if joint_type(scene.character.joints[name]).quaternion:
            return from_rotation_vector(rows(motion.rotation))
        lists = motion.value if isinstance(motion.value[0], list) else [motion.value]
        return np.moveaxis(rows(lists), 1, 2)
    root = root_type(scene.character)
    start = np.asarray(rows(scene.initial_state.root_position))
    position = rows(motion.position) if motion.position else np.repeat(start[:, None], count, axis=1)
    if not root.placed:
        turn = held[:, None, 2:]
        if motion.rotation:
            turn = np.unwrap(twist_angle(from_rotation_vector(rows(motion.rotation)), X_AXIS), axis=1)[:, :, None]
        return _beside(position[:, :, list(root.moving)], turn)
    rotation = from_rotation_vector(rows(motion.rotation)) if motion.rotation else held[:, None, 3:]
    return _beside(position, rotation)


def _beside(*parts: Floats) -> Floats:
    """Arrays (rows or 1, K or 1, k) side by side."""
    shape = np.broadcast_shapes(*(part.shape[:2] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[2])) for part in parts], axis=2)


def given_curves(
    moving: Kinematic, time: ArrayLike, values: ArrayLike, of: ArrayLike | None, instances: int, end: float
) -> Curves:
    """Curves through given knots, see `Rollout.set_motion`; `end` is the end of the simulated time, s.

    Raises:
        RolloutError: wrong shapes, values that are not finite, or knots that do not reach over the simulated time.
    """
    count = len(moving.names)
    if not count:
        raise RolloutError('the scene has no kinematic coordinates; name some with `drive = "kinematic"`')
    t, v = (
        as_array(given, name, error=RolloutError).astype(np.float64)
        for given, name in ((time, "time"), (values, "values"))
    )
    many = instances if of is None else max(len(v), 1) if v.ndim else 1
    if t.ndim != 1 or len(t) == 0 or v.shape not in ((1, count, len(t)), (many, count, len(t))):
        raise RolloutError(
            f"a motion of {number_of(count, 'coordinate')} takes times (K,) and values (1 or {many}, {count}, K), "
            f"not {t.shape} and {v.shape}"
        )
    check_knots(t, v, "motion")
    if len(t) > 1 and (t[0] > LATE or t[-1] < end - LATE):
        raise RolloutError(f"the motion reaches from {t[0]:g} to {t[-1]:g} s, the simulation from 0 to {end:g} s")
    for _, _, first, _ in moving.turn:
        if np.any(np.linalg.norm(v[:, first : first + 4], axis=1) < 1e-6):
            raise RolloutError(
                f"a quaternion of {moving.names[first].rpartition('.')[0]!r} in the motion has no length"
            )
    row = None
    if of is not None:
        row = as_array(of, "of", error=RolloutError)
        if row.shape != (instances,) or np.any(row != np.rint(row)) or np.any((row < 0) | (row >= len(v))):
            raise RolloutError(
                f"`of` takes the number of a motion, 0 to {len(v) - 1}, for each of {number_of(instances, 'instance')}"
            )
        row = row.astype(np.int32)
    curves = spline_curves(moving, [(t, np.moveaxis(v, 1, 2), range(count))])
    return Curves(curves.start, curves.coefficients, row)


def check_knots(time: Floats, values: Floats, what: str) -> None:
    """RolloutError unless times increase and all numbers are finite."""
    if not (np.isfinite(time).all() and np.isfinite(values).all()):
        raise RolloutError(f"a number of the {what} is not finite")
    if np.any(np.diff(time) <= 0.0):
        raise RolloutError(f"times of the {what} must increase")


def motion_struct(moving: Kinematic, curves: Curves, device: Any) -> structs.PrescribedMotion:
    """The device structure of prescribed motion (see `kernels.structs.PrescribedMotion`)."""
    m = structs.PrescribedMotion()
    m.start = to_device(curves.start, float, device)
    m.curve = to_device(curves.coefficients, structs.polynomial, device)
    m.row = to_device(np.zeros(0) if curves.row is None else curves.row, int, device)
    m.angle = to_device(np.reshape(moving.angle, (-1, 3)), int, device)
    m.turn = to_device(np.reshape(moving.turn, (-1, 4)), int, device)
    m.joint = to_device(np.reshape(moving.joint, (-1, 2)), int, device)
    m.remaining = to_device(moving.remaining, int, device)
    return m
