"""Torques and pulls written as expressions, against the axis, the points and the function that they name."""

import msgspec
import numpy as np
import pytest
import warp as wp
from probes import filled, matrix, units

from small_scene import muscle_scene
from warpmuscle.kernels.force.expressions import PointExpression, TorqueExpression, point_expression, torque_expression
from warpmuscle.kernels.muscle_structs import Muscles
from warpmuscle.kernels.structs import Model, Scratch, Skeleton, State
from warpmuscle.model.expressions.programs import expression_tables
from warpmuscle.scene import Force

STEP, STEPS = 0.01, 30  # s, and how many have been made


@wp.kernel(enable_backward=False)
def turn(given: TorqueExpression, model: Model, state: State, work: Scratch, result: wp.array[wp.vec3]):
    second = wp.tid()
    its = work
    result[second] = torque_expression(0, second, 1 - second, second, model, state, its, given).moment


@wp.kernel(enable_backward=False)
def pull(given: PointExpression, model: Model, state: State, work: Scratch, result: wp.array[wp.vec3]):
    second = wp.tid()
    its = work
    result[second] = point_expression(0, second, 1 - second, second, model, state, its, given).force


def test_a_pull_between_points_is_the_expression_of_their_distance():
    force = Force("point_expression", expressions={"tension": "3*d"})
    table, starts = expression_tables(msgspec.structs.replace(muscle_scene(), forces={"pull": force}))
    places = np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0]])
    model = filled(Model, time_step=STEP, skeleton=filled(Skeleton, row={"com": np.zeros((1, 2, 3))}))
    model.muscles = filled(Muscles, curve_table=np.float32(table))
    still = np.zeros((2, 3), np.float32)
    work = filled(
        Scratch, rotation=np.tile(np.eye(3, dtype=np.float32), (2, 1, 1)), position=np.float32(places),
        velocity=still, angular_velocity=still,
    )  # fmt: skip
    result = wp.zeros(2, dtype=wp.vec3, device="cpu")
    given = filled(PointExpression, scale=2.0, **starts["pull"])
    wp.launch(pull, 2, [given, model, filled(State, step=np.int32([0])), work, result], device="cpu")
    expected = 2.0 * 3.0 * 0.5 * np.array([0.6, 0.8, 0.0])
    np.testing.assert_allclose(np.abs(result.numpy()), np.abs([expected, expected]), rtol=1e-4)
    np.testing.assert_allclose(result.numpy()[0], -result.numpy()[1], rtol=1e-4)


@pytest.mark.parametrize("in_body", [0.0, 1.0])
def test_a_torque_turns_one_body_and_the_other_one_back_about_one_axis(in_body: float):
    force = Force("torque_expression", expressions={"torque": "2 + 5*t"})
    table, starts = expression_tables(msgspec.structs.replace(muscle_scene(), forces={"turn": force}))
    axis, rotation = np.array([0.6, 0.0, 0.8]), matrix(units(2, 4, 4))
    named = {"axis_x": axis[0], "axis_y": axis[1], "axis_z": axis[2], "in_body": in_body, "scale": 1.5}
    given = filled(TorqueExpression, **named, **starts["turn"])
    model = filled(Model, time_step=STEP)
    model.muscles = filled(Muscles, curve_table=np.float32(table))
    result = wp.zeros(2, dtype=wp.vec3, device="cpu")
    state, work = filled(State, step=np.int32([STEPS])), filled(Scratch, rotation=np.float32(rotation))
    wp.launch(turn, 2, [given, model, state, work, result], device="cpu")
    about = rotation[0] @ axis if in_body else axis  # of the first body, for both
    expected = 1.5 * (2.0 + 5.0 * STEP * STEPS) * about
    np.testing.assert_allclose(result.numpy(), [expected, -expected], rtol=0.02)
