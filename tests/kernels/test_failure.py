"""When an instance has failed."""

import numpy as np
from probes import evaluate

from warpmuscle.kernels.failure import has_fallen, has_turned, nearest_on_the_way


def test_fallen_is_below_a_fraction_of_the_first_height_or_not_a_number():
    height = np.array([1.0, 0.91, 0.9, 0.89, -1.0, np.nan])
    assert evaluate(has_fallen, height, 1.0, 0.9).tolist() == [0, 0, 0, 1, 1, 1]


def test_turned_is_too_far_from_the_desired_heading_on_the_shorter_way():
    angle, desired = np.array([0.0, 0.7, -0.7, 0.9, -0.9, 3.1, -3.1, 3.1]), np.array([0.0] * 6 + [3.1, 0.0])
    assert evaluate(has_turned, angle, desired, 0.8).tolist() == [0, 0, 0, 1, 1, 1, 0, 1]


def test_without_a_largest_turn_nobody_has_turned():
    assert evaluate(has_turned, np.array([3.0, np.nan]), 0.0, 0.0).tolist() == [0, 0]
    assert evaluate(has_turned, np.array([np.nan]), 0.0, 0.8).tolist() == [1]


def test_whole_revolutions_are_no_turn_and_the_rest_of_several_is():
    turns = np.array([-5.0, -2.0, -1.0, 1.0, 2.0, 7.0]) * 2.0 * np.pi
    assert not any(evaluate(has_turned, np.full(6, 0.3), 0.3 + turns, 0.8))
    assert all(evaluate(has_turned, np.full(6, 0.3), 1.3 + turns, 0.8))
    assert all(evaluate(has_turned, np.full(6, -2.9), 2.4 + turns, 0.8))
    assert not any(evaluate(has_turned, np.full(6, -2.9), 2.8 + turns, 0.8))


def test_on_the_way_to_the_desired_heading_nobody_is_off_it():
    angle = np.array([0.0, 1.0, 2.0, 3.0, -1.0, -3.0])
    found = evaluate(nearest_on_the_way, angle, 0.0, 2.0)
    np.testing.assert_allclose(found, [0.0, 1.0, 2.0, 2.0, 0.0, 0.0], atol=1e-6)
    back = evaluate(nearest_on_the_way, np.array([3.0, -3.0, -2.0, 2.0]), 2.9, -2.9 - 2.0 * np.pi)
    np.testing.assert_allclose(np.cos(back - [3.0, -3.0, -2.9, 2.9]), 1.0, atol=1e-6)
