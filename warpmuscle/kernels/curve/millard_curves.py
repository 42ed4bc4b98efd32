"""Millard 2013 with the curves of OpenSim's muscle of that name, and with numbers of a muscle's own: tables."""

import warp as wp

from warpmuscle.kernels.curve import millard_tables
from warpmuscle.kernels.curve.curve_functions import CurveFunctions
from warpmuscle.kernels.curve.millard import PLACES, tabulated
from warpmuscle.kernels.curve.shaped_family import ShapedCurves, ShapedFamily, looked_up
from warpmuscle.kernels.functions import func


@func
def millard_active(length: float) -> float:
    """Active force multiplier at a normalised fibre length."""
    return tabulated(length, wp.static(PLACES["active"]))[0]


@func
def millard_passive(length: float) -> float:
    """Passive force multiplier at a normalised fibre length."""
    return tabulated(length, wp.static(PLACES["passive"]))[0]


@func
def millard_tendon(strain: float) -> wp.vec2:
    """Tendon force over f_max at a strain, and its slope."""
    return tabulated(strain, wp.static(PLACES["tendon"]))


@func
def millard_velocity(speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier and its slope at a normalised lengthening speed, never negative."""
    if speed < 0.0:
        return tabulated(speed, wp.static(PLACES["shortening"]))
    return tabulated(speed, wp.static(PLACES["lengthening"]))


CURVES = CurveFunctions(millard_active, millard_passive, millard_velocity, millard_tendon)


# With numbers of a muscle's own.


@func
def shaped_active(curves: ShapedCurves, length: float) -> float:
    """Active force in the muscle's table."""
    return looked_up(curves, length, wp.static(millard_tables.PLACES["active"]))[0]


@func
def shaped_passive(curves: ShapedCurves, length: float) -> float:
    """Passive force in the muscle's table."""
    return looked_up(curves, length, wp.static(millard_tables.PLACES["passive"]))[0]


@func
def shaped_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier in the muscle's table, and its slope."""
    if speed < 0.0:
        return looked_up(curves, speed, wp.static(millard_tables.PLACES["shortening"]))
    return looked_up(curves, speed, wp.static(millard_tables.PLACES["lengthening"]))


@func
def shaped_tendon(curves: ShapedCurves, x: float) -> wp.vec2:
    """Tendon force in the muscle's table, and its slope."""
    return looked_up(curves, x, wp.static(millard_tables.PLACES["tendon"]))


FAMILY = ShapedFamily(shaped_active, shaped_passive, shaped_velocity, shaped_tendon)
