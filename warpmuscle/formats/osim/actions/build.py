"""Forces of a scene from records of `actions.read`."""

from __future__ import annotations

import numpy as np

from warpmuscle.formats.osim.actions.activations import activation_text
from warpmuscle.formats.osim.actions.read import CONTROL, LAGS, SETS
from warpmuscle.formats.osim.actions.texts import function_text, turned_texts
from warpmuscle.formats.osim.frames import GROUND, on_body
from warpmuscle.formats.osim.placement import Placement, rotation_vector, vector
from warpmuscle.formats.osim.records import Model, OsimForce
from warpmuscle.scene import Force
from warpmuscle.scene.expressions.parse import BadExpression, parse
from warpmuscle.scene.expressions.part import ExpressionCurve
from warpmuscle.scene.number import Number

ANGLES, SHIFTS = ("theta_x", "theta_y", "theta_z"), ("delta_x", "delta_y", "delta_z")
EFFORTS = ("mx", "my", "mz", "fx", "fy", "fz")
NOT_UNDERSTOOD = "{!r}: {}; it is left out, and holds nothing"
ON_GROUND = "acts on the ground, which does not move; it is left out"


class Unfit(ValueError):
    """A force that a scene cannot have, and why."""


def made_action(force: OsimForce, model: Model, placement: Placement, joint: str) -> Force:
    """The force of a record.

    Args:
        joint: of a force along a coordinate.

    Raises:
        Unfit: it cannot act, or its expression is not understood.
    """
    match force.kind:
        case "ExpressionBasedCoordinateForce":
            text = checked_text(force.words["expression"], ("q", "qdot"))
            return Force("coordinate_expression", joint=joint, parameters={"scale": 1.0}, expressions={"effort": text})
        case "CoordinateActuator":
            return _with_expression(force, Force("coordinate_expression", joint=joint), "effort")
        case "ActivationCoordinateActuator":
            made = _with_expression(force, Force("coordinate_expression", joint=joint), "effort")
            lag, start = (force.numbers[tag][0] for tag in LAGS)
            made.curves = {}
            made.expressions["effort"] = activation_text(force.functions[CONTROL][0], lag, start, "a", made.curves)
            return made
        case "ExpressionBasedPointToPointForce" | "PointToPointSpring" | "PointToPointActuator":
            return _between_points(force, placement)
        case "TorqueActuator":
            return _torque(force, placement)
    if force.kind == "FunctionBasedBushingForce":
        curves: dict[str, ExpressionCurve] = {}
        texts = [
            function_text(function, name, f"of_{name}", curves)
            for name, function in zip((*ANGLES, *SHIFTS), force.functions["functions"], strict=True)
        ]
        return bushing_of_texts(force, placement, texts, curves)
    return _on_body(force, model, placement)


def checked_text(text: str, variables: tuple[str, ...]) -> str:
    """An expression that is understood; raises Unfit."""
    try:
        parse(text, variables)
    except BadExpression as error:
        raise Unfit(NOT_UNDERSTOOD.format(text[:60], error)) from None
    return text


def bushing_of_texts(
    force: OsimForce, placement: Placement, texts: list[str], curves: dict[str, ExpressionCurve]
) -> Force:
    """A bushing whose moments and forces are expressions."""
    (first, place), (second, other_place) = (placement.point(frame, (0.0, 0.0, 0.0)) for frame in force.frames)
    if first == second:
        raise Unfit("both of its frames are on one body; it is left out, and holds nothing")
    turns = [rotation_vector(placement.axes(frame)) for frame in force.frames]
    values: dict[str, Number] = {}
    for end, at, turn in (("first", place, turns[0]), ("second", other_place, turns[1])):
        for axis, where, about in zip("xyz", at, turn, strict=True):
            values |= {f"{end}_{axis}": where, f"{end}_turn_{axis}": about}
    damping = (*force.numbers["rotational_damping"], *force.numbers["translational_damping"])
    names = ("tx", "ty", "tz", "x", "y", "z")
    values |= {f"damping_{name}": number for name, number in zip(names, damping, strict=True)}
    expressions = {name: text for name, text in zip(EFFORTS, texts, strict=True) if text not in ("0.0", "0")}
    return Force("bushing_expression", "", first, second, values, expressions, curves)


