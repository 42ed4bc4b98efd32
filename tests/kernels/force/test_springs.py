"""Spring-dampers of joints: their torque on the parent, and what they are implicit by, in float64."""

import numpy as np
import pytest
import warp as wp
from probes import filled, matrix, turn_about, units, vectors

from warpmuscle.kernels.force.actuation import JointDrive
from warpmuscle.kernels.force.springs import ANY_SPRINGS, SPRINGS
from warpmuscle.kernels.structs import BALL, FIRST_OF_TABLE, ROOT_FREE, Actuation, Model, Scratch, Skeleton

STIFFNESS, DAMPING, STEP = 70.0, 3.0, 0.01
add_any, add_one = ANY_SPRINGS.add, SPRINGS.add


@wp.kernel(enable_backward=False)
def add(
    any_joint: bool, passive: wp.mat33, before: wp.vec3, model: Model, work: Scratch, torque: wp.array[wp.vec3],
    inertia: wp.array[wp.mat33],
):  # fmt: skip
    drive = JointDrive()
    drive.torque = before
    its = work
    if any_joint:
        add_any(0, 1, 0, its.rotation[1], drive, passive, model, its)
    else:
        add_one(0, 1, 0, its.rotation[1], drive, passive, model, its)
    torque[0] = drive.torque
    inertia[0] = drive.inertia


def sprung(any_joint: bool, kind: int, implicit: int, passive: np.ndarray, rest: np.ndarray, **now: np.ndarray):
    """Torque on the parent and implicit inertia of the joint of body 1."""
    plan = {"joint_type": [ROOT_FREE, kind], "parent": [-1, 0]}
    row = {"axis_a": np.stack([np.zeros(3), now.pop("axis")])[None]}
    actuation = filled(
        Actuation, rest=np.float32([[[0, 0, 0, 1], rest]]), stiffness=np.float32([[0.0, STIFFNESS]]),
        damping=np.float32([[0.0, DAMPING]]),
    )  # fmt: skip
    model = filled(
        Model, body_count=2, implicit_pd=implicit, time_step=STEP, skeleton=filled(Skeleton, plan=plan, row=row),
        actuation=actuation,
    )  # fmt: skip
    work = filled(Scratch, **{name: np.float32(value) for name, value in now.items()})
    torque, inertia = wp.zeros(1, dtype=wp.vec3, device="cpu"), wp.zeros(1, dtype=wp.mat33, device="cpu")
    wp.launch(
        add, 1, [any_joint, wp.mat33(passive), wp.vec3(1.0, 2.0, 3.0), model, work, torque, inertia], device="cpu"
    )
    return torque.numpy()[0] - [1.0, 2.0, 3.0], inertia.numpy()[0]


@pytest.mark.parametrize("implicit", [0, 1])
def test_a_spring_along_a_coordinate_pulls_to_its_rest_as_one_of_a_line_does(implicit: int):
    """On the parent k (q - rest) + d q' along the axis, the child's being the opposite; implicit: at the step's end."""
    axis, q, speed, rest = units(1, 5)[0], 0.3, -1.7, -0.2
    turned = units(2, 6, 4)
    frames = matrix(turned)
    along = frames[1] @ axis
    torque, inertia = sprung(
        True, FIRST_OF_TABLE, implicit, np.outer(along, along), turn_about(axis, np.array([rest]))[0], axis=axis,
        rotation=frames, orientation=turned, joint_velocity=np.stack([np.zeros(3), speed * along]),
        coordinate_state=np.array([[0.0, 0.0, 0.0], [q, speed, 0.0]]),
    )  # fmt: skip
    damping = DAMPING + implicit * STEP * STIFFNESS
    np.testing.assert_allclose(torque, along * (STIFFNESS * (q - rest) + damping * speed), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(inertia, implicit * STEP * damping * np.outer(along, along), atol=1e-6)


@pytest.mark.parametrize("implicit", [0, 1])
@pytest.mark.parametrize("any_joint", [False, True])
def test_a_spring_of_a_ball_joint_turns_the_short_way_to_its_rest(any_joint: bool, implicit: int):
    """With child = parent * rest * (a turn by an angle about the child's axis): on the parent k angle axis + d w."""
    axis, angle = units(1, 7)[0], 0.02
    parent, rest = units(2, 8, 4)
    child = product(product(parent, rest), turn_about(axis, np.array([angle]))[0])
    turned, spin = np.stack([parent, child]), vectors(1, 9)[0]
    frames = matrix(turned)
    torque, inertia = sprung(
        any_joint, BALL, implicit, np.eye(3), rest, axis=axis, rotation=frames, orientation=turned,
        joint_velocity=np.stack([np.zeros(3), spin]), coordinate_state=np.zeros((2, 3)),
    )  # fmt: skip
    damping = DAMPING + implicit * STEP * STIFFNESS
    np.testing.assert_allclose(torque, STIFFNESS * angle * (frames[1] @ axis) + damping * spin, rtol=1e-3, atol=2e-3)
    np.testing.assert_allclose(inertia, implicit * STEP * damping * np.eye(3), atol=1e-6)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of two quaternions xyzw."""
    vector = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.array([*vector, a[3] * b[3] - a[:3] @ b[:3]])
