"""Rows of small matrices: each is read and written alone, against NumPy."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.memory.register_rows import rows_in, rows_of

COUNT = 3
ROWS = rows_of(COUNT)
matrix = wp.types.matrix(shape=(COUNT, 3), dtype=float)
numbers = wp.types.vector(length=COUNT, dtype=int)
lengths = wp.types.vector(length=COUNT, dtype=float)
number, with_number, length, with_length = ROWS.number, ROWS.with_number, ROWS.length, ROWS.with_length


@wp.kernel(enable_backward=False)
def change(k: int, v: wp.array[numbers], x: wp.array[lengths], read: wp.array[wp.vec3]):
    read[0] = wp.vec3(float(number(v[0], k)), length(x[0], k), 0.0)
    v[1] = with_number(v[0], k, 7)
    x[1] = with_length(x[0], k, 0.5)


@pytest.mark.parametrize("k", range(COUNT))
def test_one_number_is_read_or_changed_and_no_other(k: int):
    v = wp.array(np.array([[4, 5, 6]] * 2), dtype=numbers, device="cpu")
    x = wp.array(np.array([[1.5, 2.5, 3.5]] * 2), dtype=lengths, device="cpu")
    read = wp.zeros(1, dtype=wp.vec3, device="cpu")
    wp.launch(change, 1, [k, v, x, read], device="cpu")
    np.testing.assert_array_equal(read.numpy(), [[4 + k, 1.5 + k, 0.0]])
    chosen = np.arange(3) == k
    np.testing.assert_array_equal(v.numpy()[1], np.where(chosen, 7, [4, 5, 6]))
    np.testing.assert_array_equal(x.numpy()[1], np.where(chosen, 0.5, [1.5, 2.5, 3.5]))


@wp.struct
class Several:
    places: matrix
    lengths: lengths


PLACES, LOOKED_AT, LENGTHS = (
    rows_in(Several, name, COUNT, few) for name, few in (("places", 1), ("places", 4), ("lengths", 1))
)


@wp.kernel(enable_backward=False)
def change_in_place(k: int, value: wp.vec3, found: wp.array[Several], read: wp.array[wp.vec3]):
    one = found[0]
    two = found[0]
    read[0] = wp.static(PLACES.get)(one, k)
    read[1] = wp.static(LOOKED_AT.get)(one, k)
    read[2] = wp.vec3(wp.static(LENGTHS.get)(one, k), 0.0, 0.0)
    wp.static(PLACES.put)(one, k, value)
    wp.static(LOOKED_AT.add)(one, k, value)
    wp.static(LENGTHS.put)(one, k, 0.5)
    wp.static(LOOKED_AT.put)(two, k, value)
    found[1] = one
    found[2] = two


@pytest.mark.parametrize("k", range(COUNT))
def test_rows_of_a_field_are_read_and_changed_in_place(k: int):
    before, value = np.arange(9.0).reshape(3, 3), np.array([10.0, 20.0, 30.0])
    found = wp.zeros(3, dtype=Several, device="cpu")
    table = found.numpy()
    table["places"][0], table["lengths"][0] = before, [1.5, 2.5, 3.5]
    found, read = wp.array(table, dtype=Several, device="cpu"), wp.zeros(3, dtype=wp.vec3, device="cpu")
    wp.launch(change_in_place, 1, [k, wp.vec3(*value), found, read], device="cpu")
    np.testing.assert_array_equal(read.numpy(), [before[k], before[k], [1.5 + k, 0.0, 0.0]])
    chosen = np.arange(3) == k
    np.testing.assert_array_equal(found.numpy()["places"][1], np.where(chosen[:, None], 2.0 * value, before))
    np.testing.assert_array_equal(found.numpy()["places"][2], np.where(chosen[:, None], value, before))
    np.testing.assert_array_equal(found.numpy()["lengths"][1], np.where(chosen, 0.5, [1.5, 2.5, 3.5]))
