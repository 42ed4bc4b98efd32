"""Options of trainings that begin where another one ended."""

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.learning.options import PPOOptions, bounded, options_of


def test_a_learning_rate_that_single_precision_has_put_below_its_bound_is_taken_as_the_bound():
    ended = float(np.float32(5e-5))
    assert ended < PPOOptions().min_learning_rate
    with pytest.raises(Error, match="learning_rate must lie between"):
        options_of({"learning_rate": ended})
    assert options_of(bounded({"learning_rate": ended}, {})).learning_rate == 5e-5


def test_noise_that_fell_to_its_end_is_taken_as_the_end():
    ended = float(np.float32(0.15) - np.float32(1e-8))
    options = options_of(bounded({"deviation": ended}, {"end_deviation": 0.15}))
    assert options.deviation == 0.15


def test_what_is_given_by_name_stays_and_is_checked():
    assert bounded({"learning_rate": 1e-3}, {"learning_rate": 1e-9})["learning_rate"] == 1e-9
    with pytest.raises(Error, match="learning_rate must lie between"):
        options_of(bounded({}, {"learning_rate": 1e-9}))


def test_bounds_that_are_given_by_name_hold():
    assert bounded({"learning_rate": 1e-3}, {"max_learning_rate": 1e-4})["learning_rate"] == 1e-4
