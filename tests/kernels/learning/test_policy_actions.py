"""Actions of a policy as excitations, efforts and PD torques, against the same formulas in float64."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled
from scipy.spatial.transform import Rotation

from warpmuscle.kernels.learning import policy_actions
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

N = 30


def launched(kernel: wp.Kernel, shape: tuple[int, int], *values: object) -> np.ndarray:
    """The last of a kernel's arrays."""
    given = [wp.array(v.astype(np.float32), device="cpu") if isinstance(v, np.ndarray) else v for v in values]
    wp.launch(kernel, shape, given, device="cpu")
    return given[-1].numpy()


def test_actions_become_excitations_synergies_and_efforts():
    random = np.random.default_rng(2)
    action, out = random.normal(size=(N, 4)), np.zeros((N, 4))
    got = launched(policy_actions.excite, (N, 4), action, 0.2, 0.6, out)
    np.testing.assert_allclose(got, np.clip(0.2 + 0.6 * action, 0.0, 1.0), atol=1e-6)
    assert {0.0, 1.0} < set(got.ravel().tolist())
    weights = random.uniform(0.0, 0.6, (4, 7))
    got = launched(policy_actions.excite_synergies, (N, 7), action, 0.2, 0.6, weights, np.zeros((N, 7)))
    np.testing.assert_allclose(got, np.clip(np.maximum(0.2 + 0.6 * action, 0.0) @ weights, 0.0, 1.0), atol=1e-6)
    middle = random.normal(size=4)
    got = launched(policy_actions.aim, (N, 4), action, middle, 3.5, np.full((N, 6), 8.0))
    np.testing.assert_allclose(got[:, :4], middle + 3.5 * action, atol=1e-5)
    np.testing.assert_array_equal(got[:, 4:], 8.0)


def test_what_a_policy_said_before_is_kept_and_what_is_no_number_is_nothing():
    told = np.array([[1.5, np.nan], [np.inf, -2e6]])
    action, previous = wp.array(np.float32([[0.1, 0.2], [0.3, 0.4]]), device="cpu"), wp.zeros((2, 2), device="cpu")
    inputs = [wp.array(told.astype(np.float32), device="cpu"), action, previous]
    wp.launch(policy_actions.take_actions, (2, 2), inputs, device="cpu")
    np.testing.assert_array_equal(previous.numpy(), np.float32([[0.1, 0.2], [0.3, 0.4]]))
    np.testing.assert_array_equal(action.numpy(), [[1.5, 0.0], [0.0, 0.0]])


def test_rotation_vectors_are_axis_times_angle_on_the_shorter_way_and_back():
    vector = np.random.default_rng(0).normal(0.0, 1.0, (200, 3))
    vector *= np.minimum(1.0, 3.1 / np.linalg.norm(vector, axis=1, keepdims=True))
    vector[:3] = (0.0, 0.0, 0.0), (1e-5, 0.0, 0.0), (3e-7, 0.0, 0.0)
    quaternion = Rotation.from_rotvec(vector).as_quat()
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(evaluate(policy_actions.rotation_vector, sign * quaternion), vector, atol=3e-6)
    np.testing.assert_allclose(evaluate(policy_actions.rotation_by, vector), quaternion, atol=1e-6)


TYPES = (ROOT_FREE, BALL, HINGE, UNIVERSAL, FIXED)
COORDINATES, SPEEDS = (0, 7, 11, 12, 14), (0, 6, 9, 10, 12)


@wp.kernel(enable_backward=False)
def efforts(model: Model, state: State, work: Scratch, effort: wp.array2d[wp.vec3]):
    i, body = wp.tid()
    effort[i, body] = policy_actions.target_effort(i, body + 1, model, state, work)


def test_joints_follow_their_targets_by_stiffness_and_damping_of_each_speed():
    random = np.random.default_rng(4)
    q, v = random.normal(0.0, 0.8, (N, 14)), random.normal(size=(N, 12))
    q[:, 7:11] /= np.linalg.norm(q[:, 7:11], axis=1, keepdims=True)
    target, kp, kd = random.normal(0.0, 0.8, (N, 6)), random.uniform(5.0, 50.0, (N, 6)), random.random((N, 6))
    ends = (*SPEEDS[1:], 12)
    plan = {"joint_type": TYPES, "coordinate_start": COORDINATES, "speed_start": SPEEDS, "speed_end": ends}
    model = filled(
        Model, skeleton=filled(Skeleton, plan=plan), actuation=filled(Actuation, effort=np.hstack([target, kp, kd]))
    )
    result = wp.zeros((N, 4), dtype=wp.vec3, device="cpu")
    inputs = [model, filled(State, coordinates=q, speeds=v), Scratch(), result]
    wp.launch(efforts, result.shape, inputs, device="cpu")
    error = target - np.hstack([np.zeros((N, 3)), q[:, 11:14]])
    now = Rotation.from_quat(q[:, 7:11])
    error[:, :3] = (now.inv() * Rotation.from_rotvec(target[:, :3])).as_rotvec()
    expected = kp * error - kd * v[:, 6:]
    got = result.numpy()
    np.testing.assert_allclose(got[:, 0], expected[:, :3], rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(got[:, 1, 0], expected[:, 3], rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(got[:, 2, :2], expected[:, 4:], rtol=1e-4, atol=1e-4)
    assert got[:, 1, 1:] == pytest.approx(0.0)
    assert got[:, 2, 2] == pytest.approx(0.0)
    assert got[:, 3] == pytest.approx(0.0)
