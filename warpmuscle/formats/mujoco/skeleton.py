"""Bodies and joints of a scene from a compiled model; joints that an equality makes functions of others follow them."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.mujoco.reference import BALL, FREE, HINGE, SLIDE, WORLD, Moved, Reference
from warpmuscle.formats.osim.placement import direction, quaternion, vector
from warpmuscle.scene import Body, Character, Displacement, Joint

JOINT_EQUALITY = 2  # mjEQ_JOINT
POINT = 1.0e-9  # m^2, least moment of inertia over mass
DIAGONAL = 1.0e-9  # of the largest moment: products of inertia below it come from rounding
KINDS = {HINGE: "hinge", SLIDE: "slide", BALL: "ball"}

Follower = tuple[int, list[float]]  # the joint that another one follows, and its value as a polynomial of that one's


def held_joints(model: Any) -> dict[int, float]:
    """Values of joints that an equality holds, by number."""
    found = {}
    for eq in _joint_equalities(model):
        if model.eq_obj2id[eq] < 0:
            joint = int(model.eq_obj1id[eq])
            found[joint] = float(model.qpos0[model.jnt_qposadr[joint]] + model.eq_data[eq, 0])
    return found


def followers(model: Any, names: Any) -> dict[int, Follower]:
    """Joints that follow others by a polynomial, by number.

    Raises:
        SceneError: a joint follows one that follows another itself, or two others.
    """
    found: dict[int, Follower] = {}
    for eq in _joint_equalities(model):
        own, driver = int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq])
        if driver < 0:
            continue
        if own in found:
            raise SceneError(f"two equalities hold the joint {names(own)!r}; leave out one of them")
        at, rest = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (driver, own))
        shifted = np.polynomial.Polynomial(model.eq_data[eq, :5])(np.polynomial.Polynomial([-at, 1.0]))
        found[own] = driver, [float(c) for c in (shifted + rest).coef]
    for own, (driver, _) in found.items():
        if driver in found:
            message = f"the joint {names(own)!r} follows {names(driver)!r}, which follows another one itself"
            raise SceneError(f"{message}; let it follow that one")
    return found


def _joint_equalities(model: Any) -> list[int]:
    return [eq for eq in range(model.neq) if model.eq_type[eq] == JOINT_EQUALITY and model.eq_active0[eq]]


def free_root(reference: Reference, on_world: bool) -> int | None:
    """The body that is the scene's root by its free joint; None: the ground is a root that is fixed.

    Args:
        on_world: whether a path or a constraint is fixed to what does not move.
    """
    model = reference.model
    first = [lead for lead in reference.moved if lead != WORLD and reference.lead(model.body_parentid[lead]) == WORLD]
    if len(first) != 1 or on_world or model.body_jntnum[first[0]] != 1 or reference.moved[first[0]].mass == 0.0:
        return None
    return first[0] if model.jnt_type[model.body_jntadr[first[0]]] == FREE else None


def build_character(reference: Reference, root: int | None, follows: dict[int, Follower]) -> Character:
    """All bodies that move, with their joints.

    Raises:
        SceneError: nothing moves.
    """
    if len(reference.moved) < 2:
        raise SceneError("nothing in it moves: no body has a joint", file=reference.path)
    if root is None:
        character = Character(root="ground", bodies={"ground": Body(0.0, (0.0, 0.0, 0.0))}, root_joint="fixed")
    else:
        character = Character(root=reference.moved[root].name, bodies={})
    for lead, moved in reference.moved.items():
        if lead == WORLD:
            continue
        if lead != root:
            _chain(reference, lead, follows, character)
        character.bodies[moved.name] = _mass(moved)
    return character


def _chain(reference: Reference, lead: int, follows: dict[int, Follower], character: Character) -> None:
    """The joints between a body and what carries it, with bodies without mass between them."""
    model = reference.model
    carrier = reference.moved[reference.lead(model.body_parentid[lead])]
    own = reference.moved[lead]
    first = int(model.body_jntadr[lead])
    links: list[tuple[str, Joint, Floats]] = []
    for number in range(first, first + int(model.body_jntnum[lead])):
        links += _links(reference, number, follows)
    parent, origin = carrier.name, carrier.center
    for k, (name, joint, anchor) in enumerate(links):
        last = k == len(links) - 1
        child, center = (own.name, own.center) if last else (f"{own.name}_{name}", anchor)
        if not last:
            character.bodies[child] = Body(0.0, (0.0, 0.0, 0.0))
        joint.parent, joint.child = parent, child
        joint.position_in_parent, joint.position_in_child = vector(anchor - origin), vector(anchor - center)
        character.joints[name] = joint
        parent, origin = child, center


def _links(reference: Reference, number: int, follows: dict[int, Follower]) -> list[tuple[str, Joint, Floats]]:
    """The joints of a scene that stand for one of MuJoCo's, each with its place in the reference pose."""
    model, name = reference.model, reference.name("joint", number)
    kind, dof = int(model.jnt_type[number]), int(model.jnt_dofadr[number])
    anchor = reference.point(reference.data.xanchor[number])
    axis = direction(reference.axes @ reference.data.xaxis[number])
    resists = {"armature": float(model.dof_armature[dof]), "damping": float(model.dof_damping[dof])}
    if kind == FREE:
        moves = [(f"{name}_{'xyz'[k]}", _joint("slide", [tuple(reference.axes[:, k])], resists)) for k in range(3)]
        return [(own, joint, anchor) for own, joint in [*moves, (name, _joint("ball", [], resists))]]
    if number in reference.held:
        return [(name, _joint("fixed", [], {}), anchor)]
    if number in follows:
        driver, polynomial = follows[number]
        joint = _joint("coupled", [], resists)
        joint.follows = reference.name("joint", driver)
        (joint.rotations if kind == HINGE else joint.translations).append(Displacement(axis, polynomial=[*polynomial]))
        return [(name, joint, anchor)]
    joint = _joint(KINDS[kind], [axis] if kind in (HINGE, SLIDE) else [], resists)
    if model.jnt_limited[number] and kind in (HINGE, SLIDE):
        low, high = (float(end) for end in model.jnt_range[number])
        joint.limits = [(low, high)]
        stiffness, damping = _pushes(model.jnt_solref[number])
        weight = float(model.dof_invweight0[dof])
        joint.limit_stiffness, joint.limit_damping = stiffness / weight, damping / weight
    return [(name, joint, anchor)]


