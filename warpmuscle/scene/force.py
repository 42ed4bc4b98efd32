"""Torques and forces on joints and bodies besides those of muscles and controller; units are SI and radians."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.expressions.part import ExpressionCurve
from warpmuscle.scene.number import Number
from warpmuscle.scene.part import Part


class Force(Part):
    """A device on a joint, or a force on a body.

    `type`: `bilinear_spring` on a joint, `air_drag` on a body, `bushing` between two, see `kernels.force.devices`; or
    `module:name` of a `kernels.force.forces.ForceKind` of one's own. Those whose names end with `_expression` take
    `expressions` such as `effort = "-20*q^3 - 0.1*qdot"`, see `kernels.force.expressions`.
    """

    type: str
    joint: str = ""  # on whose child it acts, and backwards on the parent
    body: str = ""  # or on which body
    other_body: str = ""  # and on which other one, if it acts between two
    parameters: Annotated[dict[str, Number], "1"] = {}
    expressions: dict[str, str] = {}  # what it is, of what it depends on; 0 where it says nothing
    curves: dict[str, ExpressionCurve] = {}  # that the expressions may call, by their own names
    scone_names: dict[str, str] = {}  # by axis of a motor, lean, list or turn: of the reflex that drives it, in a .par


def power_name(force: str) -> str:
    """What recordings call the power of a device, W, positive where it gives energy to the body."""
    return f"forces.{force}.power"
