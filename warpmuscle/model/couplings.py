"""The functions that say how coupled joints turn and move, turned axes of inertia, and constraints, on the device."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.kernels import structs
from warpmuscle.kernels.body.two_coordinates import RATE_ONLY, ROD
from warpmuscle.kernels.body_structs import BodyRun
from warpmuscle.kernels.constraint.constraints import DISTANCE, POINT, POINT_ON_LINE, WELD
from warpmuscle.model.bodies import stacked
from warpmuscle.model.joints import acting_unknowns
from warpmuscle.scene import Character, Constraint, Displacement, Joint, Scene
from warpmuscle.scene.constraints.pose import ROWS, perpendicular_axes, row_count
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.coupled import span_of
from warpmuscle.scene.joints.displacement import TURN, Span, pieces
from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.topology import Topology, followed_drivers

NUMBERS = {"weld": WELD, "point": POINT, "point_on_line": POINT_ON_LINE, "distance": DISTANCE}


def couplings_struct(scene: Scene, names: Topology, device: Any) -> structs.Couplings:
    """The device structure of the functions of coupled joints (see `kernels.structs.Couplings`)."""
    character = scene.character
    c = structs.Couplings()
    ends = starts(6 * joint_type(character.joints[name]).displaced for name in names.joints)
    _put_functions(c, character, names, device)
    rows_of = {driver: k for k, driver in enumerate(followed_drivers(character, names))}
    row = [rows_of.get(driver, -1) for driver in names.driver]
    kinds = [0, *(_kind(character.joints[name]) for name in names.joints)]
    c.joint = records_to_device(
        structs.Coupling, device, driver=names.driver, first=[0, *ends[:-1]], row=row, beside=names.beside, kind=kinds
    )
    c.followed = len(rows_of) + row_count(character)
    following = [[k for k, of in enumerate(names.driver) if of == body != k] for body in range(len(names.bodies))]
    c.follower_start = to_device(starts(map(len, following)), int, device)
    c.follower = to_device([k for of_body in following for k in of_body] or [0], int, device)
    unknowns = [*rows_of, *[0] * row_count(character)] or [0]
    c.unknown_driver = to_device(unknowns, int, device)
    acting = acting_unknowns(character, names)
    _put_entries(c, acting, device)
    _put_runs(c, acting, names, device)
    turned = [normalized(rows(character.bodies[name].inertia_axes)) for name in names.bodies]
    axes = rotate(stacked(turned)[:, :, None], np.eye(3))  # (rows, bodies, axis, 3)
    c.inertia_axes = to_device(np.swapaxes(axes, 2, 3), wp.mat33, device)
    own = [character.joints[name] for name in names.joints]
    armature, damping = (rows([0.0, *(getattr(one, field) for one in own)]) for field in ("armature", "damping"))
    c.resistance = to_device(np.stack(np.broadcast_arrays(armature, damping), axis=-1), wp.vec2, device)
    return c


def _put_functions(c: structs.Couplings, character: Character, names: Topology, device: Any) -> None:
    """Put the six functions of each displaced joint, three turns and three shifts, and their pieces."""
    nothing = Displacement((1.0, 0.0, 0.0))
    displacements, spans = list[Displacement](), list[Span]()
    bodies, of_two = list[int](), list[bool]()
    for name in names.joints:
        joint = character.joints[name]
        if joint_type(joint).displaced:
            bodies += [names.bodies.index(joint.child)] * 6
            for given in (joint.rotations, joint.translations):
                displacements += [*given, *[nothing] * (3 - len(given))]
                spans += [span_of(joint, character.joints[joint.follows or name])] * 3
                of_two += [bool(joint.beside)] * 3
    displacements, spans, bodies, of_two = displacements or [nothing], spans or [TURN], bodies or [0], of_two or [False]
    made = [
        terms_of(one) if two else pieces(one, span) for one, span, two in zip(displacements, spans, of_two, strict=True)
    ]
    starts_of, coefficients = zip(*made, strict=True)
    piece_start = starts(map(len, starts_of))
    columns = {
        "axis": stacked([normalized(rows(one.axis)) for one in displacements]),
        "first_piece": np.array([piece_start[:-1]]),
        "end_piece": np.array([piece_start[1:]]),
        "body": np.array([bodies]),
        "counts": np.array([[int(np.any(one)) for one in coefficients]]),
    }
    c.function = structs_to_device(structs.CouplingFunction, columns, device)
    count = max(map(len, coefficients))
    cubics = [np.broadcast_to(part, (count, *part.shape[1:])) for part in coefficients]
    columns = {"start": np.concatenate(starts_of)[None], "c": np.concatenate(cubics, axis=1)}
    c.piece = structs_to_device(structs.CubicPiece, columns, device)


def _kind(joint: Joint) -> int:
    """What the functions of a joint of two coordinates are on the device."""
    rod = any(one.rod for one in joint.translations)
    return (RATE_ONLY if joint.rate_only else 0) + (ROD if rod else 0)


def terms_of(displacement: Displacement) -> tuple[Floats, Floats]:
    """A function of two coordinates in the table of pieces: starts (P,) without meaning, and rows (rows, P, 4).

    A term has its coefficient and powers there, a rod its length and angles.
    """
    zero = 0.0
    found: list[list[Number]] = (
        [[*displacement.rod, zero]] if displacement.rod else [[displacement.value, zero, zero, zero]]
    )
    found += [[a, float(m), float(n), zero] for a, m, n in displacement.terms]
    return np.zeros(len(found)), rows(found)


def _put_entries(c: structs.Couplings, acting: list[list[int]], device: Any) -> None:
    """Which unknowns act on which bodies, both ways round."""
    unknowns = len(acting[0])
    entry = np.full((len(acting), max(unknowns, 1)), -1)
    pairs = [(body, k) for body, of_body in enumerate(acting) for k in of_body]
    for number, (body, k) in enumerate(pairs):
        entry[body, k] = number
    acted = [[body for body, other in pairs if other == k and body > 0] for k in range(unknowns)]
    lists: dict[str, Any] = {
        "entry_start": starts(map(len, acting)),
        "entry_unknown": [k for _, k in pairs],
        "entry": entry.ravel(),
        "acted_start": starts(map(len, acted)),
        "acted": [body for bodies in acted for body in bodies],
    }
    for name, values in lists.items():
        setattr(c, name, to_device(values if len(values) else [0], int, device))


def runs_of(parents: Sequence[int], unknowns: Sequence[int]) -> list[list[list[int]]]:
    """Bodies that hang on one another as only children, in runs, by level: `kernels.body_structs.BodyRun`.

    Args:
        parents: by body. unknowns: that act on each body; runs on which most do come first in their level.
    """
    children = Counter(parents)
    runs: list[list[int]] = []
    number: dict[int, int] = {}
    level: list[int] = []
    for body, parent in list(enumerate(parents))[1:]:
        if parent > 0 and children[parent] == 1:
            number[body] = number[parent]
            runs[number[body]].append(body)
        else:
            number[body] = len(runs)
            level.append(level[number[parent]] + 1 if parent > 0 else 0)
            runs.append([body])
    order = sorted(range(len(runs)), key=lambda k: (level[k], -unknowns[runs[k][0]]))
    return [[runs[k] for k in group] for _, group in groupby(order, key=lambda k: level[k])]


def _put_runs(c: structs.Couplings, acting: list[list[int]], names: Topology, device: Any) -> None:
    """Put in the runs of bodies."""
    counts = list(map(len, acting))
    levels = runs_of(names.parents, counts)
    flat = [run for level in levels for run in level]
    bounds = starts(map(len, levels))
    of = [min(place, len(levels) - 1) for place in range(len(flat))]
    c.run = records_to_device(
        BodyRun, device, first=[run[0] for run in flat], last=[run[-1] for run in flat],
        count=[len(run) for run in flat], unknowns=[counts[run[0]] for run in flat],
        before=[before for level in levels for before in starts(counts[run[0]] for run in level)[:-1]],
        start=[bounds[k] for k in of], end=[bounds[k + 1] for k in of],
    )  # fmt: skip
    c.run_levels = len(levels)


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
    held = [2 * k + np.arange(count) // 3 for k, count in enumerate(counts)]  # a point; of a weld then a turn
    c.held = to_device(np.concatenate(held), int, device)
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
    return np.stack([perpendicular_axes(axis) for axis in rows(constraint.axis)])
