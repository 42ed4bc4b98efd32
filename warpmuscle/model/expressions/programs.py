"""Expressions of a scene's forces as `kernels.algebra.programs` reads them, in front of the curves of muscles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.kernels.algebra.operations import BINARY, CONSTANT, CURVE, UNARY, VARIABLE
from warpmuscle.kernels.algebra.piecewise import PIECE
from warpmuscle.kernels.force.devices import FORCES
from warpmuscle.scene import Displacement, Force, Scene
from warpmuscle.scene.expressions.parse import parse
from warpmuscle.scene.joints.displacement import pieces

NUMBERS = {"constant": CONSTANT, "variable": VARIABLE, "curve": CURVE, **BINARY, **UNARY}


class Tables(NamedTuple):
    """Rows of all programs and curves, and where the programs of each force begin."""

    rows: Floats  # (n, 2)
    starts: dict[str, dict[str, float]]  # by force and program


def expression_tables(scene: Scene) -> Tables:
    """The programs of all forces of a checked scene."""
    made: list[Floats] = []
    starts: dict[str, dict[str, float]] = {}
    for name, force in scene.forces.items():
        kind = FORCES.get(force.type)
        if kind is not None and kind.programs:
            starts[name] = _put(force, kind.programs, kind.variables, made)
    return Tables(np.concatenate(made) if made else np.zeros((0, 2)), starts)


def piece_rows(function: Displacement, more: float = 0.0) -> Floats:
    """A function as `kernels.algebra.piecewise` reads it, (1 + PIECE pieces, 2), with a number more in its head."""
    start, coefficients = pieces(function)
    c = coefficients[0]
    table = np.zeros((len(start), PIECE, 2))
    table[:, 0, 0], table[:, 0, 1] = start, c[:, 0]
    table[:, 1], table[:, 2, 0] = c[:, 1:3], c[:, 3]
    return np.concatenate([[[len(start), more]], table.reshape(-1, 2)])


def _put(force: Force, programs: tuple[str, ...], variables: tuple[str, ...], made: list[Floats]) -> dict[str, float]:
    """The first rows of a force's programs, which come behind what was made before."""
    curves: dict[str, int] = {}
    for name, curve in force.curves.items():
        curves[name] = sum(map(len, made))
        made.append(piece_rows(Displacement((1.0, 0.0, 0.0), x=curve.x, y=[*curve.y], ends=curve.ends)))
    starts = {}
    for name in programs:
        operations = parse(force.expressions.get(name, "0"), variables, curves)
        rows = [[NUMBERS[one.kind], curves[one.name] if one.kind == "curve" else one.number] for one in operations]
        starts[name] = float(sum(map(len, made)))
        made.append(np.array([[len(rows), 0.0], *rows], dtype=np.float64))
    return starts
