"""Actuators, ligaments and springs along paths, of a model's records and as a model has them."""

from __future__ import annotations

from collections.abc import Callable

from warpmuscle.core.limits import LIMITS
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.functions import Function, resampled
from warpmuscle.formats.osim.records import Muscle as Record
from warpmuscle.formats.osim.xml_text import element, function_xml, numbers
from warpmuscle.scene import BlankevoortLigament, Displacement, Ligament, Muscle, PathActuator
from warpmuscle.scene.initial_pose import plain_number

LONGEST = 5.0  # resting lengths, up to which a function that is no spline is taken
CONTROLS = "its control is an excitation from 0 to 1 here, where the model lets it be from {:g} to {:g}"


def made_cable(one: Record) -> tuple[Muscle | None, str]:
    """An actuator or a ligament without its path, None if it pulls with nothing; and what there is to say of it."""
    if one.kind == "PathActuator":
        return _actuator(one)
    if one.kind == "Blankevoort1991Ligament":
        return _blankevoort(one)
    rest = one.numbers["resting_length"]
    scale = one.numbers["pcsa_force"] if one.kind == "Ligament" else one.numbers["stiffness"] * rest
    if not rest > 0.0:
        return None, f"its resting_length must be greater than 0, is {rest:g}; it is left out, and pulls on nothing"
    if scale == 0.0:
        return None, "its force is 0 at any length; it is left out"
    if scale < 0.0:
        return None, "a negative force would push along its path; it is left out, and pulls on nothing"
    if one.tension is None:
        ligament = Ligament([1.0, 2.0], [0.0, 1.0], "linear", one.numbers["dissipation"])
        return Muscle(f_max=scale, l_opt=rest, l_slack=rest, curve_shape=ligament), ""
    ligament, reason = _ligament(one.tension)
    ligament.dissipation = one.numbers.get("dissipation", 0.0)
    if one.lost:
        reason = f"its tension {one.lost}"
    return Muscle(f_max=scale, l_opt=rest, l_slack=rest, curve_shape=ligament), reason


def _actuator(one: Record) -> tuple[Muscle | None, str]:
    """A cable that pulls with optimal_force times its control."""
    force, low, high = (one.numbers[name] for name in ("optimal_force", "min_control", "max_control"))
    if force <= 0.0 or high <= 0.0:
        return None, "it would pull with nothing, or push along its path; it is left out"
    reason = CONTROLS.format(low, high) if (low, high) != (0.0, 1.0) else ""
    return Muscle(f_max=force, l_opt=1.0, l_slack=1.0, curve_shape=PathActuator()), reason


def _blankevoort(one: Record) -> tuple[Muscle | None, str]:
    """A ligament with a toe; OpenSim's damping_coefficient is in newtons for a rate of strain of 1/s."""
    stiffness, rest, transition, damping = (
        one.numbers[tag] for tag in ("linear_stiffness", "slack_length", "transition_strain", "damping_coefficient")
    )
    if not (stiffness > 0.0 and rest > 0.0 and transition > 0.0 and damping >= 0.0):
        return None, "its stiffness, slack_length and transition_strain must be greater than 0; it pulls on nothing"
    ligament = BlankevoortLigament(transition, damping / stiffness)
    return Muscle(f_max=stiffness, l_opt=rest, l_slack=rest, curve_shape=ligament), ""


def _ligament(function: Function) -> tuple[Ligament, str]:
    """The curve of a ligament, a function that is no spline through knots; and by how much it is off."""
    if function.x:
        curve = function.sparse(LIMITS["knots"].most)
        return Ligament([*curve.x], [*curve.y], curve.ends), ""
    if function.line is not None:
        return Ligament([1.0, 2.0], [function.at(1.0), function.at(2.0)], "linear"), ""
    spline, error = resampled(function.values, 1.0, LONGEST)
    reason = (
        f"its force_length_curve is taken at {number_of(len(spline.x), 'length')} from 1 to {LONGEST:g}; off "
        f"by {error:.1g}"
    )
    return Ligament([*spline.x], [*spline.y], spline.ends), reason


def cable_xml(muscle: Muscle, path: str, name: str, lose: Callable[[str], None]) -> str:
    """An actuator, a ligament, or a spring, with the element of its path.

    Args:
        lose: is told what a model cannot hold.
    """
    force, rest, shape = plain_number(muscle.f_max), plain_number(muscle.l_slack), muscle.curve_shape
    if plain_number(muscle.delay):
        lose("its delay is not held")
    if isinstance(shape, BlankevoortLigament):
        values = {
            "linear_stiffness": force, "transition_strain": shape.transition_strain,
            "damping_coefficient": force * shape.damping, "slack_length": rest,
        }  # fmt: skip
        return element("Blankevoort1991Ligament", path + _numbers(values), name=name)
    if not isinstance(shape, Ligament):
        values = {"optimal_force": force, "min_control": 0.0, "max_control": 1.0}
        return element("PathActuator", path + _numbers(values), name=name)
    if shape.ends == "linear" and (shape.x, shape.y) == ([1.0, 2.0], [0.0, 1.0]):
        values = {"resting_length": rest, "stiffness": force / rest, "dissipation": shape.dissipation}
        return element("PathSpring", path + _numbers(values), name=name)
    if shape.dissipation:
        lose("only a tension that is straight over length has a dissipation; it is left out")
    curve = Displacement((1.0, 0.0, 0.0), x=shape.x, y=[*shape.y], ends=shape.ends)
    inner = path + _numbers({"resting_length": rest, "pcsa_force": force})
    return element("Ligament", inner + function_xml(curve, "force_length_curve"), name=name)


def _numbers(values: dict[str, float]) -> str:
    return "".join(element(tag, numbers([number])) for tag, number in values.items())
