"""What the numbers of a scene are called where people move them: `swing hip angle, deg`, in place of their paths."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.scene import Component, Curve, Scene
from warpmuscle.scene.number import Free
from warpmuscle.view.packing import encodable

Path = tuple[str, ...]
DEGREES = float(np.degrees(1.0))
FIELDS = {
    "kp": "stiffness (kp)", "kd": "damping (kd)", "torque_limit": "torque limit", "scale": "torque scale",
    "f_max": "maximum force (f_max)", "l_opt": "optimal fibre length (l_opt)",
    "l_slack": "tendon slack length (l_slack)",
    "cd": "distance feedback (cd)", "cv": "speed feedback (cv)", "d_limits": "distance feedback limit",
    "v_limits": "speed feedback limit", "time": "duration", "longest": "longest phase",
    "distance_x": "sideways distance", "distance_z": "forward distance",
    "velocity_x": "sideways velocity", "velocity_z": "forward velocity",
}  # fmt: skip
TURNS = {"x": "angle", "y": "rotation", "z": "sideways angle"}  # of a joint, about axes to the left, up and forward
AXES = ("x", "y", "z")
ENDS = ("lower", "upper")
OF_AXES = ("scale", "axis", "root_velocity", "root_position", "root_angular_velocity")


class Called(NamedTuple):
    """Group, name within it, and the whole name of a number or a curve."""

    group: str
    name: str
    full: str


def shown_unit(unit: str) -> tuple[str, float]:
    """The unit in which people read a number, and the factor to it: degrees for what is in or per radians of angle."""
    if unit.split(" ")[0].split("/")[0] == "rad":
        return unit.replace("rad", "deg", 1), DEGREES
    return unit, 1.0


def called(path: Path, scene: Scene) -> Called:
    """What stands at a path in a scene is called."""
    if path[0] == "character" and path[1:2] == ("muscles",) and len(path) > 3:
        return _in_group(f"muscle {path[2]}", f"{path[2]}", _words(path[3:]))
    if path[0] == "custom_controller_parameters":
        return _in_group("own controller", "", _words(path[1:]))
    if path[0] != "controller" or len(path) < 2:
        return _in_group(spoken(path[0]), "", _words(path[1:]) or spoken(path[0]))
    rest = path[1:]
    if rest[0] in ("pd", "by_joint", "by_body", "by_muscle") and len(rest) > 2:
        of = rest[1] if rest[0] == "by_muscle" else joint_words(rest[1])
        return _in_group(f"gains, {of}", of, _words(rest[2:]))
    if rest[0] == "states" and len(rest) > 2 and scene.simbicon is not None:
        return _in_state(rest, scene)
    if rest[:2] == ("reflexes", "muscles") and len(rest) > 3:
        return _in_group(f"reflexes, {rest[2]}", f"{rest[2]} reflex", _words(rest[3:]))
    return _in_group("controller", "", _words(rest))


def _in_group(group: str, owner: str, name: str) -> Called:
    return Called(encodable(group), encodable(name), encodable(f"{owner} {name}".strip()))


def _in_state(rest: Path, scene: Scene) -> Called:
    """What stands in a state of a SIMBICON controller."""
    assert scene.simbicon is not None
    several = len(scene.simbicon.states) > 1
    state = f"state {rest[1]}" if several else "step"
    if rest[2] == "trajectories" and len(rest) > 4:
        joint = joint_words(rest[3])
        group = f"{state}, {joint}" if several else joint
        of = f"{joint} ({state})" if several else joint
        if rest[4] == "components" and len(rest) > 5:
            return _in_group(group, of, _in_trajectory(rest, scene))
        return _in_group(group, of, _of_curve(rest[4:], _curve_at(rest, scene)))
    if rest[2] == "balance" and len(rest) > 3:
        return _in_group(f"{state}, balance", "balance", _of_curve(rest[3:], _curve_at(rest, scene)))
    return _in_group(state, state, _words(rest[2:]))


def _in_trajectory(rest: Path, scene: Scene) -> str:
    """Name of what stands within a trajectory's rotation: the angle, one of its points, its feedback."""
    assert scene.simbicon is not None
    components = scene.simbicon.states[int(rest[1])].trajectories[rest[3]].components
    turns = [_turn(component) for component in components]
    number = int(rest[5])
    turn, component, below = turns[number], components[number], rest[6:]
    if turns.count(turn) > 1:
        turn = f"{turn}, turn {number + 1}"
    if below[:1] == ("angle",):
        return f"{turn}{_at_point(below, component.phase)}" + _command(below[2:])
    if below[:1] == ("phase",) and len(below) > 1:
        return f"{turn}, phase of point {int(below[1]) + 1}"
    if below[:2] == ("feedback", "axis"):
        return f"{turn}, {_words(below)}"
    if below[:1] == ("feedback",):
        return f"{turn}, {_words(below[1:])}"
    return f"{turn}, {_words(below)}" if below else turn


