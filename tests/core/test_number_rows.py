"""Numbers of a scene as arrays, of all instances and of the first alone."""

import numpy as np
import pytest

from warpmuscle.core.number_rows import first_number, first_row, rows

A, B, ONE = np.arange(5.0), 2.0 * np.arange(5.0), np.array([1.0])


def test_numbers_of_all_instances_fill_the_rows_of_those_that_differ():
    np.testing.assert_array_equal(rows([1.0, np.array([2.0, 3.0])]), [[1.0, 2.0], [1.0, 3.0]])
    np.testing.assert_array_equal(rows([[1.0, 2.0], [3.0, 4.0]]), [[[1.0, 2.0], [3.0, 4.0]]])


def test_the_first_instance_has_the_first_of_each_number():
    np.testing.assert_array_equal(first_row((1.0, np.array([2.0, 3.0]), 4.0)), [1.0, 2.0, 4.0])
    assert first_number(np.array([2.0, 3.0])) == 2.0
    assert first_number(5.0) == 5.0


@pytest.mark.parametrize(
    "nested",
    [
        1.0,
        [1.0, 2],
        [[1, 2.0], [3, 4]],
        [A, B],
        [[A, 1.0], [B, 2]],
        [[A, B], [B, A]],
        A,
        [],
        [[]],
        [ONE, 2.0],
        [ONE, ONE],
    ],
    ids=range(11),
)
def test_rows_are_those_of_each_number_put_down_by_itself(nested):
    def of(value, row):
        if isinstance(value, list):
            return [of(member, row) for member in value]
        return float(value[row % len(value)]) if isinstance(value, np.ndarray) else float(value)

    def lengths(value):
        if isinstance(value, list):
            return max(map(lengths, value), default=1)
        return len(value) if isinstance(value, np.ndarray) else 1

    expected = np.array([of(nested, row) for row in range(lengths(nested))])
    found = rows(nested)
    assert found.dtype == np.float64
    assert found.shape == expected.shape
    np.testing.assert_array_equal(found, expected)
