"""Turns, level directions, patterns and noise of reflexes by states of gait, against float64."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, matrix, turn_about, units
from scipy.spatial.transform import Rotation

from warpmuscle.core.arrays import records_to_device, structs_to_device
from warpmuscle.kernels.control import gait_patterns, gait_sensors
from warpmuscle.kernels.gait_state_structs import CONSTANT, FLAT, LINEAR, POLYNOMIAL, GaitPatternPlan, GaitThresholds

COUNT = 300


def test_a_turn_about_an_axis_is_that_part_of_the_rotation_vector():
    """SCONE, Sensors.cpp, BodyOrientationSensor: (R d) . log R; an axis of a rotation stays where it is, R r = r."""
    random = np.random.default_rng(3)
    turned, angle, axis = units(COUNT, 1), random.uniform(-3.1, 3.1, COUNT), units(COUNT, 2)
    angle[:5] = (0.0, 1e-7, -1e-7, 1e-3, -1e-3)
    q = turn_about(turned, angle)
    q[::2] *= -1.0  # the same rotation
    world = np.einsum("nij,nj->ni", matrix(q), axis)
    expected = np.einsum("ni,ni->n", world, turned * angle[:, None])
    found = evaluate(gait_sensors.turned_about, q, axis)
    np.testing.assert_allclose(found, expected, atol=2e-5)
    alone = evaluate(gait_sensors.turned_about, turn_about(turned, angle), turned)
    np.testing.assert_allclose(alone, angle, atol=2e-5)


def test_angles_of_a_turn_are_those_about_y_then_x_then_z():
    """SCONE, Sensors.cpp, BodyEulerOriSensor: about its y, z (right) and x (forwards), which are our y, -x and z."""
    random = np.random.default_rng(4)
    heading, lean, roll = random.uniform(-3.1, 3.1, COUNT), *random.uniform(-1.5, 1.5, (2, COUNT))
    about = [np.tile(axis, (COUNT, 1)) for axis in np.eye(3)]
    turned = matrix(turn_about(about[1], heading)) @ matrix(turn_about(about[0], lean))
    turned = turned @ matrix(turn_about(about[2], roll))
    q = Rotation.from_matrix(turned).as_quat()
    q[::2] *= -1.0
    found = evaluate(gait_sensors.turn_angles, q)
    np.testing.assert_allclose(found, np.stack([lean, heading, roll], axis=1), atol=1e-4)
    vector = Rotation.from_matrix(turned).as_rotvec()
    assert np.abs(found - vector).max() > 0.5


def test_a_level_direction_turns_with_the_root_and_has_no_height():
    """SCONE, Sensors.cpp, ComPivotPosSensor: of unit length in the ground's plane."""
    q, along = units(COUNT, 4, 4), units(COUNT, 5)
    level = np.einsum("nij,nj->ni", matrix(q), along) * (1.0, 0.0, 1.0)
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    np.testing.assert_allclose(evaluate(gait_sensors.level_direction, q, along), level, atol=1e-4)


@wp.kernel(enable_backward=False)
def values(
    time: wp.array[float], plan: wp.array[GaitPatternPlan], knot: wp.array2d[wp.vec2], found: wp.array3d[float]
):  # fmt: skip
    i, p, row = wp.tid()
    found[i, p, row] = gait_patterns.pattern_value(time[i], plan[p], knot, row)


def test_patterns_go_from_knot_to_knot():
    """SCONE, PieceWiseLinearFunction.h, PieceWiseConstantFunction.h, Polynomial.h: beyond the ends, too."""
    time = np.linspace(0.0, 1.2, 97)
    x, y = np.array([[0.0, 0.2, 0.5], [0.0, 0.3, 0.4]]), np.array([[0.1, 0.8, 0.3], [0.5, 0.2, 0.9]])
    plan = records_to_device(
        GaitPatternPlan, "cpu", first=[0] * 4 + [1], end=[3] * 4 + [2],
        shape=[LINEAR, FLAT, CONSTANT, POLYNOMIAL, LINEAR], states=[31] * 5,
    )  # fmt: skip
    knot = wp.array(np.float32(np.stack([x, y], axis=-1)), dtype=wp.vec2, device="cpu")
    found = wp.zeros((len(time), 5, 2), device="cpu")
    wp.launch(values, found.shape, [wp.array(np.float32(time), device="cpu"), plan, knot, found], device="cpu")
    for row in range(2):
        flat = np.interp(time, x[row], y[row])
        slope = (y[row, 2] - y[row, 1]) / (x[row, 2] - x[row, 1])
        beyond = np.maximum(time - x[row, 2], 0.0)
        steps = y[row][np.searchsorted(x[row] - 1e-6, time, side="right") - 1]
        polynomial = np.polynomial.polynomial.polyval(time, y[row])
        expected = np.stack([flat + slope * beyond, flat, steps, polynomial, np.full_like(time, y[row, 1])], axis=1)
        np.testing.assert_allclose(found.numpy()[:, :, row], expected, atol=1e-5)


@wp.kernel(enable_backward=False)
def noises(excitation: float, limits: wp.array[GaitThresholds], seed: int, found: wp.array2d[float]):
    muscle, step = wp.tid()
    found[muscle, step] = gait_patterns.noise_of(excitation, muscle, step, limits[0], seed)


def noise(excitation: float, base: float, share: float, seed: int = 123) -> np.ndarray:
    limits = structs_to_device(GaitThresholds, {"noise": [base], "noise_share": [share]}, "cpu")
    found = wp.zeros((4, 5000), device="cpu")
    wp.launch(noises, found.shape, [excitation, limits, seed, found], device="cpu")
    return found.numpy()


def test_noise_is_normal_and_grows_with_the_excitation():
    """SCONE, NoiseController.h: a standard deviation of base_noise + current_signal * proportional_noise."""
    found = noise(0.5, 0.02, 0.1)
    assert found.std() == pytest.approx(0.07, rel=0.03)
    assert abs(found.mean()) < 4.0 * 0.07 / np.sqrt(found.size)
    assert np.mean(np.abs(found) < 0.07) == pytest.approx(0.6827, abs=0.015)
    for other in (found[:, 1:] * found[:, :-1], found[1:] * found[:-1]):  # nor does one value tell of the next
        assert abs(other.mean()) < 4.0 * 0.07**2 / np.sqrt(other.size)
    np.testing.assert_array_equal(found, noise(0.5, 0.02, 0.1))
    assert (found != noise(0.5, 0.02, 0.1, seed=124)).mean() > 0.99
    assert not noise(0.5, 0.0, 0.0).any()
    assert not noise(-0.5, 0.02, 0.1).any()
