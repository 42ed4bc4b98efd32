"""What the compiler is told of how arrays lie in memory."""

import numpy as np
import warp as wp

from warpmuscle.kernels.memory.compiler_hints import known_rows_of


@wp.struct
class Inner:
    vectors: wp.array2d[wp.vec3]
    table: wp.array3d[float]
    any: wp.array2d[float]


@wp.struct
class Outer:
    list: wp.array[int]
    inner: Inner
    number: int


know = known_rows_of(Outer, ("inner.any",))


@wp.kernel(enable_backward=False)
def read(given: Outer, out: wp.array2d[float]):
    i = wp.tid()
    s = given
    know(s)
    out[i, 0] = float(s.list[i])
    out[i, 1] = s.inner.vectors[i, 1][2]
    out[i, 2] = s.inner.table[i, 1, 2]
    out[i, 3] = s.inner.any[i, 1]
    out[i, 4] = float(s.number)


def test_elements_are_those_of_contiguous_arrays_and_of_others_with_strides_of_their_own():
    rng = np.random.default_rng(0)
    numbers, table = np.arange(4, dtype=np.int32), rng.random((4, 3, 5)).astype(np.float32)
    vectors, every = rng.random((4, 2, 3)).astype(np.float32), rng.random((4, 6)).astype(np.float32)
    s = Outer()
    s.list, s.number = wp.array(numbers, device="cpu"), 7
    s.inner.vectors, s.inner.table = wp.array(vectors, dtype=wp.vec3, device="cpu"), wp.array(table, device="cpu")
    s.inner.any = wp.array(every, device="cpu")[:, ::3]
    out = wp.zeros((4, 5), dtype=float, device="cpu")
    wp.launch(read, 4, [s, out], device="cpu")
    expected = np.stack([numbers, vectors[:, 1, 2], table[:, 1, 2], every[:, 3], np.full(4, 7)], axis=1)
    np.testing.assert_array_equal(out.numpy(), expected.astype(np.float32))
