"""Putting chosen instances back to where they start."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel
def put_rows(
    # in
    chosen: wp.array[wp.bool], rows: wp.array2d[int],
    # in and out
    target: wp.array2d[int],
):  # fmt: skip
    """Copy rows of 4-byte words of chosen instances: their own, or the only one. Launch with dim = target.shape."""
    i, k = wp.tid()
    if chosen[i]:
        target[i, k] = rows[wp.min(i, rows.shape[0] - 1), k]
