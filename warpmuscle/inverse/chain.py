"""A scene's body as a chain of turns and shifts, each by a function of one coordinate of the model.

Coordinates are those of OpenSim's models: the root's turns and shifts, and those of its joints, by name. Locked ones
do not move, coupled ones follow; neither is free. Axes are those of scenes, x to the left, y up, z forward.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.pose import about, multiply, normalized, rotate
from warpmuscle.scene import Displacement, Joint, JointState, OpenSim, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import span_of
from warpmuscle.scene.joints.displacement import TURN, depends, pieces, rates
from warpmuscle.scene.opensim_root import root_values, usual_root
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology

Pieces = tuple[Floats, Floats]  # where they start (P,), and their coefficients (P, 4)
LINE: Pieces = (np.zeros(1), np.array([[0.0, 1.0, 0.0, 0.0]]))
GROUND = -1


@dataclass(frozen=True)
class Element:
    """A turn about an axis, or a shift along it."""

    parent: int  # element that carries it; GROUND: none
    turns: bool
    axis: Floats  # (3,) in the parent's axes
    offset: Floats  # (3,) m, of its origin from that of its parent
    coordinate: int  # number of the free coordinate that moves it; -1: none
    function: Pieces


@dataclass(frozen=True)
class Place:
    """A point that an element carries."""

    element: int
    point: Floats  # (3,) m, from the element's origin, in its axes


@dataclass
class Chain:
    """A body without masses: how it moves, and where its markers are."""

    coordinates: list[str] = field(default_factory=list)  # free ones, those of the root first
    neutral: list[float] = field(default_factory=list)  # where they start, rad or m
    low: list[float] = field(default_factory=list)
    high: list[float] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)  # parents first
    bodies: dict[str, Place] = field(default_factory=dict)  # their origins
    markers: dict[str, Place] = field(default_factory=dict)
    opensim: OpenSim = field(default_factory=OpenSim)
    _resting: dict[str, Floats] = field(default_factory=dict)

    def resting(self, names: Sequence[str]) -> Floats:
        """Where markers are (K, 3), m, in the pose that the model starts in."""
        if not self._resting:  # found once: recordings of a thousand strides ask for it
            found = self.places(self.poses(np.array([self.neutral])), list(self.markers.values()))[0]
            self._resting = dict(zip(self.markers, found, strict=True))
        return np.stack([self._resting[name] for name in names])

    def poses(self, values: Floats) -> tuple[Floats, Floats]:
        """Orientations (F, N, 4) and origins (F, N, 3) of all elements at coordinates (F, C)."""
        frames = len(values)
        turns, origins = np.empty((frames, len(self.elements), 4)), np.empty((frames, len(self.elements), 3))
        for k, one in enumerate(self.elements):
            turn, origin = _carrier(turns, origins, one.parent)
            amount = evaluate(one.function, values[:, one.coordinate] if one.coordinate >= 0 else np.zeros(frames))[0]
            origin = origin + rotate(turn, one.offset)
            turns[:, k] = multiply(turn, about(one.axis, amount)) if one.turns else turn
            origins[:, k] = origin if one.turns else origin + rotate(turn, one.axis) * amount[:, None]
        return turns, origins

    def places(self, poses: tuple[Floats, Floats], points: list[Place]) -> Floats:
        """Where points are (F, K, 3), m, in poses as of `poses`."""
        found = [origin + rotate(turn, p.point) for p in points for turn, origin in (_carrier(*poses, p.element),)]
        return np.stack(found, axis=1) if found else np.zeros((len(poses[0]), 0, 3))

    def jacobian(self, values: Floats, points: list[Place]) -> Floats:
        """Velocities (F, K, 3, C) of points by a unit rate of each coordinate."""
        poses = self.poses(values)
        at = self.places(poses, points)
        found = np.zeros((*at.shape, len(self.coordinates)))
        for k, one in enumerate(self.elements):
            if one.coordinate < 0:
                continue
            moved = [m for m, p in enumerate(points) if self.carries(k, p.element)]
            axis = rotate(_carrier(*poses, one.parent)[0], one.axis)
            rate = evaluate(one.function, values[:, one.coordinate])[1]
            by = axis[:, None] if not one.turns else np.cross(axis[:, None], at[:, moved] - poses[1][:, k, None])
            column = found[..., one.coordinate]
            column[:, moved] += rate[:, None, None] * by
        return found

    def carries(self, element: int, other: int) -> bool:
        """Whether an element is another one, or carries it."""
        while other > element:
            other = self.elements[other].parent
        return other == element

    def all_values(self, values: Floats) -> tuple[tuple[str, ...], Floats]:
        """Names and values (F, A) of all coordinates of the model, also locked and coupled ones."""
        numbers = {name: k for k, name in enumerate(self.coordinates)}
        for name in (*self.opensim.couplers, *self.opensim.locked):
            if name in self.opensim.locked or self.opensim.couplers[name].joint in numbers:
                numbers.setdefault(name, len(numbers))
        found = np.empty((len(values), len(numbers)))
        found[:, : len(self.coordinates)] = values
        for name, coupling in self.opensim.couplers.items():
            if name in numbers and coupling.joint in numbers:
                found[:, numbers[name]] = rates(coupling, found[:, numbers[coupling.joint]])[0]
        for name, value in self.opensim.locked.items():
            found[:, numbers[name]] = value
        return tuple(numbers), found


def evaluate(function: Pieces, q: Floats) -> tuple[Floats, Floats]:
    """Value and derivative (F,) of a function."""
    start, c = function
    piece = np.maximum(np.searchsorted(start, q, side="right") - 1, 0)
    t, (c0, c1, c2, c3) = q - start[piece], c[piece].T
    return c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3)


def chain_of(scene: Scene) -> Chain:
    """The chain of a scene's character; free parameters count with their start values.

    Raises:
        SceneError: a joint of a type whose pose is no turn and shift by functions of coordinates.
    """
    return plain_chain(at_start(scene))


def plain_chain(scene: Scene) -> Chain:
    """The same of a scene without free parameters."""
    builder = _Builder(scene)
    for name in topology(scene.character).joints:
        builder.add(name)
    return builder.done()


class _Builder:
    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        opensim = scene.opensim if scene.opensim is not None else usual_root(scene.character)
        self._chain, self._singles = Chain(opensim=opensim), dict[str, int]()
        self._root(opensim)

    def _root(self, opensim: OpenSim) -> None:
        """The root's joint to the ground; its ranges do not count, so that a subject may walk anywhere."""
        chain, state, root = self._chain, self._scene.initial_state, opensim.root
        if root is None:
            place = np.array([float(x) for x in state.root_position])  # type: ignore[arg-type]
            chain.bodies[self._scene.character.root] = Place(GROUND, place)
            return
        start = root_values(opensim, rows(list(state.root_position)), normalized(rows(list(state.root_orientation))))
        for name, value in zip(opensim.root_coordinates, start[0], strict=True):
            self._coordinate(name, float(value), None)
        numbers = range(len(opensim.root_coordinates))
        shifts = list(numbers[len(root.rotations) :])
        at = _vector(root.position_in_parent) + np.array([opensim.sideways, 0.0, 0.0])
        end = self._moves(Place(GROUND, at), root, list(numbers), shifts)
        chain.bodies[self._scene.character.root] = Place(end.element, end.point - _vector(root.position_in_child))

    def add(self, name: str) -> None:
        """One joint, whose parent has its place, and its child."""
        chain, joint = self._chain, self._scene.character.joints[name]
        carrier = chain.bodies[joint.parent]
        at = Place(carrier.element, carrier.point + _vector(joint.position_in_parent))
        kind = joint_type(joint)
        if kind.name == "ball":
            at = self._ball(at, name, joint)
        elif kind.name == "universal":
            own = [self._new_coordinate(f"{name}_{word}", name, joint, k) for k, word in enumerate(kind.angles)]
            a, b = (axis[0] for axis in kind.frame(joint))
            at = self._element(self._element(at, True, b, own[1], LINE), True, a, own[0], LINE)
        elif kind.name == "hinge":
            at = self._element(at, True, kind.frame(joint)[0][0], self._single(name), LINE)
        elif kind.name == "slide":
            at = self._element(at, False, kind.frame(joint)[0][0], self._single(name), LINE)
        elif joint.beside:
            message = f"markers cannot be fitted through a joint that depends on two coordinates, as {name!r} does"
            raise SceneError(message, key=f"joints.{name}")
        elif kind.name == "coupled":
            number = self._single(joint.follows or name)
            count = len(joint.rotations) + len(joint.translations)
            at = self._moves(at, joint, [number] * count, [number] * len(joint.translations))
        elif kind.name != "fixed":
            raise SceneError(f"markers cannot be fitted through a joint of type {kind.name!r}", key=f"joints.{name}")
        chain.bodies[joint.child] = Place(at.element, at.point - _vector(joint.position_in_child))

    def _ball(self, at: Place, name: str, joint: Joint) -> Place:
        """Turns about three axes, as the model has them, or about x, y and z."""
        opensim, kind = self._chain.opensim, joint_type(joint)
        ball = opensim.balls.get(name)
        names = ball.names if ball is not None else tuple(f"{name}_{word}" for word in kind.angles)
        axes = list(np.eye(3))
        if ball is not None:
            swing, twist = (axis[0] for axis in kind.frame(joint))
            axes = [swing, np.cross(swing, twist) * (-1.0 if ball.turned_round else 1.0), twist]
        for k, (axis, one) in enumerate(zip(axes, names, strict=True)):
            at = self._element(at, True, axis, self._new_coordinate(one, name, joint, k), LINE)
        return at

    def _moves(self, at: Place, joint: Joint, numbers: list[int], shifts: list[int]) -> Place:
        """The shifts and turns of a coupled joint, or of the root, by coordinates with these numbers."""
        for shift, number in zip(joint.translations, shifts, strict=True):
            at = self._displacement(at, False, joint, shift, number)
        for turn, number in zip(joint.rotations, numbers, strict=False):
            at = self._displacement(at, True, joint, turn, number)
        return at

    def _displacement(self, at: Place, turns: bool, joint: Joint, one: Displacement, number: int) -> Place:
        span = TURN
        if joint.type == "coupled" and joint.parent in self._scene.character.bodies:
            driver = self._scene.character.joints[joint.follows] if joint.follows else joint
            span = span_of(joint, driver)
        start, c = pieces(one, span)
        axis = np.asarray(normalized(rows(one.axis))[0])
        if depends(one):
            return self._element(at, turns, axis, number, (start, c[0]))
        value = float(c[0, 0, 0])
        if turns:
            return at if value == 0.0 else self._element(at, True, axis, -1, (start, c[0]))
        return Place(at.element, at.point + axis * value)

    def _element(self, at: Place, turns: bool, axis: Floats, number: int, function: Pieces) -> Place:
        elements = self._chain.elements
        elements.append(Element(at.element, turns, np.asarray(axis, np.float64), at.point, number, function))
        return Place(len(elements) - 1, np.zeros(3))

    def _single(self, name: str) -> int:
        """The number of the only coordinate of a joint, which may be known from one before it that follows it."""
        if name not in self._singles:
            self._singles[name] = self._new_coordinate(name, name, self._scene.character.joints[name], 0)
        return self._singles[name]

    def _new_coordinate(self, coordinate: str, name: str, joint: Joint, axis: int) -> int:
        """The number of a coordinate of a joint, which is new."""
        kind = joint_type(joint)
        q, _ = kind.start(joint, self._scene.initial_state.joints.get(name, JointState()))
        ball = self._chain.opensim.balls.get(name)
        angles = q[0] if kind.scalars else (kind.angles_of(joint, q) if ball else kind.shown(joint, q, q[:, :3]))[0]
        if ball is not None and ball.turned_round:
            angles = angles * [1.0, -1.0, 1.0]
        limits = None
        if self._scene.opensim is not None:
            limits = self._scene.opensim.ranges.get(coordinate)
        elif axis < len(joint.limits) and kind.scalars:
            limits = tuple(float(first_number(x)) for x in joint.limits[axis])  # type: ignore[assignment]
        return self._coordinate(coordinate, float(angles[axis]), limits)

    def _coordinate(self, name: str, value: float, limits: tuple[float, float] | None) -> int:
        chain = self._chain
        chain.coordinates.append(name)
        low, high = limits if limits is not None else (-np.inf, np.inf)
        chain.low.append(low)
        chain.high.append(high)
        chain.neutral.append(min(max(value, low), high))
        return len(chain.coordinates) - 1

    def done(self) -> Chain:
        chain = self._chain
        for name, marker in chain.opensim.markers.items():
            body = chain.bodies[marker.body]
            chain.markers[name] = Place(body.element, body.point + _vector(marker.position))
        return chain


def _carrier(turns: Floats, origins: Floats, element: int) -> tuple[Floats, Floats]:
    """Orientation (F, 4) and origin (F, 3) of an element, or of the ground."""
    if element < 0:
        return np.tile([0.0, 0.0, 0.0, 1.0], (len(turns), 1)), np.zeros((len(turns), 3))
    return turns[:, element], origins[:, element]


def _vector(given: object) -> Floats:
    return np.array([float(x) for x in given])  # type: ignore[attr-defined]
