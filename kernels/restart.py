"""Putting chosen instances back to where they start."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel
def put_rows(
    # in
    chosen: wp.array[int], rows: wp.array2d[int],
    # in and out
    target: wp.array2d[int],
):  # fmt: skip
    """Copy rows of 4-byte words of chosen instances: their own, or the only one. Launch with dim = (chosen, words)."""
    i, k = wp.tid()
    instance = chosen[i]
    target[instance, k] = rows[wp.min(instance, rows.shape[0] - 1), k]