def _turn(component: Component) -> str:
    """What a rotation about its axis is called."""
    axis = [number.value if isinstance(number, Free) else float(number) for number in component.axis]
    turned = [letter for letter, number in zip(AXES, axis, strict=True) if number]
    return TURNS[turned[0]] if len(turned) == 1 else "angle about its axis"


def _at_point(below: Path, phases: Sequence[object]) -> str:
    """Which point of a curve it is: by its phase, where that is a plain number."""
    if len(below) < 2 or not below[1].isdigit() or len(phases) < 2:
        return ""
    number = int(below[1])
    phase = phases[number] if number < len(phases) else None
    if isinstance(phase, int | float):
        percent = 100.0 * phase
        return f" at {percent:.{1 if percent < 10.0 else 0}f} %"
    return f", point {number + 1}"


def _of_curve(below: Path, curve: Curve | None) -> str:
    """What stands in a curve over the phase: one of its points, or all of it."""
    name = FIELDS.get(below[0], spoken(below[0]))
    if len(below) > 2 and curve is not None and below[2].isdigit():
        if below[1] == "value":
            return f"{name}{_at_point(below[1:], list(curve.phase))}" + _command(below[3:])
        return f"{name}, phase of point {int(below[2]) + 1}"
    return " ".join((name, _words(below[1:]))).strip()


def _curve_at(rest: Path, scene: Scene) -> Curve | None:
    """The curve that a path within the controller's states leads through."""
    assert scene.simbicon is not None
    state = scene.simbicon.states[int(rest[1])]
    owner = state.balance if rest[2] == "balance" else state.trajectories[rest[3]]
    curve = getattr(owner, rest[3] if rest[2] == "balance" else rest[4], None)
    return curve if isinstance(curve, Curve) else None


def _command(below: Path) -> str:
    return f", per {spoken(' '.join(below[1:]))}" if below[:1] == ("per",) else ""


def _words(path: Path) -> str:
    """The words of a path: fields by their names, indices as axes, ends, or numbers from 1 on."""
    words: list[str] = []
    for place, one in enumerate(path):
        before = path[place - 1] if place else ""
        if not one.isdigit():
            words.append(f"per {spoken(path[place + 1])}" if one == "per" and place + 1 < len(path)
                         else "" if before == "per" else FIELDS.get(one, spoken(one)))  # fmt: skip
        elif before in OF_AXES and int(one) < len(AXES):
            words.append(f"({AXES[int(one)]})")
        elif before.endswith("_limits") and int(one) < len(ENDS):
            words.append(f"({ENDS[int(one)]})")
        else:
            words.append(str(int(one) + 1))
    return " ".join(word for word in words if word)


def spoken(name: str) -> str:
    """A key of a scene as words."""
    return name.replace("_", " ").strip()


def joint_words(name: str) -> str:
    """A joint's name as words: `lHip` is left hip, `SWING_Ankle` swing ankle, `knee_r` right knee."""
    side = ""
    if re.fullmatch(r"[lr][A-Z].*", name):
        side, name = name[0], name[1:]
    elif re.fullmatch(r".+_[lr]", name):
        side, name = name[-1], name[:-2]
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).replace("_", " ").lower().split()
    return " ".join(([{"l": "left", "r": "right"}[side]] if side else []) + words) or name
