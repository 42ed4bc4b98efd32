"""Constraints between bodies on the device."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, structs_to_device, to_device
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.kernels import structs
from warpmuscle.kernels.body.constraints import DISTANCE, POINT, POINT_ON_LINE, WELD
from warpmuscle.model.bodies import stacked
from warpmuscle.scene import Constraint, Scene
from warpmuscle.scene.loops import ROWS, across
from warpmuscle.scene.number import Vector
from warpmuscle.scene.topology import Topology, followed_drivers

NUMBERS = {"weld": WELD, "point": POINT, "point_on_line": POINT_ON_LINE, "distance": DISTANCE}


def constraints_struct(scene: Scene, names: Topology, device: Any) -> structs.Constraints:
    """The device structure of a character's constraints, one at least (see `kernels.structs.Constraints`)."""
    given = list(scene.character.constraints.values())
    body, other = ([names.bodies.index(getattr(one, end)) for one in given] for end in ("body", "other_body"))
    counts = [ROWS[one.type] for one in given]
    c = structs.Constraints()
    c.first = len(followed_drivers(scene.character, names))
    c.plan = records_to_device(
        structs.ConstraintPlan, device, kind=[NUMBERS[one.type] for one in given], body=body, other=other,
        first_row=[0, *np.cumsum(counts[:-1]).tolist()],
    )  # fmt: skip
    columns = {
        "place": stacked([_place(scene, one.body, one.position) for one in given]),
        "other_place": stacked([_place(scene, one.other_body, one.other_position) for one in given]),
        "axes": stacked([_axes(one.orientation) for one in given]),
        "other_axes": stacked([_other_axes(one) for one in given]),
        "distance": rows([one.distance for one in given]),
    }
    c.row = structs_to_device(structs.ConstraintRow, columns, device)
    c.body, c.other = (to_device(np.repeat(ends, counts), int, device) for ends in (body, other))
    return c


def _place(scene: Scene, body: str, position: Vector) -> Floats:
    """A point (rows, 3) of a body from its joint."""
    joint = next((one for one in scene.character.joints.values() if one.child == body), None)
    return rows(position) - rows((0.0, 0.0, 0.0) if joint is None else joint.position_in_child)


def _axes(orientation: Any) -> Floats:
    """Axes (rows, 3, 3) of a frame, as columns."""
    return np.swapaxes(rotate(normalized(rows(orientation))[:, None], np.eye(3)), 1, 2)


def _other_axes(constraint: Constraint) -> Floats:
    if constraint.type != "point_on_line":
        return _axes(constraint.other_orientation)
    return np.stack([across(axis) for axis in rows(constraint.axis)])
