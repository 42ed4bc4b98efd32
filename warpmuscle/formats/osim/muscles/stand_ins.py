"""Muscles of old and simple classes, which are read as one of Thelen's with curves of their own."""

from __future__ import annotations

import numpy as np

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.muscles.old_curves import old_curves
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import OldCurves
from warpmuscle.formats.osim.xml_text import numbers

THELEN = "Thelen2003Muscle"
SCHUTTE = ("Schutte1993Muscle", "Schutte1993Muscle_Deprecated")
OF_TIME_SCALE = (*SCHUTTE, "Delp1990Muscle", "Delp1990Muscle_Deprecated")
RIGID = "RigidTendonMuscle"
LIKE = {  # classes whose muscles are near to others, what they are taken for, and what there is to say
    "Thelen2003Muscle_Deprecated": (THELEN, "is taken as a Thelen2003Muscle; the damping of its fibre is not known"),
    "Millard2012AccelerationMuscle": (
        "Millard2012EquilibriumMuscle",
        "is taken as a Millard2012EquilibriumMuscle: its fibre has no mass, and nothing that it pushes",
    ),
}
OLD_THELEN = {"FmaxTendonStrain": 0.033, "KshapeActive": 0.5, "KshapePassive": 4.0, "Af": 0.3, "Flen": 1.8,
    "activation_time_constant": 0.01, "deactivation_time_constant": 0.04, "Vmax": 10.0}  # fmt: skip
NO_MASS = ("FiberCompressiveForceLengthCurve", "FiberCompressiveForceCosPennationCurve", "mass",
    "tendon_force_length_damping", "fiber_force_length_damping", "fiber_compressive_force_length_damping",
    "fiber_compressive_force_cos_pennation_damping")  # fmt: skip
STOOD_FOR = (*OF_TIME_SCALE, RIGID, *LIKE)
KEPT = ("max_isometric_force", "optimal_fiber_length", "tendon_slack_length", "pennation_angle_at_optimal",
    "max_contraction_velocity", "default_activation")  # fmt: skip
OLD_CURVES = ("active_force_length_curve", "passive_force_length_curve", "tendon_force_length_curve",
    "force_velocity_curve", "fiber_force_velocity_curve")  # fmt: skip
TIME_SCALE, ACTIVATION, DEACTIVATION = 0.1, 7.667, 1.459854  # OpenSim's defaults of the old classes
TENDON_UP_TO, FIBRE_UP_TO = 0.2, 1.0  # strains, up to which those at f_max are looked for
TAKEN = (
    "has a curve that is not known here, and is taken as a Thelen2003Muscle: its path and numbers are its own, and so "
    "are the strains at which {strains} with f_max; its forces are not quite OpenSim's"
)
NOTES = {
    "Schutte": "has its own curves, and Schutte's activation",
    "Delp": "has its own curves, but Schutte's force over speed; its fibre has no mass and no speed of its own",
    RIGID: "has its own curves; its activation is its excitation at once, as in OpenSim",
}


def stand_in(element: Element, own: Properties) -> tuple[str, OldCurves | None]:
    """Make a muscle of one of `STOOD_FOR` one of another class, in place; what there is to say of it, and its curves.

    Raises:
        SceneError: its times are none.
    """
    if element.tag in LIKE:
        return _relative(element, own), None
    kept = {tag: own.number(element, tag, np.nan) for tag in KEPT}
    passive, tendon = (_strain(element, tag) for tag in OLD_CURVES[1:3])
    rigid = element.tag == RIGID
    curves = old_curves(element, own, rigid)
    if element.tag in OF_TIME_SCALE:
        kept |= _times(element, own)
    if curves is None:
        kept |= {"FmaxMuscleStrain": passive, "FmaxTendonStrain": tendon}
        note = TAKEN.format(strains="fibre and tendon pull" if not rigid else "the fibre pulls")
    else:
        kept["minimum_activation"] = 0.0
        note = next(text for kind, text in NOTES.items() if element.tag.startswith(kind))
    for child in element.children:
        if child.tag in OLD_CURVES or child.name in OLD_CURVES:
            for inner in child.all():
                inner.used = True
    for tag in ("time_scale", "activation1", "activation2", "damping"):
        element.child(tag)
    element.children = [child for child in element.children if child.tag not in kept]
    for tag, value in kept.items():
        if np.isfinite(value):
            element.children.append(_made(element, tag, numbers([value])))
    if rigid:
        ignored = ("ignore_tendon_compliance", "ignore_activation_dynamics")
        element.children = [child for child in element.children if child.tag not in ignored]
        element.children += [_made(element, tag, "true") for tag in ignored]
    element.tag = THELEN
    return note, curves


def _relative(element: Element, own: Properties) -> str:
    """Make a muscle one of the class that is like its own; what there is to say of it."""
    kind, note = LIKE[element.tag]
    kept = {}
    if kind == THELEN:
        kept = {tag: own.number(element, tag, value) for tag, value in OLD_THELEN.items()}
        kept["max_contraction_velocity"] = kept.pop("Vmax")
        element.child("Vmax", "Vmax0", "damping")
    for tag in NO_MASS:
        for child in element.children:
            if child.tag == tag:
                for inner in (child, *child.all()):
                    inner.used = True
    element.children = [child for child in element.children if child.tag not in kept]
    element.children += [_made(element, tag, numbers([value])) for tag, value in kept.items()]
    element.tag = kind
    return note


def _times(element: Element, own: Properties) -> dict[str, float]:
    """Time constants and greatest speed of a muscle that has a scale of time."""
    scale = own.number(element, "time_scale", TIME_SCALE)
    rise, fall = own.number(element, "activation1", ACTIVATION), own.number(element, "activation2", DEACTIVATION)
    if not (scale > 0.0 and fall > 0.0 and rise + fall > 0.0):
        element.fail("its <time_scale>, <activation1> and <activation2> must be greater than 0")
    return {
        "activation_time_constant": scale / (rise + fall), "deactivation_time_constant": scale / fall,
        "max_contraction_velocity": 1.0 / scale,
    }  # fmt: skip


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
