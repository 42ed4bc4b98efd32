"""Whether a step is short enough for the damping of a controller, and of springs in joints, that is explicit in it.

A speed v of inertia I that a torque -c v brakes over a step h keeps the share 1 - h c / I of it, which grows from step
to step beyond h c / I = 2. With the speeds of a joint, mass matrix M and damping C, that is an eigenvalue of h M^-1 C.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.controller import EVERY_OTHER, SIMBICON, declared_value
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import arguments, plain_number, plain_vector, world_poses
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.simbicon.damping import BOUND, simbicon_damping
from warpmuscle.scene.topology import topology

if TYPE_CHECKING:
    from warpmuscle.kernels.control.control import ExplicitDamping

AXES = np.eye(3)
MASSLESS = 1e-9  # of the largest inertia: speeds that carry nothing, such as of a body between two joints
SPRUNG = ("passive", "muscle", "assisted")  # degrees of freedom that springs act on, whose bound is SIMBICON's


class Explicit(NamedTuple):
    """How far a step is from where the explicit damping of a joint grows."""

    joint: str
    key: str  # of the scene, that gives the damping
    share: float  # largest eigenvalue of h M^-1 C, over its bound: beyond 1 speeds grow


def mass_matrix(scene: Scene) -> Floats:
    """Inertia (speeds, speeds) of a character as it starts, kg, kg m and kg m^2, in the order of its speeds.

    Args:
        scene: checked scene without free parameters.
    """
    character, names, poses = scene.character, topology(scene.character), world_poses(scene)
    turning, moving = np.zeros((2, len(names.bodies), names.speeds, 3))  # of each body at a unit of each speed, world
    root, moved = root_type(character), {}
    turning[0, range(len(root.moving), len(root.speeds))] = AXES[list(root.turning)]
    moving[0, range(len(root.moving))] = AXES[list(root.moving)]
    for name, joint in character.joints.items():
        moved[name] = joint_type(joint).start(joint, scene.initial_state.joints.get(name, JointState()))
    matrix = np.zeros((names.speeds, names.speeds))
    for body, name in enumerate(names.bodies):
        position, orientation = poses[name]
        if body:
            joint = character.joints[names.joints[body - 1]]
            parent = names.parents[body]
            above, turn = poses[names.bodies[parent]]
            motion = joint_type(joint).motion(joint, *arguments(joint, names.joints[body - 1], moved))
            speeds = names.arguments_of(body)[1]
            own = np.zeros((2, names.speeds, 3))
            own[0, speeds] = rotate(turn, np.array([one[0] for one in motion.turning]).reshape(-1, 3))
            own[1, speeds] = rotate(turn, np.array([one[0] for one in motion.moving]).reshape(-1, 3))
            place = position + rotate(orientation, plain_vector(joint.position_in_child))
            turning[body] = turning[parent] + own[0]
            moving[body] = moving[parent] + np.cross(turning[parent], place - above) + own[1]
            moving[body] += np.cross(turning[body], position - place)
        part = character.bodies[name]
        axes = rotate(multiply(orientation, plain_vector(part.inertia_axes)), AXES)  # rows: its principal axes
        along = turning[body] @ axes.T
        matrix += along * plain_vector(part.inertia) @ along.T + plain_number(part.mass) * moving[body] @ moving[body].T
    return matrix


def leg_length(scene: Scene) -> float:
    """Length of the left leg from hip to sole, m, as `kernels.control.walking.body.measure` has it.

    Args:
        scene: checked scene without free parameters.
    """
    character = scene.character
    assert character.feet is not None
    foot = character.feet[0]
    above = {joint.child: joint for joint in character.joints.values()}
    own, length = above[foot], 0.0
    for _ in range(2):  # shank and thigh
        upper = above[own.parent]
        length += float(np.linalg.norm(plain_vector(own.position_in_parent) - plain_vector(upper.position_in_child)))
        own = upper
    ankle, sole = above[foot], 0.0
    for name in (foot, *(joint.child for joint in character.joints.values() if joint.parent == foot)):
        joint = above[name]
        start = np.zeros(3) if name == foot else plain_vector(joint.position_in_parent)
        start = start - plain_vector(joint.position_in_child) - (name != foot) * plain_vector(ankle.position_in_child)
        for shape in character.bodies[name].shapes:
            heights = [plain_number(radius) - start[1] - plain_number(y) for (_, y, _), radius in contact_points(shape)]
            sole = max(sole, *heights)
    return length + sole


def is_explicit(scene: Scene) -> bool:
    """Whether a controller damps the joints by torques, explicit in the step."""
    return bound_of(scene) is not None and not scene.implicit_pd and not scene.character.muscles


def bound_of(scene: Scene) -> float | None:
    """What h M^-1 C may be with the controller of a scene; None if it has none that says so."""
    if scene.controller is None:
        return None
    if scene.controller.type == SIMBICON:
        return BOUND
    declared = _declared(scene.controller.type)
    return None if declared is None else declared.bound


def _declared(name: str) -> ExplicitDamping | None:
    """What a shipped controller says of its damping."""
    from warpmuscle.kernels.control.controllers import CONTROLLERS  # with Warp, for which others need not wait

    return CONTROLLERS[name].explicit if name in CONTROLLERS else None


def damping_of(scene: Scene) -> dict[str, tuple[str, Floats]]:
    """Damping of each speed of the joints that a controller drives, N m s/rad, and the key of the scene that gives it.

    Args:
        scene: checked scene without free parameters.
    """
    controller = scene.controller
    if controller is None or not is_explicit(scene):
        return {}
    declared = _declared(controller.type) if controller.type != SIMBICON else None
    return simbicon_damping(scene) if declared is None else _by_joint(scene, declared)


def _by_joint(scene: Scene, declared: ExplicitDamping) -> dict[str, tuple[str, Floats]]:
    """The same of a controller whose joints have a parameter for it."""
    assert scene.controller is not None
    table, parameter, unit = scene.controller.by_joint, declared.parameter, 1.0
    if declared.of_body:
        length, gravity = leg_length(scene), plain_number(scene.gravity)
        unit = body_mass(scene.character) * gravity * length * np.sqrt(length / gravity)
    found: dict[str, tuple[str, Floats]] = {}
    for name, joint in scene.character.joints.items():
        count, own = len(joint_type(joint).speeds), declared_value(table, name, parameter)
        if count:
            place = name if parameter in table.get(name, {}) else EVERY_OTHER
            value = 0.0 if own is None else plain_number(own)
            found[name] = (f"controller.by_joint.{place}.{parameter}", np.full(count, value * unit))
    return found


def may_have_springs(scene: Scene) -> bool:
    """Whether joints have springs that damp explicitly, for all that is known before free parameters have values."""
    implicit = scene.implicit_pd or scene.muscle_model.implicit_damping
    return not implicit and any(own.damping for own in scene.actuation.values())


def springs_of(scene: Scene) -> dict[str, tuple[str, Floats]]:
    """The same of the explicit springs of joints.

    Args:
        scene: checked scene without free parameters.
    """
    found: dict[str, tuple[str, Floats]] = {}
    if not may_have_springs(scene):
        return found
    for name, own in scene.actuation.items():
        count, damping = len(joint_type(scene.character.joints[name]).speeds), plain_number(own.damping)
        words = [own.drive] * count if isinstance(own.drive, str) else own.drive
        values = np.array([damping if word in SPRUNG else 0.0 for word in words])
        if values.any():
            found[name] = (f"actuation.{name}.damping", values)
    return found


def explicit_damping(scene: Scene) -> list[Explicit]:
    """Of each joint that a controller or a spring damps explicitly, how near it is to the bound, all other joints free.

    Args:
        scene: checked scene without free parameters.
    """
    names = topology(scene.character)
    damping = [(name, BOUND, *one) for name, one in springs_of(scene).items()]
    bound = bound_of(scene)
    if bound is not None:
        damping += [(name, bound, *one) for name, one in damping_of(scene).items()]
    if not damping:
        return []
    matrix = mass_matrix(scene)
    matrix += MASSLESS * matrix.max() * np.eye(len(matrix))
    mobility, found = np.linalg.inv(matrix), []
    for name, bound, key, values in damping:
        speeds = names.speeds_of(names.body_of_joint(name))
        root = np.sqrt(np.maximum(values, 0.0))
        largest = np.linalg.eigvalsh(root[:, None] * mobility[speeds, speeds] * root)[-1]
        share = float(scene.time_step * largest / bound)
        found.append(Explicit(name, key, share))
    return found


def damping_warnings(scene: Scene) -> list[SceneError]:
    """One for the joint whose explicit damping is furthest beyond what the steps bear; see `start.doubts_of`.

    Free parameters count with their start values.
    """
    if not is_explicit(scene) and not may_have_springs(scene):
        return []  # most scenes, which need not be copied
    found = explicit_damping(at_start(scene))
    worst = max(found, key=lambda one: round(one.share, 9), default=None)  # of both sides the first, whatever rounding
    if worst is None or not worst.share > 1.0:
        return []
    message = (
        f"steps of {scene.time_step:g} s are too long for the damping of {worst.joint}, which is explicit: its speed "
        f"may grow from step to step until the run diverges; set implicit_pd = true, or take steps of "
        f"{scene.time_step / worst.share:.2g} s"
    )
    return [SceneError(message, worst.key)]
