"""Bodies, joints and the root of a scene from a model's records."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.chain import displacement, row_of, set_function
from warpmuscle.formats.osim.frames import on_body, refused
from warpmuscle.formats.osim.moves import Coordinates, grouped
from warpmuscle.formats.osim.placement import Placed, Placement, quaternion, vector
from warpmuscle.formats.osim.records import Axis, Body, Coordinate, Model
from warpmuscle.formats.osim.tree import Branch
from warpmuscle.scene import Body as SceneBody
from warpmuscle.scene import Character, Coupling, InitialState, Joint, JointState, OpenSim

DIAGONAL = 1.0e-9  # of the largest moment: products of inertia below it come from rounding

POINT = 1.0e-9  # m^2, least moment of inertia over mass: of a body whose mass is in a point or on a line


@dataclass
class Skeleton:
    """Bodies and joints as they grow, with how they start."""

    character: Character
    placement: Placement
    initial: InitialState = field(default_factory=InitialState)
    opensim: OpenSim = field(default_factory=OpenSim)


def build_skeleton(model: Model, tree: list[Branch], root: str, coordinates: Coordinates, notes: Notes) -> Skeleton:
    """Bodies and joints of a tree.

    Args:
        root: see `tree.root_kind`.
        notes: gets the line of every body and joint.

    Raises:
        SceneError: a joint that cannot be represented, with file and line.
    """
    placement = Placement(model)
    skeleton = Skeleton(Character(root="ground", bodies={}, root_joint="fixed"), placement)
    skeleton.opensim.file = model.file.name
    skeleton.opensim.locked = {one.name: one.value for one in model.coordinates.values() if one.locked}
    skeleton.opensim.angles = [
        name for joint in model.joints for axis in joint.rotations for name in axis.coordinates if _plain(axis)
    ]
    if root == "fixed":
        skeleton.character.bodies["ground"] = SceneBody(0.0, (0.0, 0.0, 0.0))
    else:
        skeleton.character.root_joint = "free" if root == "free" else "planar"
    skeleton.opensim.ranges = {one.name: one.range for one in model.coordinates.values() if _bounded(one)}
    for branch in tree:
        if branch is tree[0] and root != "fixed":
            _root(model, branch, skeleton, coordinates, notes)
        else:
            _branch(model, branch, skeleton, coordinates, notes)
        notes.places[f"character.bodies.{branch.body.name}"] = (model.file, branch.body.line)
    for name in coordinates.couplers:
        if coordinates.of_several(name):
            continue
        argument, function = coordinates.master(name)
        if argument in skeleton.character.joints:
            coupling = Coupling(joint=argument)
            set_function(coupling, function)
            skeleton.opensim.couplers[name] = coupling
        elif not argument:
            skeleton.opensim.locked[name] = function.at(0.0)
    return skeleton


def _bounded(coordinate: Coordinate) -> bool:
    """Whether OpenSim keeps a coordinate within its range where it assembles a pose."""
    low, high = coordinate.range
    return coordinate.clamped and not coordinate.locked and low < high and math.isfinite(low) and math.isfinite(high)


def _plain(axis: Axis) -> bool:
    """Whether a turn is its coordinate itself, which OpenSim then counts as an angle, and has in degrees in files."""
    return axis.function.line is not None and abs(axis.function.line[1]) == 1.0


def _branch(model: Model, branch: Branch, skeleton: Skeleton, coordinates: Coordinates, notes: Notes) -> None:
    """The joints that lead to one body, and it."""
    joint, character = branch.joint, skeleton.character
    groups = grouped(branch.moves)
    own = {coordinate.name for coordinate in joint.coordinates}
    masters = {move.argument for move in branch.moves if move.argument} - own
    near, far = (on_body(model, frame) for frame in (branch.near, branch.far))
    parent = skeleton.placement.bodies[near[0]]
    row = row_of(joint.name, parent, near[1:], branch.body.name, far[1:], groups, masters)
    placed = Placed(branch.body.name, row.axes, branch.body.center)
    skeleton.placement.bodies[branch.body.path] = placed
    last = list(row.joints.values())[-1]
    last.position_in_child = vector(placed.point(row.end))
    for name, body in {**row.bodies, branch.body.name: _mass(model, branch.body, row.axes, notes)}.items():
        if name in character.bodies:
            raise refused(model, branch.body.line, f"two bodies would be called {name!r}; rename this one")
        character.bodies[name] = body
        notes.places[f"character.bodies.{name}"] = (model.file, branch.body.line)
    for name, made in row.joints.items():
        if made.type == "fixed" and (name in character.joints or name in ("root", "")):
            name = f"{branch.body.name}_weld"  # no coordinate has this name, so that it may be another one
        if name in character.joints or name in ("root", ""):
            raise refused(model, joint.line, f"two joints would be called {name!r}; rename a coordinate of this one")
        character.joints[name] = made
        notes.places[f"character.joints.{name}"] = (model.file, joint.line)
        if made.type != "fixed" and not made.follows:
            _coordinate(name, made, skeleton.initial, coordinates)


def _coordinate(name: str, joint: Joint, initial: InitialState, coordinates: Coordinates) -> None:
    """Limits of a joint, which are the range of its coordinate and push with no force; and its start."""
    coordinate = coordinates.by_name[name]
    low, high = coordinate.range
    joint.limit_stiffness = joint.limit_damping = 0.0
    if low < high and math.isfinite(low) and math.isfinite(high):
        joint.limits = [(low, high)]
    if coordinate.value == 0.0 and coordinate.speed == 0.0:
        return
    initial.joints[name] = state_at(joint, coordinate.value, coordinate.speed)


def state_at(joint: Joint, value: float, speed: float) -> JointState:
    """The state of a joint at a value of its coordinate."""
    if joint.type != "hinge":
        return JointState(coordinate=value, speed=speed)
    axis = np.array(joint.axes[0])
    x, y, z, w = (float(number) for number in about(axis, value))
    return JointState((x, y, z, w), vector(axis * speed))


def _root(model: Model, branch: Branch, skeleton: Skeleton, coordinates: Coordinates, notes: Notes) -> None:
    """A root that is free or planar, where it starts, and the joint that it is in the model."""
    near, far = (on_body(model, frame) for frame in (branch.near, branch.far))
    axes = skeleton.placement.world @ near[1]
    placed = Placed(branch.body.name, axes @ far[1].T, branch.body.center)
    skeleton.placement.bodies[branch.body.path] = placed
    skeleton.character.root = placed.name
    skeleton.character.bodies[placed.name] = _mass(model, branch.body, placed.axes, notes)
    at, own = vector(skeleton.placement.world @ near[2]), vector(placed.point(far[2]))
    kept = Joint("coupled", "ground", placed.name, at, own)
    turns = [move for move in branch.moves if move.turns]
    shifts = [move for move in branch.moves if not move.turns and move.argument]
    kept.rotations = [displacement(move.function, axes @ np.array(move.axis)) for move in turns]
    kept.translations = [displacement(move.function, axes @ np.array(move.axis)) for move in shifts]
    skeleton.opensim.root = kept
    skeleton.opensim.root_coordinates = [move.argument for move in (*turns, *shifts)]
    values = {name: coordinates.by_name[name] for name in skeleton.opensim.root_coordinates}
    turn, spin = np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3)
    for move, one in zip(turns, kept.rotations, strict=True):
        along = np.array(one.axis, dtype=float)
        spin = spin + rotate(turn, along) * values[move.argument].speed
        turn = multiply(turn, about(along, move.function.at(values[move.argument].value)))
    place, speed = np.array(at), np.zeros(3)
    for move, one in zip(shifts, kept.translations, strict=True):
        along = np.array(one.axis, dtype=float)
        place = place + along * move.function.at(values[move.argument].value)
        speed = speed + along * values[move.argument].speed
    lever = -rotate(turn, np.array(own))
    x, y, z, w = (float(value) for value in turn)
    skeleton.initial.root_orientation = (x, y, z, w)
    if skeleton.character.root_joint == "planar":  # which moves in the plane x = 0
        kept.position_in_parent = vector(np.array([-lever[0], at[1], at[2]]))
        aside = [np.array(move.axis) * move.value for move in branch.moves if not move.turns and not move.argument]
        skeleton.opensim.sideways = float(at[0] + lever[0] + sum((axes @ shift)[0] for shift in aside))
        place[0] = -lever[0]
    skeleton.initial.root_position = vector(place + lever)
    skeleton.initial.root_angular_velocity = vector(spin)
    skeleton.initial.root_velocity = vector(speed + np.cross(spin, lever))


def _mass(model: Model, body: Body, axes: Floats, notes: Notes) -> SceneBody:
    """Mass and principal moments of a body, whose axes ours are turned by a matrix, as OpenSim 4.6 takes them.

    Without mass there is no inertia; moments that no body has are computed with. Both are noted.

    Raises:
        SceneError: the mass is negative.
    """
    matrix = axes @ body.inertia @ axes.T
    if body.mass < 0.0:
        raise refused(model, body.line, f"body {body.name!r}: a mass of {body.mass:g} is none that a body has")
    if body.mass == 0.0:
        if np.any(matrix):
            reason = "has an inertia and no mass; it counts as one without both, as in OpenSim"
            notes.ignore(model.file, body.line, f"Body {body.name}", reason)
        return SceneBody(0.0, (0.0, 0.0, 0.0))
    moments, principal = np.diagonal(matrix).copy(), np.eye(3)
    largest = float(np.max(np.abs(matrix)))
    if largest > 0.0 and np.max(np.abs(matrix - np.diag(moments))) > DIAGONAL * largest:
        moments, principal = np.linalg.eigh(matrix)
        principal[:, 2] *= np.sign(np.linalg.det(principal))
    if np.any(moments < -DIAGONAL * largest):
        listed = ", ".join(f"{moment:g}" for moment in moments)
        reason = f"no body has moments of inertia of {listed} kg m^2; they are computed with, as in OpenSim"
        notes.ignore(model.file, body.line, f"Body {body.name}", reason)
    negative = moments < -DIAGONAL * largest
    moments = np.where(negative, moments, np.maximum(moments, POINT * body.mass))
    found = SceneBody(body.mass, vector(moments))
    if not np.array_equal(principal, np.eye(3)):
        found.inertia_axes = quaternion(principal)
    return found
