"""Actuators and ligaments: what pulls along a path among the muscles of a step, and is no muscle."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.piecewise import piecewise
from warpmuscle.kernels.curve.curve_sets import BLANKEVOORT, LIGAMENT, PATH_ACTUATOR
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.contraction import Contraction
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import ModelRef, MuscleRow, ScratchRef, StateRef, at


@func
def ligament_tension(table: wp.array[wp.vec2], first: int, stretch: float, speed: float) -> float:
    """Tension over its scale at a length over that at rest, and a speed of lengthening, m/s: OpenSim's Ligament.

    The head of its function has the dissipation of a PathSpring, s/m, behind the number of pieces.
    """
    if stretch <= 1.0:
        return 0.0
    return piecewise(table, first, stretch) * (1.0 + table[first][1] * speed)


@func
def blankevoort_tension(table: wp.array[wp.vec2], first: int, strain: float, rate: float) -> float:
    """Tension over the stiffness at a strain and its rate, 1/s, of Blankevoort and Huiskes 1991, eq. 1.

    A toe of e^2/(2 e_t) up to the transition strain e_t, and e - e_t/2 beyond. A damper, as OpenSim adds one, acts as
    long as the ligament is taut and lengthens. The table has e_t and the damper's coefficient over the stiffness, s.
    """
    transition = table[first][0]
    if strain <= 0.0:
        return 0.0
    toe = wp.where(strain < transition, 0.5 * strain * strain / transition, strain - 0.5 * transition)
    return toe + table[first][1] * wp.max(rate, 0.0)


@func
def is_cable(instance: int, m: int, model: ModelRef) -> bool:
    """Whether one of the muscles is an actuator or a ligament."""
    return at(model.muscles.shape, instance, m).curves >= PATH_ACTUATOR


@func
def ligament_force(instance: int, m: int, length: float, speed: float, row: MuscleRow, model: ModelRef) -> float:
    """Tension, N, of one of the cables at a length, m, and speed, m/s, of its path; an actuator has none by itself."""
    shape = at(model.muscles.shape, instance, m)
    if shape.curves == LIGAMENT:
        return row.f_max * ligament_tension(model.muscles.curve_table, shape.table, length / row.l_slack, speed)
    if shape.curves == BLANKEVOORT:
        strain, rate = length / row.l_slack - 1.0, speed / row.l_slack
        return row.f_max * blankevoort_tension(model.muscles.curve_table, shape.table, strain, rate)
    return 0.0


@func
def cable_signals(instance: int, m: int, activation: float, excitation: float, model: ModelRef) -> wp.vec2:
    """Activation and excitation: an actuator follows at once, a ligament has none, and muscles keep theirs."""
    curves = at(model.muscles.shape, instance, m).curves
    if curves >= LIGAMENT:
        return wp.vec2(0.0, 0.0)
    return wp.vec2(wp.where(curves == PATH_ACTUATOR, wp.clamp(excitation, 0.0, 1.0), activation), excitation)


@cache
def with_cables(contraction: Any) -> Any:
    """The Warp function of `contraction.contraction_of` where some muscles are cables."""

    @wp.func
    def contracted(
        instance: int, m: int, activation: float, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef
    ) -> Contraction:
        shape = at(model.muscles.shape, instance, m)
        if shape.curves < PATH_ACTUATOR:
            return contraction(instance, m, activation, stretch, row, model, state)
        c = Contraction()
        c.length = stretch.fixed + stretch.moving
        c.speed = stretch.speed
        c.force = row.f_max * activation
        if shape.curves != PATH_ACTUATOR:
            c.force = ligament_force(instance, m, c.length, c.speed, row, model)
        return c

    return contracted


@cache
def terms_of_muscles(add_terms: Any) -> Any:
    """The Warp function of `term_sums.muscle_terms_of` that leaves out cables, which take no effort."""

    @wp.func
    def add(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
        if not is_cable(instance, m, model):
            add_terms(instance, m, w, model, state, work)

    return add
