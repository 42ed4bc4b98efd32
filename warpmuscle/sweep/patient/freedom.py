"""What a search for a patient's walk may change besides a scene's own free numbers, as changes of the scene."""

from __future__ import annotations

from typing import Any

from warpmuscle.core.errors import Error
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.muscles import Muscle
from warpmuscle.scene.parameters import Parameter, at_start, free_numbers, free_parameters

STANCE, SWING = ("early_stance", "late_stance", "liftoff"), ("swing", "landing")
STANCE_KNOTS, SWING_KNOTS = 6, 4
STANDS = 0.62  # of a stride, that a foot is on the ground
LEAST = 20  # parts of a number's interval, one of which a search may always go to either side
CONTROLLERS = ("controller.", "gait_states.")


def feed_forward(scene: Scene, most: float, stride: float) -> dict[str, Any]:
    """Changes that add to each leg muscle's excitation a curve over stance and one over swing, which begin at 0.

    Reflexes alone make few of the walks that people have. A curve goes straight from knot to knot, which divide the
    stance and the swing of the patient's stride, and each knot is free.

    Args:
        most: that a curve adds or takes away at a knot. stride: time of the patient's stride, s.

    Raises:
        Error: the scene has no states of gait, or no muscles with paths on its legs.
    """
    if scene.gait_states is None:
        raise Error("is for scenes with [gait_states], such as SCONE's after `warpmuscle convert`")
    phases = (("stance", STANCE, STANCE_KNOTS, STANDS), ("swing", SWING, SWING_KNOTS, 1.0 - STANDS))
    knot = {"value": 0.0, "min": -most, "max": most}
    found: dict[str, Any] = {}
    for number, side in enumerate(SIDES):
        for muscle in _leg_muscles(scene, number):
            for phase, states, knots, part in phases:
                name = f"{muscle}_{phase}"
                if name not in scene.gait_states.patterns:
                    found[f"gait_states.patterns.{name}"] = {
                        "muscle": muscle, "side": side, "during": list(states), "flat": True,
                        "values": [dict(knot) for _ in range(knots)],
                        "intervals": [round(part * stride / (knots - 1), 4)] * (knots - 1),
                    }  # fmt: skip
    if not found and not scene.gait_states.patterns:
        raise Error("the scene has no muscle whose path touches one leg alone")
    return found


def _leg_muscles(scene: Scene, side: int) -> list[str]:
    """Muscles that are fixed to a body of one leg, and to none of the other."""
    joints = scene.character.joints
    legs = [{joints[name].child for name in leg_joints(at_start(scene), number)} for number in (0, 1)]

    def touches(muscle: Muscle, bodies: set[str]) -> bool:
        return any(point.body in bodies for point in muscle.path)

    muscles = scene.character.muscles
    return [name for name, own in muscles.items() if touches(own, legs[side]) and not touches(own, legs[1 - side])]


def within_reach(scene: Scene, reach: float) -> dict[str, Any]:
    """Changes that narrow the intervals of the controller's free numbers to so many times their values to either side.

    Steps of a search are fractions of intervals. SCONE's gains may mostly be -10 to 10, whatever they are, and steps
    that suit the greatest of them make the model fall by the others. A number may always change by a twentieth of its
    interval, so that one that is 0 does not stay so.
    """
    commanded = {name for name, number, _ in free_numbers(scene) if number.per}
    return {
        parameter.name: _narrow(parameter, reach)
        for parameter in free_parameters(scene)
        if parameter.name.startswith(CONTROLLERS) and not any(parameter.name.startswith(name) for name in commanded)
    }


def _narrow(parameter: Parameter, reach: float) -> dict[str, Any]:
    """The declaration of a free number with a narrower interval."""
    way = max(reach * abs(parameter.value), (parameter.max - parameter.min) / LEAST)
    found: dict[str, Any] = {
        "value": parameter.value,
        "min": max(parameter.min, parameter.value - way),
        "max": min(parameter.max, parameter.value + way),
    }
    if parameter.scale != "linear":
        found["scale"] = parameter.scale
    return found | ({"step": parameter.step} if parameter.step else {})
