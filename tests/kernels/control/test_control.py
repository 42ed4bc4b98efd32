"""Efforts given from outside: by virtual power they are what was asked of each speed, and bad ones are named."""

import numpy as np
import warp as wp
from probes import filled, matrix, units

from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.control.control import NO_CONTROLLER, control_stage_of, damped_inertia
from warpmuscle.kernels.objective.causes import ENTRY, GIVEN_TORQUE
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    HINGE,
    ROOT_FREE,
    UNIVERSAL,
    Actuation,
    Model,
    Scratch,
    Skeleton,
    State,
)
from warpmuscle.model.controllers.outside import driven_from_outside

CONTROLLER = driven_from_outside(NO_CONTROLLER)
stage = control_stage_of(CONTROLLER)
Extension = CONTROLLER.extension
KINDS = [ROOT_FREE, HINGE, UNIVERSAL, FIXED, BALL]  # a chain
SPEEDS = [6, 1, 2, 0, 3]
AXIS_A, AXIS_B = units(5, 1), units(5, 2)


@wp.kernel(enable_backward=False)
def control(model: Model, state: State, work: Scratch, extension: Extension):
    own = extension
    its = work
    stage(0, 0, 1, model, state, its, own)


def driven(efforts: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Torques on the parents (5, 3) and rotations of the bodies (5, 3, 3) under efforts (6,); cause and flag."""
    ends = np.cumsum(SPEEDS)
    plan = {
        "joint_type": KINDS, "parent": [-1, 0, 1, 2, 3], "speed_start": ends - SPEEDS, "speed_end": ends,
    }  # fmt: skip
    skeleton = filled(Skeleton, plan=plan, row={"axis_a": AXIS_A[None], "axis_b": AXIS_B[None]})
    actuation = filled(Actuation, effort=np.float32(efforts)[None])
    model = filled(Model, body_count=5, skeleton=skeleton, actuation=actuation)
    state = filled(State, cause=np.zeros(1, np.int32), step=np.zeros(1, np.int32))
    turned = matrix(units(5, 3, 4))
    work = filled(
        Scratch, rotation=np.float32(turned), torque=np.full((5, 3), 7.0, np.float32), flags=np.zeros(2, np.int32),
        target=np.zeros((5, 4), np.float32),
    )  # fmt: skip
    work.stiffness = wp.zeros(5, dtype=symmetric, device="cpu")
    wp.launch(control, 1, [model, state, work, Extension()], device="cpu")
    return work.torque.numpy(), turned, int(state.cause.numpy()[0]), int(work.flags.numpy()[1])


def test_the_power_of_a_torque_is_that_of_the_efforts_at_every_speed():
    efforts = np.array([3.0, -2.0, 5.0, 0.7, -1.1, 4.0])
    torque, turned, cause, flag = driven(efforts)
    along = {  # angular velocities of the child in the parent at a unit of each speed, world
        1: [turned[1] @ AXIS_A[1]],
        2: [turned[2] @ AXIS_A[2], turned[1] @ AXIS_B[2]],
        4: list(turned[4].T),
    }
    power = [-torque[body] @ axis for body, axes in along.items() for axis in axes]  # on the child, not the parent
    np.testing.assert_allclose(power, efforts, atol=1e-5)
    for body, axes in along.items():  # and nothing across what the joint can do
        across = torque[body] - np.linalg.lstsq(np.array(axes).T, torque[body], rcond=None)[0] @ np.array(axes)
        np.testing.assert_allclose(across, 0.0, atol=1e-5)
    np.testing.assert_array_equal(torque[[0, 3]], 0.0)
    assert (cause, flag) == (0, 0)


def test_an_effort_that_is_no_number_ends_the_instance_and_names_its_joint():
    for column, body in enumerate([1, 2, 2, 4, 4, 4]):
        efforts = np.ones(6)
        efforts[column] = np.nan
        assert driven(efforts)[2:] == (GIVEN_TORQUE + body * ENTRY, 1)


@wp.kernel(enable_backward=False)
def inertia_of(model: Model, work: Scratch, damping: wp.array[wp.vec3], found: wp.array[symmetric]):
    body = wp.tid()
    its, m = work, model
    found[body] = damped_inertia(0, body, damping[body], m, its)


def test_damping_adds_inertia_to_each_speed_and_none_between_them():
    """J^T K J = h diag(c) of the angular velocities J at a unit of each speed, which of a universal joint are askew."""
    damping, turned, step = np.random.default_rng(6).uniform(0.5, 3.0, (5, 3)), matrix(units(5, 3, 4)), 0.002
    plan = {"joint_type": KINDS, "parent": [-1, 0, 1, 2, 3]}
    skeleton = filled(Skeleton, plan=plan, row={"axis_a": AXIS_A[None], "axis_b": AXIS_B[None]})
    model, work = filled(Model, skeleton=skeleton, time_step=step), filled(Scratch, rotation=np.float32(turned))
    given = wp.array(np.float32(damping), dtype=wp.vec3, device="cpu")
    found = wp.zeros(5, dtype=symmetric, device="cpu")
    wp.launch(inertia_of, 5, [model, work, given, found], device="cpu")
    full = found.numpy().reshape(5, 6)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(5, 3, 3)
    along = {
        1: turned[1] @ AXIS_A[1][:, None],
        2: np.stack([turned[2] @ AXIS_A[2], turned[1] @ AXIS_B[2]], axis=1),
        4: turned[4],
    }
    for body, axes in along.items():
        expected = step * np.diag(damping[body, : axes.shape[1]])
        np.testing.assert_allclose(axes.T @ full[body] @ axes, expected, atol=1e-8)
    np.testing.assert_array_equal(full[3], 0.0)
