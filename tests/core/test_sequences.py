"""Sequences at other moments, against NumPy's interpolation of one column, and made to rise; the nearest of times."""

import numpy as np

from warpmuscle.core.sequences import at_moments, mirrored, nearest_rows, rising, weighted_median


def test_every_column_is_that_of_numpys_interpolation_also_beyond_the_ends():
    random = np.random.default_rng(1)
    time, moments = np.sort(random.random(20)), random.uniform(-0.5, 1.5, (4, 7))
    values = random.normal(size=(20, 3, 2))
    found = at_moments(time, values, moments)
    assert found.shape == (4, 7, 3, 2)
    for k in np.ndindex(3, 2):
        np.testing.assert_allclose(found[(..., *k)], np.interp(moments, time, values[(..., *k)]), atol=1e-12)


def test_rows_are_mirrored_about_the_first_and_the_last_one():
    np.testing.assert_array_equal(mirrored(np.array([1.0, 2.0, 4.0]), 2), [-2.0, 0.0, 1.0, 2.0, 4.0, 6.0, 7.0])
    rows = mirrored(np.array([[0.0, 5.0], [1.0, 5.0], [3.0, 6.0]]), 1)
    np.testing.assert_array_equal(rows, [[-1.0, 5.0], [0.0, 5.0], [1.0, 5.0], [3.0, 6.0], [5.0, 7.0]])


def test_half_of_the_weight_is_at_or_below_the_weighted_median():
    values = np.array([[3.0, 1.0], [2.0, 9.0]])
    assert weighted_median(values, np.ones((2, 2))) == 2.0
    assert weighted_median(values, np.array([[1.0, 1.0], [1.0, 4.0]])) == 9.0
    assert weighted_median(values, np.array([[0.0, 2.0], [0.0, 0.0]])) == 1.0


def test_neighbours_that_fall_are_pooled_until_none_does():
    np.testing.assert_array_equal(rising([1.0, 3.0, 2.0, 4.0]), [1.0, 2.5, 2.5, 4.0])
    np.testing.assert_array_equal(rising([3.0, 2.0, 1.0]), [2.0, 2.0, 2.0])
    np.testing.assert_array_equal(rising([0.0, 0.0, 5.0]), [0.0, 0.0, 5.0])


def test_no_other_rising_sequence_is_nearer():
    generator = np.random.default_rng(1)
    values = generator.normal(size=12)
    nearest = np.sum((rising(values) - values) ** 2)
    for _ in range(200):
        other = np.sort(rising(values) + 0.1 * generator.normal(size=12))
        assert np.sum((other - values) ** 2) >= nearest - 1e-12


def test_the_nearest_times_are_those_with_the_least_distance_the_earlier_of_two():
    random = np.random.default_rng(2)
    time, moments = random.permutation(np.repeat(random.random(30), 2)), random.uniform(-0.5, 1.5, 50)
    np.testing.assert_array_equal(nearest_rows(time, moments), np.abs(time[:, None] - moments).argmin(axis=0))
    np.testing.assert_array_equal(nearest_rows(np.array([0.0, 1.0, 2.0]), np.array([0.5, 1.5, 1.75])), [0, 1, 2])
    np.testing.assert_array_equal(nearest_rows(np.array([3.0]), np.array([-1.0, 9.0])), [0, 0])
