"""Numbers of a scene as arrays, of all instances and of the first alone."""

import numpy as np

from warpmuscle.core.number_rows import first_number, first_row, rows


def test_numbers_of_all_instances_fill_the_rows_of_those_that_differ():
    np.testing.assert_array_equal(rows([1.0, np.array([2.0, 3.0])]), [[1.0, 2.0], [1.0, 3.0]])
    np.testing.assert_array_equal(rows([[1.0, 2.0], [3.0, 4.0]]), [[[1.0, 2.0], [3.0, 4.0]]])


def test_the_first_instance_has_the_first_of_each_number():
    np.testing.assert_array_equal(first_row((1.0, np.array([2.0, 3.0]), 4.0)), [1.0, 2.0, 4.0])
    assert first_number(np.array([2.0, 3.0])) == 2.0
    assert first_number(5.0) == 5.0
