"""How high the ground is about the root where an instance starts, so that it starts over it."""

import warp as wp

from warpmuscle.kernels.contact.terrain import rise_at
from warpmuscle.kernels.learning.episodes import root_place
from warpmuscle.kernels.structs import ROOT_FIXED, ROOT_FREE, Model, State

wp.set_module_options({"enable_backward": False})

AROUND = 4  # places to each side of the root along x and z, at which the ground is asked


@wp.kernel
def highest_rise(
    # in
    model: Model, state: State, root: int, clearing: float,
    # out
    rise: wp.array[float],
):  # fmt: skip
    """The highest that the ground rises over its plane within a square about the root, m. Launch with dim = instances.

    Args:
        root: type of the root. clearing: half the side of the square, m.
    """
    i = wp.tid()
    place = root_place(root, i, state)
    highest = wp.float32(-1.0e30)
    for j in range(-AROUND, AROUND + 1):
        for k in range(-AROUND, AROUND + 1):
            x = place[0] + clearing * float(j) / float(AROUND)
            z = place[2] + clearing * float(k) / float(AROUND)
            highest = wp.max(highest, rise_at(i, x, z, model)[0])
    rise[i] = highest


@wp.kernel
def raise_roots(
    # in
    mask: wp.array[bool], root: int, rise: wp.array[float],
    # in and out
    state: State,
):  # fmt: skip
    """Raise the roots of the instances of a mask. Launch with dim = instances."""
    i = wp.tid()
    if mask[i] and root != ROOT_FIXED:
        k = wp.where(root == ROOT_FREE, 1, 0)
        state.coordinates[i, k] = state.coordinates[i, k] + rise[i]
