"""The curves of OpenSim's Schutte1993Muscle_Deprecated, Delp1990Muscle_Deprecated and RigidTendonMuscle."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import Function, read_function
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import OldCurves

ACTIVE, PASSIVE, TENDON = "active_force_length_curve", "passive_force_length_curve", "tendon_force_length_curve"
VELOCITY = "force_velocity_curve"
# Defaults of OpenSim 4.6, the constructors of both classes:
ACTIVE_CURVE = Function(
    x=(-5.307692, -4.307692, -1.923077, -0.884615, -0.269231, 0.230769, 0.461538, 0.52725, 0.62875, 0.71875, 0.86125,
       1.045, 1.2175, 1.43875, 1.5, 1.615385, 2.0, 2.961538, 3.692308, 5.461538, 9.901902),
    y=(0.012188, 0.021899, 0.036466, 0.052493, 0.075312, 0.114158, 0.157859, 0.226667, 0.636667, 0.856667, 0.95,
       0.993333, 0.77, 0.246667, 0.193821, 0.133252, 0.072683, 0.044417, 0.036341, 0.021899, 0.007332),
)  # fmt: skip
RIGID_PASSIVE_CURVE = Function(
    x=(-5.0, 0.998, 0.999, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.601, 1.602, 5.0),
    y=(0.0, 0.0, 0.0, 0.0, 0.035, 0.12, 0.26, 0.55, 1.17, 2.0, 2.0, 2.0, 2.0),
)
TENDON_CURVE = Function(
    x=(-10.0, -0.002, -0.001, 0.0, 0.00131, 0.00281, 0.00431, 0.00581, 0.00731, 0.00881, 0.0103, 0.0118, 0.0123, 9.2,
       9.201, 9.202, 20.0),
    y=(0.0, 0.0, 0.0, 0.0, 0.0108, 0.0257, 0.0435, 0.0652, 0.0915, 0.123, 0.161, 0.208, 0.227, 345.0, 345.0, 345.0,
       345.0),
)  # fmt: skip
SPEEDS = (-1.001, *(round(-1.0 + 0.05 * k, 2) for k in range(41)))
RIGID_VELOCITY_CURVE = Function(
    x=SPEEDS,
    y=(0.0, 0.0, 0.010417, 0.021739, 0.034091, 0.047619, 0.0625, 0.078947, 0.097222, 0.117647, 0.140625, 0.166667,
       0.196429, 0.230769, 0.270833, 0.318182, 0.375, 0.444444, 0.53125, 0.642857, 0.791667, 1.0, 1.482014, 1.601571,
       1.655791, 1.686739, 1.706751, 1.720753, 1.731099, 1.739055, 1.745365, 1.75049, 1.754736, 1.758312, 1.761364,
       1.763999, 1.766298, 1.768321, 1.770115, 1.771717, 1.773155, 1.774455),
)  # fmt: skip
LENGTHS = np.linspace(0.0, 2.0, 81)
EXPONENTIAL = Function(  # of a Schutte1993Muscle_Deprecated that says nothing: 1 at 1.5 of its optimal length
    x=tuple(map(float, LENGTHS)), y=tuple(map(float, np.exp(8.0 * (LENGTHS - 1.5)))), ends="natural"
)
DAMPING = 0.1  # of Schutte's fibre
FEW, MANY = 201, 2000  # knots for a function that has none; of one that is read


def old_curves(element: Element, own: Properties, rigid: bool) -> OldCurves | None:
    """The curves of a muscle of one of these classes; None if a function of it is not known here.

    Args:
        rigid: its tendon, and then its force over speed is a curve, too.
    """
    try:
        active, passive = _curve(element, own, ACTIVE), _curve(element, own, PASSIVE)
        tendon, velocity = _curve(element, own, TENDON), _curve(element, own, VELOCITY)
    except SceneError:
        return None
    active, tendon = active or ACTIVE_CURVE, tendon or TENDON_CURVE
    if rigid:
        return OldCurves(active, passive or RIGID_PASSIVE_CURVE, TENDON_CURVE, velocity or RIGID_VELOCITY_CURVE, 0.0)
    return OldCurves(active, passive or EXPONENTIAL, tendon, None, own.number(element, "damping", DAMPING))


def _curve(element: Element, own: Properties, name: str) -> Function | None:
    """A function through knots by its name, which is that of an element that holds it or its own."""
    found = next((child for child in element.children if name in (child.tag, child.name)), None)
    found = found if found is not None else own.find(element, name)
    if found is None:
        return None
    inner = [child for child in found.children if child.children] if found.tag == name else [found]
    if not inner:
        return None
    for part in inner[0].all():
        _without_repeated_knots(part)
    function = read_function(inner[0])
    if function.x:
        function = function.sparse(MANY)
        return function if len(function.x) <= MANY else None
    x = np.linspace(0.0, 3.0, FEW)
    return Function(x=tuple(map(float, x)), y=tuple(map(float, function.values(x))), ends="natural")


def _without_repeated_knots(element: Element) -> None:
    """Leave out a knot at the place of the one before it, as some files have it."""
    xs, ys = element.child("x"), element.child("y")
    if xs is None or ys is None:
        return
    x, y = xs.text.split(), ys.text.split()
    if len(x) != len(y):
        return
    kept = [k for k in range(len(x)) if k == 0 or x[k] != x[k - 1]]
    xs.text, ys.text = " ".join(x[k] for k in kept), " ".join(y[k] for k in kept)
