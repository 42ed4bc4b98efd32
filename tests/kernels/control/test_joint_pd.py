"""PD of every joint towards its own angle: efforts by their formula, and a hanging body where statics has it."""

import numpy as np
import pytest
import warp as wp
from probes import filled, units
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from muscle_arm import ABOUT_JOINT, MASS, REACH, arm
from warpmuscle.kernels.control.joint_pd import JointGains, joint_pd_effort
from warpmuscle.kernels.structs import BALL, FIXED, HINGE, ROOT_FIXED, UNIVERSAL, Model, Scratch, Skeleton, State
from warpmuscle.scene import Actuation, Controller, JointState
from warpmuscle.simulation.rollout import Rollout

KINDS = (ROOT_FIXED, HINGE, UNIVERSAL, BALL, FIXED)
COORDINATES, SPEEDS = np.array([7, 1, 2, 4, 0]), np.array([0, 1, 2, 3, 0])
KP, KD, ANGLE = 50.0, 3.0, 0.4


@wp.kernel(enable_backward=False)
def asked(model: Model, state: State, work: Scratch, gains: JointGains, effort: wp.array2d[wp.vec3]):
    i, body = wp.tid()
    effort[i, body] = joint_pd_effort(i, body, model, state, work, gains)


def test_efforts_are_those_of_a_spring_and_a_damper_along_every_speed():
    n, random = 6, np.random.default_rng(3)
    q, v = random.normal(0.0, 0.7, (n, COORDINATES.sum())), random.normal(0.0, 2.0, (n, SPEEDS.sum()))
    ends, speed_ends = np.cumsum(COORDINATES), np.cumsum(SPEEDS)
    ball = slice(ends[2], ends[3])
    q[:, ball] = units(n, 4, 4)
    plan = {
        "joint_type": KINDS, "coordinate_start": ends - COORDINATES, "speed_start": speed_ends - SPEEDS,
        "speed_end": speed_ends,
    }  # fmt: skip
    model = filled(Model, body_count=len(KINDS), skeleton=filled(Skeleton, plan=plan))
    gains = JointGains()
    gains.kp, gains.kd, gains.angle = KP, KD, ANGLE
    effort = wp.zeros((n, len(KINDS)), dtype=wp.vec3, device="cpu")
    inputs = [model, filled(State, coordinates=q, speeds=v), Scratch(), gains, effort]
    wp.launch(asked, effort.shape, inputs, device="cpu")
    wanted = np.zeros((n, len(KINDS), 3))
    wanted[:, 1, 0] = KP * (ANGLE - q[:, 7]) - KD * v[:, 0]
    wanted[:, 2, 0] = KP * (ANGLE - q[:, 8]) - KD * v[:, 1]
    wanted[:, 2, 1] = -KP * q[:, 9] - KD * v[:, 2]
    wanted[:, 3] = KP * Rotation.from_quat(q[:, ball]).inv().as_rotvec() - KD * v[:, 3:6]
    np.testing.assert_allclose(effort.numpy(), wanted, rtol=1e-4, atol=1e-3)


def test_a_hanging_body_comes_to_rest_where_the_spring_bears_its_weight():
    gains = {"others": {"kp": 30.0, "kd": 4.0, "angle": 0.9}}
    scene = arm(actuation={"elbow": Actuation("torque")}, controller=Controller(type="joint_pd", by_joint=gains))
    scene.duration = 3.0
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    at_rest = brentq(lambda x: 30.0 * (0.9 - x) - MASS * 9.8 * REACH * np.sin(x), 0.0, 0.9)
    assert rollout.state.coordinates.numpy()[0, 7] == pytest.approx(at_rest, abs=1e-3)
    assert np.abs(rollout.state.speeds.numpy()).max() < 1e-3


STEP, STEPS = 0.002, 60  # s


def braked(share: float, implicit: bool) -> np.ndarray:
    """Speed of a joint, rad/s, (STEPS,), that a damping c alone brakes from 1 rad/s; share: h c / I."""
    gains = {"others": {"kp": 0.0, "kd": share * ABOUT_JOINT / STEP, "angle": 0.0}}
    scene = arm(actuation={"elbow": Actuation("torque")}, controller=Controller(type="joint_pd", by_joint=gains))
    scene.gravity, scene.time_step, scene.implicit_pd, scene.duration = 0.0, STEP, implicit, STEPS * STEP
    scene.initial_state.joints["elbow"] = JointState(angular_velocity=(1.0, 0.0, 0.0))
    rollout, found = Rollout(scene, 1, "cpu"), []
    for _ in range(STEPS):
        rollout.run(STEP)
        found.append(float(rollout.state.speeds.numpy()[0, 0]))
    return np.array(found)


@pytest.mark.parametrize("implicit", [False, True])
@pytest.mark.parametrize("share", [0.3, 0.95, 1.05])
def test_damping_brakes_as_leapfrog_has_it_and_speeds_grow_beyond_the_bound_where_it_is_explicit(
    share: float, implicit: bool
):
    speed, last, expected = 1.0, 0.0, []  # in float64
    for n in range(STEPS):
        change = share * (implicit * last - speed) / (1.0 + share * implicit)
        middle = speed - 0.5 * last + change * (0.5 if n == 0 else 1.0)
        speed, last = middle + 0.5 * change, change
        expected.append(speed)
    found = braked(share, implicit)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-5)
    grows = share > 1.0 and not implicit
    assert (np.abs(found[-10:]).max() > np.abs(found[:10]).max()) == grows


def test_damping_that_is_implicit_stops_a_joint_in_steps_that_are_far_too_long_for_it():
    found = np.abs(braked(50.0, True))
    assert found.max() <= 1.0
    assert found[-1] < 1e-6