def _with_expression(force: OsimForce, made: Force, program: str) -> Force:
    """A force that is an actuator's greatest one times a control over time."""
    made.parameters["scale"] = force.numbers["optimal_force"][0]
    made.expressions[program] = function_text(force.functions[CONTROL][0], "t", "control", made.curves)
    return made


def _between_points(force: OsimForce, placement: Placement) -> Force:
    (first, place), (second, other_place) = (
        placement.point(frame, np.array(force.numbers[f"point{k}"])) for k, frame in enumerate(force.frames, 1)
    )
    if first == second:
        raise Unfit("both of its points are on one body; it is left out, and pulls on nothing")
    values: dict[str, Number] = {
        f"{end}_{axis}": number
        for end, at in (("first", place), ("second", other_place))
        for axis, number in zip("xyz", at, strict=True)
    }
    if force.kind == "PointToPointSpring":
        stiffness = force.numbers["stiffness"][0]
        values |= {"rest_length": force.numbers["rest_length"][0], "damping": 0.0}
        values |= {"stiffness_above": stiffness, "stiffness_below": stiffness}
        return Force("point_spring", body=first, other_body=second, parameters=values)
    made = Force("point_expression", body=first, other_body=second, parameters={"scale": 1.0, **values})
    if force.kind == "PointToPointActuator":
        made = _with_expression(force, made, "tension")
        made.parameters["scale"] = -force.numbers["optimal_force"][0]  # which pushes the points apart
        return made
    made.expressions["tension"] = checked_text(force.words["expression"], ("d", "ddot"))
    return made


def _torque(force: OsimForce, placement: Placement) -> Force:
    frame, other = force.frames
    first, second = placement.body(frame), placement.body(other)
    if first.name == second.name:
        raise Unfit("both of its bodies are one; it is left out, and turns nothing")
    inside = force.numbers["in_body"][0]
    axis = np.array(force.numbers["axis"])
    if not np.linalg.norm(axis) > 0.0:
        raise Unfit("its axis has no length; it is left out, and turns nothing")
    axis = (first.axes if inside else placement.world) @ (axis / np.linalg.norm(axis))
    values: dict[str, Number] = {"in_body": inside}
    values |= {f"axis_{letter}": number for letter, number in zip("xyz", vector(axis), strict=True)}
    return _with_expression(
        force, Force("torque_expression", body=first.name, other_body=second.name, parameters=values), "torque"
    )


def _on_body(force: OsimForce, model: Model, placement: Placement) -> Force:
    """A PrescribedForce or a PointActuator."""
    (frame,) = force.frames
    path, rotation, origin = on_body(model, frame)
    if path == GROUND:
        raise Unfit(ON_GROUND)
    body, numbers = placement.bodies[path], force.numbers
    inside, global_point = numbers["force_in_body"][0], numbers["point_in_world"][0]
    curves: dict[str, ExpressionCurve] = {}
    if force.kind == "PointActuator":
        control = function_text(force.functions[CONTROL][0], "t", "control", curves)
        direction = np.array(numbers["direction"])
        unit = direction / max(float(np.linalg.norm(direction)), 1e-300)
        texts = {
            "force": [f"{factor!r}*({control})" if factor else "0.0" for factor in map(float, unit)],
            "moment": ["0.0"] * 3,
            "point": [repr(float(number)) for number in numbers["point"]],
        }
    else:
        texts = {
            name: [
                function_text(function, "t", f"{name}_{axis}_over_time", curves)
                for axis, function in zip("xyz", force.functions[tag], strict=True)
            ]
            for name, tag in zip(("force", "moment", "point"), SETS, strict=True)
        }
    axes = body.axes @ rotation if inside else placement.world
    expressions: dict[str, str] = {}
    for name in ("force", "moment"):
        expressions |= _by_axis(name, turned_texts(axes, texts[name]))
    if global_point:
        expressions |= _by_axis("point", turned_texts(placement.world, texts["point"]))
    else:
        place = turned_texts(body.axes @ rotation, texts["point"], body.point(origin))
        expressions |= _by_axis("point", place)
    values: dict[str, Number] = {
        "scale": numbers["scale"][0], "force_in_body": inside, "point_in_world": global_point,
    }  # fmt: skip
    return Force("body_expression", body=body.name, parameters=values, expressions=expressions, curves=curves)


def _by_axis(name: str, texts: tuple[str, ...]) -> dict[str, str]:
    return {f"{name}_{axis}": text for axis, text in zip("xyz", texts, strict=True) if text != "0"}
