"""Muscles with curves through knots as OpenSim's Schutte1993Muscle_Deprecated and RigidTendonMuscle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from warpmuscle.formats.osim.muscles.old_curves import ACTIVE, PASSIVE, TENDON, VELOCITY
from warpmuscle.formats.osim.xml_text import element, function_xml, numbers
from warpmuscle.scene import Muscle, SplineCurves
from warpmuscle.scene.initial_pose import plain_number


def old_muscle_xml(
    muscle: Muscle, shape: SplineCurves, name: str, path: str, value: Callable[[str], Any], lose: Callable[[str], None]
) -> str:
    """A muscle, with the element of its path.

    Args:
        value: a number of the muscle, or of the model of all. lose: is told what a model cannot hold.
    """
    rigid = shape.velocity is not None
    values = {
        "max_isometric_force": muscle.f_max, "optimal_fiber_length": muscle.l_opt,
        "tendon_slack_length": muscle.l_slack, "pennation_angle_at_optimal": muscle.pennation,
        "max_contraction_velocity": value("v_max"),
    }  # fmt: skip
    curves = {ACTIVE: shape.active, PASSIVE: shape.passive}
    if rigid:
        if value("tendon") != "rigid":
            lose("a muscle with a curve over speed has a rigid tendon in OpenSim, and no activation of its own")
        curves[VELOCITY] = shape.velocity  # type: ignore[assignment]
    else:
        if value("tendon") != "compliant":
            lose("a muscle with Schutte's force over speed has a compliant tendon in OpenSim")
        curves[TENDON] = shape.tendon
        scale = 1.0 / plain_number(value("v_max"))
        fall = scale / plain_number(value("fall_time"))
        values |= {
            "time_scale": scale, "activation1": scale / plain_number(value("rise_time")) - fall, "activation2": fall,
            "damping": value("damping"),
        }  # fmt: skip
    if plain_number(muscle.delay):
        lose("its delay is not held")
    inner = path + "".join(element(tag, numbers([plain_number(number)])) for tag, number in values.items())
    inner += "".join(function_xml(curve.displacement, tag) for tag, curve in curves.items())
    return element("RigidTendonMuscle" if rigid else "Schutte1993Muscle_Deprecated", inner, name=name)
