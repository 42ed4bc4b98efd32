"""The tree of a model's bodies from the ground on, and which root of ours carries it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Ignored, Notes
from warpmuscle.formats.osim.chain import matrix
from warpmuscle.formats.osim.frames import GROUND, on_body
from warpmuscle.formats.osim.functions import IDENTITY
from warpmuscle.formats.osim.moves import Coordinates, Move, reversed_moves
from warpmuscle.formats.osim.placement import world_axes
from warpmuscle.formats.osim.records import Axis, Body, Coordinate, Frame, Joint, Model
from warpmuscle.formats.osim.skeleton import MOTIONS

PERPENDICULAR = 1.0e-6

HOLDING = ("Ligament", "Contact", "ElasticFoundation", "HuntCrossley", "Bushing", "Spring")  # in the names of classes


@dataclass(frozen=True)
class Branch:
    """A joint of the tree: between which frames it leads outwards, and what moves."""

    joint: Joint
    near: str  # frame on the side of the ground
    far: str
    body: Body  # which it carries
    moves: list[Move]
    backwards: bool  # from the joint's child to its parent


def branches(model: Model, coordinates: Coordinates) -> list[Branch]:
    """The joints in an order in which each begins at a body that the ones before it have reached.

    Args:
        model: with its bodies `joined` to the ground.
    """
    bodies = {body.path: body for body in model.bodies}
    reached, left, found = {GROUND}, list(model.joints), list[Branch]()
    while left:
        ends = {joint.name: tuple(on_body(model, f)[0] for f in (joint.parent, joint.child)) for joint in left}
        joint = next(joint for joint in left if reached.intersection(ends[joint.name]))
        near, far = ends[joint.name]
        backwards = near not in reached
        moves = coordinates.moves(joint)
        if backwards:
            far, moves = near, reversed_moves(moves)
        frames = (joint.child, joint.parent) if backwards else (joint.parent, joint.child)
        found.append(Branch(joint, *frames, bodies[far], moves, backwards))
        reached.add(far)
        left.remove(joint)
    return found


def joined(model: Model) -> list[str]:
    """Give bodies to which no joint leads from the ground the free joint that OpenSim gives them; their names.

    Of bodies that joints join, one gets it: the first that is no joint's child and the parent of the most joints, or,
    where all are children, the parent of the most (`chooseNewBaseBody` of Simbody's MultibodyGraphMaker).
    """
    ends = [(on_body(model, joint.parent)[0], on_body(model, joint.child)[0]) for joint in model.joints]
    bases: list[Body] = []
    while left := _unreached(model, ends, bases):
        children = {child for _, child in ends}
        first = [body for body in left if body.path not in children] or left
        alone = next((body for body in left if all(body.path not in both for both in ends)), None)
        bases.append(alone or max(first, key=lambda body: sum(parent == body.path for parent, _ in ends)))
    for body in bases:
        name, path = f"free_{body.name}", f"/jointset/free_{body.name}"
        own = tuple(
            Coordinate(f"{path}/{name}_coord_{k}", f"{name}_coord_{k}", body.line, 0.0, 0.0, (-10.0, 10.0), False, None)
            for k in range(6)
        )
        turns, shifts = MOTIONS["FreeJoint"]
        axes = [Axis(d, (own[k].name,), IDENTITY, body.line) for k, d in enumerate((*turns, *shifts))]
        model.joints.append(
            Joint("FreeJoint", name, path, body.line, GROUND, body.path, own, tuple(axes[:3]), tuple(axes[3:]))
        )
    return [body.name for body in bases]


def _unreached(model: Model, ends: list[tuple[str, str]], bases: list[Body]) -> list[Body]:
    """The bodies to which no joint leads from the ground or from some bodies, by the bodies at each joint's ends."""
    reached, left = {GROUND, *(body.path for body in bases)}, ends
    while now := [both for both in left if reached.intersection(both)]:
        reached.update(*now)
        left = [both for both in left if both not in now]
    return [body for body in model.bodies if body.path not in reached]


def root_kind(model: Model, tree: list[Branch], coordinates: Coordinates, needed: set[str], on_ground: bool) -> str:
    """Whether the first body may be a root that is free or planar; if not, the ground is one that is fixed.

    It may if nothing else hangs on the ground, if no coordinate of it is needed, locked, coupled or prescribed, and if
    it turns about perpendicular axes and moves along independent ones, one by one. Where one that moves in a plane is
    beside it makes no difference.

    Args:
        needed: coordinates on which something depends. on_ground: whether something is fixed to the ground.
    """
    first = [branch for branch in tree if on_body(model, branch.near)[0] == GROUND]
    if len(first) != 1 or on_ground or first[0].backwards or not first[0].body.mass > 0.0:
        return "fixed"
    (branch,) = first
    moves = [move for move in branch.moves if move.argument]
    if not _moves_one_by_one(branch, moves, needed | set(coordinates.couplers), coordinates):
        return "fixed"
    axes = world_axes(model.gravity) @ on_body(model, branch.near)[1]
    turns, shifts = (
        np.array([axes @ np.array(move.axis) for move in moves if move.turns == turning]).reshape(-1, 3)
        for turning in (True, False)
    )
    aside = [
        axes @ np.array(move.axis) if not move.turns else np.zeros(3) for move in branch.moves if not move.argument
    ]
    if len(turns) == len(shifts) == 3 and not aside:
        return "free" if _is_free(turns, shifts) else "fixed"
    if len(turns) == 1 and len(shifts) == 2:
        return "planar" if _is_planar(turns, shifts, aside) else "fixed"
    return "fixed"


def _moves_one_by_one(branch: Branch, moves: list[Move], needed: set[str], coordinates: Coordinates) -> bool:
    """Whether each coordinate of a branch is one of its moves, and nothing needs or prescribes it."""
    own = {coordinate.name for coordinate in branch.joint.coordinates}
    bound = needed | {name for name, one in coordinates.by_name.items() if one.prescribed}
    if own & bound or len({move.argument for move in moves}) < len(moves):
        return False
    return all(move.function.line is not None and move.function.line[1] == 1.0 for move in moves)


def _is_free(turns: Floats, shifts: Floats) -> bool:
    """Whether three axes of turns (3, 3) are perpendicular, and three of shifts (3, 3) independent."""
    perpendicular = np.allclose(turns @ turns.T, np.eye(3), atol=PERPENDICULAR)
    return bool(perpendicular and abs(np.linalg.det(shifts)) > PERPENDICULAR)


def _is_planar(turns: Floats, shifts: Floats, aside: list[Floats]) -> bool:
    """Whether a turn (1, 3) and two shifts (2, 3) are those of a sagittal plane, and what does not move lies aside."""
    flat = abs(abs(turns[0, 0]) - 1.0) < PERPENDICULAR and np.all(np.abs(shifts[:, 0]) < PERPENDICULAR)
    beside = all(abs(abs(axis[0]) - 1.0) < PERPENDICULAR for axis in aside)
    return bool(flat and beside and np.linalg.matrix_rank(shifts, PERPENDICULAR) == 2)


def merge_welds(model: Model, tree: list[Branch]) -> list[Branch]:
    """The tree without bodies that are welded to others, or locked: the motion is the same, a step has fewer bodies.

    The model gives their frames and masses to the bodies that carry them, and so what points, surfaces, contacts and
    markers there are on them. What hangs on the ground stays as it is.
    """
    kept: dict[str, Branch] = {}  # by the path of their body
    for branch in tree:
        near, rotation, place = on_body(model, branch.near)
        if near == GROUND or any(move.argument for move in branch.moves):
            kept[branch.body.path] = branch
            continue
        for move in branch.moves:
            if move.turns:
                rotation = rotation @ matrix(move.axis, move.value)
            else:
                place = place + rotation @ np.array(move.axis) * move.value
        _, turn, point = on_body(model, branch.far)
        axes = rotation @ turn.T
        own = model.frames[branch.body.path]
        model.frames[own.path] = Frame(own.path, own.line, near, axes, place - axes @ point)
        carrier = kept[near]
        kept[near] = replace(carrier, body=joined_body(carrier.body, branch.body, axes, place - axes @ point))
    left = list(kept.values())
    model.bodies[:] = [branch.body for branch in left]
    return left


def joined_body(body: Body, other: Body, axes: Floats, place: Floats) -> Body:
    """A body with another one fixed to it, whose axes (3, 3) and origin (3,) are given in the body's."""
    mass = body.mass + other.mass
    center = place + axes @ other.center
    if mass == 0.0:
        return body
    middle = (body.mass * body.center + other.mass * center) / mass
    inertia = body.inertia + axes @ other.inertia @ axes.T
    for part, at in ((body.mass, body.center), (other.mass, center)):
        inertia = inertia + part * _about(at - middle)
    return replace(body, mass=mass, center=middle, inertia=inertia)


def _about(r: Floats) -> Floats:
    """Moments of inertia of a unit mass at r about the origin."""
    return np.asarray(r @ r * np.eye(3) - np.outer(r, r))


def tell_loose(model: Model, tree: list[Branch], notes: Notes) -> None:
    """Note before anything else that a model cannot stand, if a joint is free to shift and lost what held it."""
    reasons = [text for branch in tree if (text := _loose(model, branch, _carried(model, tree, branch)))]
    if reasons:
        some = "; ".join(reasons[:4]) + (f"; and {len(reasons) - 4} more" if len(reasons) > 4 else "")
        reason = (
            f"this model cannot stand: nothing holds joints that are free to shift, {some}. Lock or couple their shifts"
        )
        notes.ignored.insert(0, Ignored(model.file, model.line, f"Model {model.name}", reason))


def _carried(model: Model, tree: list[Branch], branch: Branch) -> set[str]:
    """The names of a branch's body and of all that hang on it."""
    found = {branch.body.path}
    for other in tree:  # in which each comes after what it hangs on
        if on_body(model, other.near)[0] in found:
            found.add(other.body.path)
    return {path.rpartition("/")[2] for path in found}


def _loose(model: Model, branch: Branch, carried: set[str]) -> str:
    """What a joint within the body lost, if it is free to shift; else nothing."""
    own = {one.name for one in branch.joint.coordinates if one.prescribed is None}
    turns = {move.argument for move in branch.moves if move.turns}
    shifts = {move.argument for move in branch.moves if not move.turns and move.argument in own} - turns
    if not shifts or GROUND in [on_body(model, frame)[0] for frame in (branch.near, branch.far)]:
        return ""
    others = {body.name for body in model.bodies} - carried | {GROUND.rpartition("/")[2]}
    counts = Counter(
        lost.kind
        for lost in model.lost
        if lost.names & carried and lost.names & others and any(word in lost.kind for word in HOLDING)
    )
    if not counts:
        return ""
    what = ", ".join(f"{count} {kind}" for kind, count in counts.items())
    free = len({move.argument for move in branch.moves if move.argument})
    return f"{branch.joint.name} ({number_of(free, 'free coordinate')}) lost {what}"
