"""Ground that moves along itself as a kernel wants it."""

from __future__ import annotations

from typing import Any

import warp as wp

from warpmuscle.core.arrays import rows, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.scene import Treadmill
from warpmuscle.scene.treadmill.belt_motion import knots_of


def belt_arrays(treadmill: Treadmill, device: Any) -> tuple[wp.array, wp.array]:
    """`kernels.structs.Belts`, (rows, 1), and the profile of their speeds, (1, knots).

    Args:
        treadmill: its numbers are floats, or (n,) arrays with one value an instance.
    """
    columns = {
        "left": rows([treadmill.speed]) + rows([treadmill.left]),
        "right": rows([treadmill.speed]) + rows([treadmill.right]),
        **{name: rows([getattr(treadmill, name)]) for name in ("sideways", "split", "start")},
    }
    belts = structs_to_device(structs.Belts, columns, device)
    return belts, to_device(knots_of(treadmill)[None], wp.vec2, device)
