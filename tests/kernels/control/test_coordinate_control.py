"""PD control of joints of one coordinate: explicit by its formula, implicit as the explicit one of the step ahead."""

import numpy as np
import pytest
import warp as wp
from probes import filled, turn_about, units

from warpmuscle.kernels.control import coordinate_control
from warpmuscle.kernels.structs import FIRST_COORDINATE_JOINT, Contacts, Model, Scratch, Simbicon, Skeleton

TIME_STEP, N = 0.004, 8
KP, KD, BOUND = 300.0, 12.0, 400.0


@wp.kernel(enable_backward=False)
def driven(model: Model, work: Scratch):
    coordinate_control.coordinate_control_stage(0, 0, 1, model, work)


def efforts(implicit: bool, height: float = 1.0, bound: float = BOUND) -> tuple[np.ndarray, ...]:
    """Torques and inertias of N joints, and their numbers: axis, coordinate state, target and strength."""
    random = np.random.default_rng(8)
    axis, now, wanted = units(N, 2), random.normal(0.0, 0.7, (N, 3)), random.normal(0.0, 0.7, N)
    strength = random.uniform(0.4, 1.0, N)
    target = turn_about(axis, wanted)
    row = {"axis_a": axis[None]}
    gains = {"kp": np.full((1, N), KP), "kd": np.full((1, N), KD), "torque_limit": np.full((1, N), bound)}
    plan = {"joint_type": np.full(N, FIRST_COORDINATE_JOINT + 2)}
    model = filled(
        Model, body_count=N, time_step=TIME_STEP, implicit_pd=int(implicit),
        skeleton=filled(Skeleton, plan=plan, row=row), simbicon=filled(Simbicon, gains=gains),
        contacts=filled(Contacts, normal=[[(0.0, 1.0, 0.0)]], height=[[0.1]]),
    )  # fmt: skip
    place = np.zeros((N, 3))
    place[0, 1] = height + 0.1
    rotation = np.broadcast_to(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), (N, 3, 3))
    work = filled(
        Scratch, coordinate_state=now, strength=strength, target=target, rotation=rotation, position=place,
        torque=np.full((N, 3), 7.0), stiffness=np.full((N, 6), 7.0),
    )  # fmt: skip
    wp.launch(driven, 1, [model, work], device="cpu")
    return work.torque.numpy(), work.stiffness.numpy(), np.roll(axis, 1, axis=1), now, wanted, strength


def expected_of(now: np.ndarray, wanted: np.ndarray, strength: np.ndarray, implicit: bool) -> np.ndarray:
    """Torque on the parent: the damper holds the speed without what it has gained in the last half step."""
    speed = now[:, 1] - now[:, 2]
    ahead = now[:, 0] + (TIME_STEP * speed if implicit else 0.0)
    return strength * (KD * speed + KP * (ahead - wanted))


@pytest.mark.parametrize("implicit", [False, True])
def test_torque_is_that_of_a_spring_and_damper_within_its_bound(implicit: bool):
    torque, stiffness, axis, now, wanted, strength = efforts(implicit)
    plain = expected_of(now, wanted, strength, implicit)
    bounded = np.clip(plain, -BOUND, BOUND)
    assert 1 <= np.sum(np.abs(plain[1:]) > BOUND) + 1 < N - 1
    np.testing.assert_allclose(torque[1:], (axis * bounded[:, None])[1:], rtol=1e-4, atol=1e-3)
    np.testing.assert_array_equal(torque[0], 7.0)
    inertia = strength * TIME_STEP * (KD + TIME_STEP * KP) * (bounded == plain) * implicit
    full = inertia[:, None, None] * axis[:, :, None] * axis[:, None, :]
    np.testing.assert_allclose(stiffness[1:], full[1:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]], rtol=1e-4, atol=1e-7)


def test_bounds_cut_torques_and_leave_no_inertia():
    torque, stiffness, axis, *_ = efforts(True, bound=0.5)
    np.testing.assert_allclose(np.abs(np.sum(torque * axis, axis=1))[1:], 0.5, rtol=1e-4)
    np.testing.assert_array_equal(stiffness[1:], 0.0)


def test_a_fallen_body_goes_limp():
    torque, stiffness, *_ = efforts(True)
    for height, factor in ((0.3, 0.5), (0.15, 0.0)):
        weak, soft, *_ = efforts(True, height)
        np.testing.assert_allclose(weak[1:], factor * torque[1:], rtol=1e-4, atol=1e-4)
        np.testing.assert_allclose(soft[1:], factor * stiffness[1:], rtol=1e-4, atol=1e-7)
