"""Which numbers and curves of a scene can be edited while it runs, and what they are called; numbers only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from warpmuscle.scene import Component, Controller, Curve, Excitation, Scene
from warpmuscle.scene.controller import SIMBICON
from warpmuscle.scene.number import OF_OWNER, Free
from warpmuscle.scene.parameters import named_members
from warpmuscle.scene.part import Part
from warpmuscle.scene.simbicon.controller import Simbicon
from warpmuscle.scene.units import units_of
from warpmuscle.view.editing.names import Path, called

OF_MUSCLE = ("f_max", "l_opt", "l_slack")  # which change while a muscle runs
KNOTS: dict[Any, tuple[str, str]] = {
    Component: ("phase", "angle"),
    Curve: ("phase", "value"),
    Excitation: ("time", "value"),
}
POSITIVE = {"time", *OF_MUSCLE}
NOT_NEGATIVE = {"kp", "kd", "torque_limit", "scale", "stance_hip_max_velocity"}
LIMITS, UNLIMITED = ("d_limits", "v_limits"), 1000.0  # which clamp nothing from so much on
USUAL = {  # half of a slider's range about small numbers, by unit
    "N m/rad": 100.0, "N m s/rad": 10.0, "N m": 50.0, "rad": 0.5, "rad/m": 0.5, "rad s/m": 0.5, "m": 0.2, "m/s": 0.5,
    "s": 0.5, "N": 500.0,
}  # fmt: skip


@dataclass(frozen=True)
class Editable:
    """A number or a curve.

    Attributes:
        key: path in the scene, such as `controller.pd.lHip.kp`; of a curve, of what has its knots.
        group: what it belongs to, such as "swing hip". name: what it is there, such as "angle, speed feedback (cv)".
        unit: "" of a pure number.
    """

    key: str
    path: Path
    group: str
    name: str
    unit: str


@dataclass(frozen=True)
class CurveKnots(Editable):
    """A curve, with the fields of its knots; between them it is straight, or runs smoothly over the phase of a state.

    Attributes:
        duration: key of the number that phase 1 takes, s; "" where knots are at times.
    """

    across: str
    along: str
    straight: bool
    duration: str
    knots: int  # how many the scene has


def editable(scene: Scene) -> tuple[list[Editable], list[CurveKnots]]:
    """All numbers of the controller and the curves that it follows, and the main ones of muscles, in order.

    A muscle that neither a controller nor a curve excites has a curve without knots.
    """
    numbers: list[Editable] = []
    curves: list[CurveKnots] = []
    for name in ("controller", "custom_controller_parameters"):
        for one in _below(getattr(scene, name), (name,), None, scene):
            _into(one, numbers, curves)
    controlled = scene.controller is not None or bool(scene.custom_controller) or scene.gait_states is not None
    for name, muscle in scene.character.muscles.items():
        path = ("character", "muscles", name)
        for field in OF_MUSCLE:
            numbers.append(_number((*path, field), units_of(type(muscle)).get(field, ""), scene))
        if muscle.excitation is None and not controlled:
            group, name, _ = called((*path, "excitation"), scene)  # nothing excites it but what is drawn by hand
            key = ".".join((*path, "excitation"))
            curves.append(CurveKnots(key, (*path, "excitation"), group, name, "", *KNOTS[Excitation], True, "", 0))
        if muscle.excitation is not None:
            for one in _below(muscle.excitation, (*path, "excitation"), None, scene):
                _into(one, numbers, curves)
    numbers.sort(key=lambda one: "axis" in one.path)  # which few want to change
    return numbers, curves


def _into(one: Editable, numbers: list[Editable], curves: list[CurveKnots]) -> None:
    if isinstance(one, CurveKnots):
        curves.append(one)
    else:
        numbers.append(one)


def _below(value: Any, path: Path, unit: str | None, scene: Scene) -> Iterator[Editable]:
    """Numbers and curves within a part of a scene; `unit` is that of plain numbers there, None if they are names."""
    if path == ("custom_controller_parameters",):
        unit = ""
    knots = KNOTS.get(type(value))
    if knots is not None:
        yield _curve(value, path, unit or "", scene)
    for name, member in named_members(value) or ():
        if (knots is not None and name in knots) or _of_other_type(value, name):
            continue
        below = unit
        if isinstance(value, Part):
            declared = units_of(type(value)).get(name)
            below = unit if declared == OF_OWNER else {None: None, "1": ""}.get(declared, declared)
        if isinstance(member, Free):
            yield _number((*path, name), below or "", scene)
            yield from _rates(member, (*path, name), below or "", scene)
        elif isinstance(member, int | float) and not isinstance(member, bool):
            if below is not None:
                yield _number((*path, name), below, scene)
        else:
            yield from _below(member, (*path, name), below, scene)


def _of_other_type(value: Any, name: str) -> bool:
    """Whether this is a key of a simbicon controller in one that is none."""
    return isinstance(value, Controller) and value.type != SIMBICON and name in Simbicon.__struct_fields__


def _rates(number: Free, path: Path, unit: str, scene: Scene) -> Iterator[Editable]:
    """What is added to a number per command."""
    for command in number.per:
        for name, _ in number.rates(command):
            yield _number((*path, "per", name), unit, scene)


def _number(path: Path, unit: str, scene: Scene) -> Editable:
    group, name, _ = called(path, scene)
    return Editable(".".join(path), path, group, name, unit)


def _curve(value: Any, path: Path, unit: str, scene: Scene) -> CurveKnots:
    across, along = KNOTS[type(value)]
    straight, duration = isinstance(value, Excitation), ""
    if isinstance(value, Component):
        unit = "rad"
    if path[:2] == ("controller", "states"):
        duration = ".".join((*path[:3], "time"))
    group, name, _ = called(path, scene)
    return CurveKnots(
        ".".join(path), path, group, name, unit, across, along, straight, duration, len(getattr(value, across))
    )


def slider_range(field: str, unit: str, value: float) -> tuple[float, float]:
    """Sensible ends of a slider for a number of this name; a box beside it takes others.

    The number itself lies between them, but for a limit that clamps nothing.
    """
    span = max(abs(value), USUAL.get(unit, 1.0))
    if field in LIMITS and abs(value) >= UNLIMITED:
        return -2.0 * USUAL[unit], 2.0 * USUAL[unit]
    if field in POSITIVE:
        return 0.05 * abs(value), 2.0 * abs(value)
    if field in NOT_NEGATIVE:
        return 0.0, 2.0 * (abs(value) or span)
    if field == "longest":
        return 1.0, max(2.0, 2.0 * value)
    return value - span, value + span
