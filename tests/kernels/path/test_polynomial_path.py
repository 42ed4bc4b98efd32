"""Paths that are polynomials of joint angles: length, speed and moment arms by hand."""

import numpy as np

from muscle_arm import arm, leg
from warpmuscle.scene import Joint, Muscle, PolynomialPath, Scene
from warpmuscle.simulation.stages import Stages

GIVEN = {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1}
Q = np.linspace(-1.0, 1.0, 9)


def swung(scene: Scene, q: np.ndarray, v: np.ndarray) -> Stages:
    stages = Stages(scene, len(q), "cpu")
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, 7:] = q
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(v.astype(np.float32))
    return stages


def test_a_polynomial_of_one_angle():
    """l = 0.3 + 0.03 q - 0.01 q^3 beside other muscles; the arm about x is dl/dq."""
    scene = arm()
    polynomial = PolynomialPath(["elbow"], [[0], [1], [3]], [0.3, 0.03, -0.01])
    scene.character.muscles["fitted"] = Muscle(polynomial=polynomial, **GIVEN)
    paths = swung(scene, Q[:, None], np.full((9, 1), 2.0)).muscle_paths()
    slope = 0.03 - 0.03 * Q**2
    np.testing.assert_allclose(paths.length[:, 2], 0.3 + 0.03 * Q - 0.01 * Q**3, atol=1e-7)
    np.testing.assert_allclose(paths.speed[:, 2], 2.0 * slope, atol=1e-6)
    (crossing,) = (k for k, number in enumerate(paths.muscle) if number == 2)
    np.testing.assert_allclose(paths.moment_arm[:, crossing], slope[:, None] * [1.0, 0.0, 0.0], atol=1e-6)


def test_a_polynomial_of_three_angles_of_two_joints():
    """l = 0.4 + 0.02 a - 0.03 b k + 0.01 a b^2 + 0.015 k^2, of a universal hip (a, b) and a knee k."""
    scene, axes = leg(), [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    scene.character.joints["hip"] = Joint("universal", "pelvis", "thigh", (0.0, -0.05, 0.0), (0.0, 0.2, 0.0), axes)
    terms, numbers = [[0, 0, 0], [1, 0, 0], [0, 1, 1], [1, 2, 0], [0, 0, 2]], [0.4, 0.02, -0.03, 0.01, 0.015]
    polynomial = PolynomialPath(["hip", "hip", "knee"], terms, numbers, [0, 1, 0])
    scene.character.muscles = {"fitted": Muscle(polynomial=polynomial, **GIVEN)}
    rng = np.random.default_rng(1)
    q, v = rng.uniform(-0.8, 0.8, (2, 40, 3))
    stages = swung(scene, q, v)
    paths, pose = stages.muscle_paths(), stages.forward_kinematics()
    a, b, k = q.T
    gradient = np.stack([0.02 + 0.01 * b**2, -0.03 * k + 0.02 * a * b, -0.03 * b + 0.03 * k], axis=1)
    length = 0.4 + 0.02 * a - 0.03 * b * k + 0.01 * a * b**2 + 0.015 * k**2
    np.testing.assert_allclose(paths.length[:, 0], length, atol=2e-7)
    np.testing.assert_allclose(paths.speed[:, 0], np.sum(gradient * v, axis=1), atol=1e-6)
    relative = np.diff(pose["angular_velocity"].astype(float), axis=1)  # of the hip, and of the knee
    power = sum(np.sum(paths.moment_arm[:, n] * relative[:, joint], axis=1) for n, joint in enumerate(paths.joint))
    np.testing.assert_allclose(power, np.sum(gradient * v, axis=1), atol=1e-6)