def _joint(kind: str, axes: list[Any], resists: dict[str, float]) -> Joint:
    """A joint whose bodies and places come later."""
    zero = (0.0, 0.0, 0.0)
    return Joint(kind, "", "", zero, zero, axes=[vector(np.array(axis)) for axis in axes], **resists)


def _pushes(solref: Floats) -> tuple[float, float]:
    """Stiffness, 1/s^2, and damping, 1/s, with which a constraint of MuJoCo pushes a unit of inertia."""
    first, second = (float(number) for number in solref)
    if first <= 0.0:
        return -first, -second
    return 1.0 / (first * second) ** 2, 2.0 / first


def _mass(moved: Moved) -> Body:
    """Mass and principal moments of what is welded together."""
    if moved.mass == 0.0 and not np.any(moved.inertia):
        return Body(0.0, (0.0, 0.0, 0.0))
    moments, principal = np.diagonal(moved.inertia).copy(), np.eye(3)
    if np.max(np.abs(moved.inertia - np.diag(moments))) > DIAGONAL * np.max(np.abs(moments)):
        moments, principal = np.linalg.eigh(moved.inertia)
        principal[:, 2] *= np.sign(np.linalg.det(principal))
    body = Body(moved.mass, vector(np.maximum(moments, POINT * moved.mass)))
    if not np.array_equal(principal, np.eye(3)):
        body.inertia_axes = quaternion(principal)
    return body
