"""What the types of a scene cannot say about bodies, their tree, massless ones and joints that follow others."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import LEAST_MOMENT
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.scene import Body, Box, Character, Joint, Scene, Shape
from warpmuscle.scene.joints import TYPES, joint_type
from warpmuscle.scene.masses import is_zero, massless
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import carried, followers, joints_by_parent, topology
from warpmuscle.scene.validation.checks import Checks, known, near
from warpmuscle.scene.validation.motion import kinematic_axes

_ANY = (0.61, -0.37, 0.83, 0.42)  # coordinates at which no axes meet by chance


def check_skeleton(checks: Checks) -> None:
    """Bodies and joints are sound and make a tree whose every joint moves something that has mass.

    Raises:
        SceneError: the first thing wrong, with its key, such as `character.bodies.toes.mass`.
    """
    character = checks.checked.character
    known(character.root, character.bodies, "body", "character.root")
    for name, body in character.bodies.items():
        _body(checks, f"character.bodies.{name}", body)
    for name, joint in character.joints.items():
        key = f"character.joints.{name}"
        if name == "root":
            raise SceneError("a joint cannot be called root: that name stands for the root body", key=key)
        known(joint.parent, character.bodies, "body", f"{key}.parent")
        known(joint.child, character.bodies, "body", f"{key}.child")
        _joint(checks, key, joint)
    _tree(character)
    for name, joint in character.joints.items():
        if joint.follows:
            _follower(f"character.joints.{name}", joint, character)
    if any(massless(body) for body in character.bodies.values()):
        _moves_mass(character, _held(checks.checked))
        _independent(at_start(checks.checked).character, _held(checks.checked))


def _body(checks: Checks, key: str, body: Body) -> None:
    """A body has mass and inertia, or none of both, and proper shapes."""
    if not massless(body):
        if is_zero(body.mass):
            raise SceneError("must be greater than 0, or 0 along with all of the body's inertia", key=f"{key}.mass")
        checks.positive(f"{key}.mass", body.mass)
        for index, moment in enumerate(body.inertia):
            if checks.checked.opensim is None:  # which computes with moments that no body has
                checks.positive(f"{key}.inertia.{index}", moment, LEAST_MOMENT)
    checks.not_zero(f"{key}.inertia_axes", body.inertia_axes, "quaternion")
    for index, shape in enumerate(body.shapes):
        _shape(checks, f"{key}.shapes.{index}", shape)


def _shape(checks: Checks, key: str, shape: Shape) -> None:
    """A box has its corners in order."""
    if isinstance(shape, Box):
        for index, (low, high) in enumerate(zip(shape.low, shape.high, strict=True)):
            checks.ordered(f"{key}.low.{index}", low, high)


def _joint(checks: Checks, key: str, joint: Joint) -> None:
    """A joint has the axes and limits of its type."""
    if joint.type not in TYPES:
        kinds = ", ".join(map(repr, sorted(TYPES)))
        raise SceneError(f"{joint.type!r} is none of {kinds}{near(joint.type, TYPES)}", key=f"{key}.type")
    if joint.follows and not TYPES[joint.type].displaced:
        raise SceneError(f"a coupled joint can follow another one, a {joint.type} joint cannot", key=f"{key}.follows")
    if (joint.beside or joint.rate_only) and not (joint.follows and joint.beside):
        raise SceneError("only a joint that follows another one has a second one beside it", key=f"{key}.beside")
    joint_type(joint).check(checks, key, joint)
    for index, (low, high) in enumerate(joint.limits):
        checks.ordered(f"{key}.limits.{index}", low, high)
    for field in ("armature", "damping"):
        if joint.type in ("universal", "fixed") and getattr(joint, field) != 0.0:
            raise SceneError(f"a {joint.type} joint takes no {field}; make it of hinges", key=f"{key}.{field}")


def _tree(character: Character) -> None:
    """Every body hangs on exactly one joint, all the way from the root."""
    joint_of: dict[str, str] = {}
    for name, joint in character.joints.items():
        key = f"character.joints.{name}.child"
        if joint.child == character.root:
            raise SceneError(f"body {joint.child!r} is the root and cannot be a child", key=key)
        if joint.child in joint_of:
            raise SceneError(f"body {joint.child!r} is a child of joint {joint_of[joint.child]!r} already", key=key)
        joint_of[joint.child] = name
    for body in character.bodies:
        visited = [body]
        while visited[-1] != character.root:
            if visited[-1] not in joint_of:
                raise SceneError(
                    f"no joint connects it to the root {character.root!r}", f"character.bodies.{visited[-1]}"
                )
            joint_name = joint_of[visited[-1]]
            parent = character.joints[joint_name].parent
            if parent in visited:
                loop = " -> ".join([parent, *reversed(visited[visited.index(parent) :])])
                raise SceneError(f"joints make a loop: {loop}", key=f"character.joints.{joint_name}.parent")
            visited.append(parent)


def _follower(key: str, joint: Joint, character: Character) -> None:
    """A joint follows one that has a single coordinate of its own."""
    key = f"{key}.follows"
    known(joint.follows, character.joints, "joint", key)
    driver = character.joints[joint.follows]
    if driver.follows:
        raise SceneError(f"{joint.follows!r} follows {driver.follows!r} itself; name that one instead", key=key)
    if joint_type(driver).scalars != 1:
        raise SceneError(f"{joint.follows!r} is a {driver.type} joint, which has no single coordinate", key=key)
    if joint.beside:
        known(joint.beside, character.joints, "joint", f"{key.removesuffix('follows')}beside")
        other = character.joints[joint.beside]
        if other.follows or joint_type(other).scalars != 1 or joint.beside == joint.follows:
            message = f"{joint.beside!r} is no other joint with a single coordinate of its own"
            raise SceneError(message, key=f"{key.removesuffix('follows')}beside")
    if joint.parent == joint.child:
        raise SceneError(f"hangs on its own child {joint.child!r}", key=key)


def _held(scene: Scene) -> set[str]:
    """Joints whose motion is prescribed, which no force moves."""
    counts = {name: len(joint_type(joint).speeds) for name, joint in scene.character.joints.items()}
    return {name for name, count in counts.items() if 0 < count == len(kinematic_axes(scene, name))}


def weightless(character: Character) -> list[str]:
    """Joints that move nothing that has mass."""
    names = topology(character)
    found = []
    for name, joint in character.joints.items():
        if joint_type(joint).moves:
            beyond = {body for mover in (name, *followers(character, name)) for body in carried(mover, names)}
            if all(massless(character.bodies[names.bodies[body]]) for body in beyond):
                found.append(name)
    return found


def _moves_mass(character: Character, held: set[str]) -> None:
    """Every joint that forces move, and a root that they do, carries something that has mass."""
    if massless(character.bodies[character.root]) and character.root_joint != "fixed":
        message = f"a root that moves has mass; give it some, or make root_joint fixed, not {character.root_joint}"
        raise SceneError(message, key=f"character.bodies.{character.root}.mass")
    for name in weightless(character):
        if name not in held:
            message = (
                f"joint {name!r} moves nothing that has mass; give this body mass, hang one that has some on it, "
                f"or prescribe the joint's motion"
            )
            raise SceneError(message, key=f"character.bodies.{character.joints[name].child}.mass")


def _independent(character: Character, held: set[str]) -> None:
    """Joints of several bodies without mass in a row move the next one in different ways."""
    children = joints_by_parent(character)
    for first, joint in character.joints.items():
        if massless(character.bodies[joint.parent]) and joint.parent != character.root:
            continue
        row = [first]
        while massless(character.bodies[character.joints[row[-1]].child]):
            beyond = children.get(character.joints[row[-1]].child, [])
            if len(beyond) != 1:
                break
            row += beyond
        if len(row) > 1 and any(character.joints[name].follows for name in row):
            continue
        row = [name for name in row if name not in held]
        if len(row) > 1 and not _has_full_rank(_axes([character.joints[name] for name in row])):
            message = (
                f"the joints {', '.join(map(repr, row))}, with nothing that has mass between them, move "
                f"{character.joints[row[-1]].child!r} in the same way; leave out one of them, or give this body mass"
            )
            raise SceneError(message, key=f"character.bodies.{joint.child}.mass")


def _axes(joints: list[Joint]) -> Floats:
    """Motions (6, S) that the speeds of joints in a row give the last child: turning, and moving of its last joint."""
    turn, place = np.array([[0.0, 0.0, 0.0, 1.0]]), np.zeros((1, 3))
    columns: list[tuple[Floats, Floats, Floats]] = []
    for index, joint in enumerate(joints):
        kind = joint_type(joint)
        q = np.array([[*_ANY, *_ANY][index % 4 :][: len(kind.coordinates)]])
        motion = kind.motion(joint, q, np.zeros((1, len(kind.speeds))))
        place = place + rotate(turn, rows(joint.position_in_parent) + motion.place)
        columns += [
            (np.asarray(rotate(turn, t)), np.asarray(rotate(turn, m)), place)
            for t, m in zip(motion.turning, motion.moving, strict=True)
        ]
        turn = multiply(turn, motion.orientation)
        place = place - rotate(turn, rows(joint.position_in_child))
    twists = [np.concatenate([t, m + np.cross(t, place - at)], axis=1) for t, m, at in columns]
    return np.concatenate([np.zeros((0, 6)), *twists]).T


def _has_full_rank(axes: Floats) -> bool:
    scaled = axes / np.maximum(np.linalg.norm(axes, axis=0), 1e-12)
    return bool(np.linalg.matrix_rank(scaled, 1e-4) == scaled.shape[1])
