"""Muscles of older and simpler classes of OpenSim, as Thelen2003Muscles along the same paths."""

from __future__ import annotations

import numpy as np

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.xml_text import numbers

STAND_IN = "Thelen2003Muscle"
OF_TIME_SCALE = ("Schutte1993Muscle", "Schutte1993Muscle_Deprecated", "Delp1990Muscle", "Delp1990Muscle_Deprecated")
RIGID = "RigidTendonMuscle"
KINDS = (*OF_TIME_SCALE, RIGID)
SHARED = ("max_isometric_force", "optimal_fiber_length", "tendon_slack_length", "pennation_angle_at_optimal",
    "max_contraction_velocity", "default_activation")  # fmt: skip
CURVES = ("active_force_length_curve", "passive_force_length_curve", "tendon_force_length_curve",
    "force_velocity_curve", "fiber_force_velocity_curve")  # fmt: skip
TIME_SCALE, ACTIVATION, DEACTIVATION, V_MAX = 0.1, 7.667, 1.459854, 10.0  # OpenSim's defaults of the old classes
TENDON_UP_TO, FIBRE_UP_TO = 0.2, 1.0  # strains, up to which those at f_max are looked for
REASON = (
    "is taken as a Thelen2003Muscle: its path and numbers are its own, and so are the strains at which {strains} "
    "with f_max; other curves are Thelen's, so that its forces are not quite OpenSim's"
)


def stand_in(element: Element, own: Properties) -> str:
    """Make a muscle of one of `KINDS` one of Thelen's, in place; what there is to say of it."""
    kept = {tag: own.number(element, tag, np.nan) for tag in SHARED}
    passive, tendon = (_strain(element, tag) for tag in CURVES[1:3])
    if element.tag in OF_TIME_SCALE:
        scale = own.number(element, "time_scale", TIME_SCALE)
        rise, fall = own.number(element, "activation1", ACTIVATION), own.number(element, "activation2", DEACTIVATION)
        if not (scale > 0.0 and fall > 0.0 and rise + fall > 0.0):
            element.fail("its <time_scale>, <activation1> and <activation2> must be greater than 0")
        kept |= {"activation_time_constant": scale / (rise + fall), "deactivation_time_constant": scale / fall}
        if not kept["max_contraction_velocity"] > 0.0:
            kept["max_contraction_velocity"] = 1.0 / scale
    kept |= {"FmaxMuscleStrain": passive, "FmaxTendonStrain": tendon}
    rigid = element.tag == RIGID
    for child in element.children:
        if child.tag in CURVES or child.name in CURVES:
            for inner in child.all():
                inner.used = True
    for tag in ("time_scale", "activation1", "activation2", "damping"):
        element.child(tag)
    element.children = [child for child in element.children if child.tag not in kept]
    for tag, value in kept.items():
        if np.isfinite(value):
            element.children.append(_made(element, tag, numbers([value])))
    if rigid:
        element.children = [child for child in element.children if child.tag != "ignore_tendon_compliance"]
        element.children.append(_made(element, "ignore_tendon_compliance", "true"))
    element.tag = STAND_IN
    return REASON.format(strains="fibre and tendon pull" if not rigid else "the fibre pulls")


def _made(near: Element, tag: str, text: str) -> Element:
    return Element(tag, near.file, near.line, "", text, [], used=True)


def _strain(element: Element, name: str) -> float:
    """The strain at which a curve over length or strain is 1; NaN if it has none within reach."""
    start, reach = (0.0, TENDON_UP_TO) if name.startswith("tendon") else (1.0, FIBRE_UP_TO)
    holder = next((child for child in element.children if name in (child.tag, child.name)), None)
    inner = list(holder.all()) if holder is not None else []
    knots = [next((one.numbers() for one in inner if one.tag == tag), []) for tag in ("x", "y")]
    if not knots[0] or len(knots[0]) != len(knots[1]):
        return float("nan")
    x = np.linspace(start, start + reach, 4001)
    order = np.argsort(knots[0], kind="stable")  # some files have a knot twice
    beyond = np.flatnonzero(np.interp(x, np.array(knots[0])[order], np.array(knots[1])[order]) >= 1.0)
    return float(x[beyond[0]] - start) if len(beyond) and beyond[0] > 0 else float("nan")
