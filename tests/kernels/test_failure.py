"""When an instance has failed."""

import numpy as np
from probes import evaluate

from warpmuscle.kernels.objective import has_fallen, has_turned


def test_fallen_is_below_a_fraction_of_the_first_height_or_not_a_number():
    height = np.array([1.0, 0.91, 0.9, 0.89, -1.0, np.nan])
    assert evaluate(has_fallen, height, 1.0, 0.9).tolist() == [0, 0, 0, 1, 1, 1]


def test_turned_is_too_far_from_the_desired_heading_on_the_shorter_way():
    angle, desired = np.array([0.0, 0.7, -0.7, 0.9, -0.9, 3.1, -3.1, 3.1]), np.array([0.0] * 6 + [3.1, 0.0])
    assert evaluate(has_turned, angle, desired, 0.8).tolist() == [0, 0, 0, 1, 1, 1, 0, 1]


def test_without_a_largest_turn_nobody_has_turned():
    assert evaluate(has_turned, np.array([3.0, np.nan]), 0.0, 0.0).tolist() == [0, 0]
    assert evaluate(has_turned, np.array([np.nan]), 0.0, 0.8).tolist() == [1]
