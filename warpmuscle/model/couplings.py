"""The functions that say how coupled joints turn and move, on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import normalized
from warpmuscle.kernels import structs
from warpmuscle.model.bodies import stacked
from warpmuscle.scene import Displacement, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import span_of
from warpmuscle.scene.joints.displacement import TURN, Span, pieces
from warpmuscle.scene.topology import Topology


def couplings_struct(scene: Scene, names: Topology, device: Any) -> structs.Couplings:
    """The device structure of the functions of coupled joints (see `kernels.structs.Couplings`)."""
    nothing = Displacement((1.0, 0.0, 0.0))
    first, displacements, spans = [0], list[Displacement](), list[Span]()
    for name in names.joints:
        joint = scene.character.joints[name]
        first.append(len(displacements))
        if joint_type(joint).displaced:
            for given in (joint.rotations, joint.translations):
                displacements += [*given, *[nothing] * (3 - len(given))]
                spans += [span_of(joint, scene.character.joints[joint.follows or name])] * 3
    displacements, spans = displacements or [nothing], spans or [TURN]
    starts_of, coefficients = zip(*map(pieces, displacements, spans), strict=True)
    c = structs.Couplings()
    c.first = to_device(first, int, device)
    c.piece_start = to_device(starts(map(len, starts_of)), int, device)
    c.axis = to_device(stacked([normalized(rows(one.axis)) for one in displacements]), wp.vec3, device)
    count = max(map(len, coefficients))
    cubics = [np.broadcast_to(part, (count, *part.shape[1:])) for part in coefficients]
    columns = {"start": np.concatenate(starts_of)[None], "c": np.concatenate(cubics, axis=1)}
    c.piece = structs_to_device(structs.CubicPiece, columns, device)
    return c
