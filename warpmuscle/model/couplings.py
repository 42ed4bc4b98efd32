"""The functions that say how coupled joints turn and move, and turned axes of inertia, on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.kernels import structs
from warpmuscle.model.bodies import stacked
from warpmuscle.scene import Displacement, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import span_of
from warpmuscle.scene.joints.displacement import TURN, Span, pieces
from warpmuscle.scene.loops import row_count
from warpmuscle.scene.topology import Topology, followed_drivers


def couplings_struct(scene: Scene, names: Topology, device: Any) -> structs.Couplings:
    """The device structure of the functions of coupled joints (see `kernels.structs.Couplings`)."""
    character = scene.character
    nothing = Displacement((1.0, 0.0, 0.0))
    first, displacements, spans = [0], list[Displacement](), list[Span]()
    bodies: list[int] = []
    for name in names.joints:
        joint = character.joints[name]
        first.append(len(displacements))
        if joint_type(joint).displaced:
            bodies += [names.bodies.index(joint.child)] * 6
            for given in (joint.rotations, joint.translations):
                displacements += [*given, *[nothing] * (3 - len(given))]
                spans += [span_of(joint, character.joints[joint.follows or name])] * 3
    displacements, spans, bodies = displacements or [nothing], spans or [TURN], bodies or [0]
    starts_of, coefficients = zip(*map(pieces, displacements, spans), strict=True)
    piece_start = starts(map(len, starts_of))
    c = structs.Couplings()
    rows_of = {driver: k for k, driver in enumerate(followed_drivers(character, names))}
    row = [rows_of.get(driver, -1) for driver in names.driver]
    c.joint = records_to_device(structs.Coupling, device, driver=names.driver, first=first, row=row)
    c.followed = len(rows_of) + row_count(character)
    columns = {
        "axis": stacked([normalized(rows(one.axis)) for one in displacements]),
        "first_piece": np.array([piece_start[:-1]]),
        "end_piece": np.array([piece_start[1:]]),
        "body": np.array([bodies]),
    }
    c.function = structs_to_device(structs.CouplingFunction, columns, device)
    count = max(map(len, coefficients))
    cubics = [np.broadcast_to(part, (count, *part.shape[1:])) for part in coefficients]
    columns = {"start": np.concatenate(starts_of)[None], "c": np.concatenate(cubics, axis=1)}
    c.piece = structs_to_device(structs.CubicPiece, columns, device)
    turned = [normalized(rows(character.bodies[name].inertia_axes)) for name in names.bodies]
    axes = rotate(stacked(turned)[:, :, None], np.eye(3))  # (rows, bodies, axis, 3)
    c.inertia_axes = to_device(np.swapaxes(axes, 2, 3), wp.mat33, device)
    return c
