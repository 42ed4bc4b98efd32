"""Putting chosen instances back to where they start."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel
def put_rows(
    # in
    chosen: wp.array[int], rows: wp.array2d[int],
    # in and out
    target: wp.array3d[int],
):  # fmt: skip
    """Copy rows of 4-byte words of chosen instances: their own, or the only one.

    Launch with dim = (chosen, elements, words of each), the latter two as in the target.
    """
    i, element, word = wp.tid()
    instance = chosen[i]
    k = element * target.shape[2] + word
    target[instance, element, word] = rows[wp.min(instance, rows.shape[0] - 1), k]
