"""What a fibre does in a step, from its activation and the path of its muscle: the laws of contraction."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.curve.custom_curves import CustomCurves, with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped, shaped_curves
from warpmuscle.kernels.muscle import muscle
from warpmuscle.kernels.muscle.muscle import (
    UNSETTLED,
    pennation_cosine,
    rigid_fibre_speed,
    switched_fibre_length,
    switched_fibre_speed,
)
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import ModelRef, MuscleRow, StateRef, at

RIGID, SWITCH, COMPLIANT, EITHER = 0, 1, 2, 3  # tendons; either: each muscle its own, rigid or compliant


@wp.struct
class Contraction:
    """What a fibre does in a step."""

    length: float  # m
    speed: float  # m/s
    force: float  # N, along the tendon
    damping: float  # N s/m, of the force by the speed of the path, if implicit


@cache
def contraction_of(curves: int, tendon: int, implicit: bool = False, own: CustomCurves | Shaped | None = None) -> Any:
    """The Warp function (instance, muscle, activation, stretch, row, model, state) -> Contraction of a kind.

    Muscles with curves of their own have OpenSim's bounds of the fibre.
    """
    if tendon == COMPLIANT:
        return compliant_of(curves, own)
    if tendon != EITHER:
        return rigid_of(curves, tendon == SWITCH, implicit, own)
    rigid, compliant = rigid_of(curves, False, implicit, own), compliant_of(curves, own)

    @wp.func
    def either(
        instance: int, m: int, activation: float, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef
    ) -> Contraction:
        if at(model.muscles.shape, instance, m).tendon == COMPLIANT:
            return compliant(instance, m, activation, stretch, row, model, state)
        return rigid(instance, m, activation, stretch, row, model, state)

    return either


@cache
def curves_of_muscle(curves: int, own: CustomCurves | Shaped | None) -> Any:
    """The Warp function (instance, muscle, model) of what functions of `muscle` take as the number of its curves."""
    if isinstance(own, Shaped):
        return shaped_curves

    @wp.func
    def of_all(instance: int, m: int, model: ModelRef) -> int:
        return curves

    return of_all


@cache
def rigid_of(curves: int, switching: bool, implicit: bool, own: CustomCurves | Shaped | None) -> Any:
    """The Warp function of `contraction_of` for rigid tendons, or for those that switch between two lengths."""
    shaped = isinstance(own, Shaped)
    switching = switching and not shaped
    bounded_length, rigid_length, fibre_force = (
        with_curves(function, own, curves)
        for function in (muscle.bounded_fibre_length, muscle.rigid_fibre_length, muscle.fibre_force)
    )
    fibre_damping = with_curves(muscle.fibre_damping, own, curves) if implicit else None
    curves_of = curves_of_muscle(curves, own)
    switched_length, switched_speed = (switched_fibre_length, switched_fibre_speed) if switching else (None, None)

    @wp.func
    def rigid(
        instance: int, m: int, activation: float, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef
    ) -> Contraction:
        l_opt = row.l_opt
        slack = row.l_slack - stretch.fixed
        width = row.width
        c = Contraction()
        of_muscle = curves_of(instance, m, model)
        if wp.static(switching):
            c.length = bounded_length(switched_length(stretch.moving, l_opt, slack), l_opt, 0.0)
            c.speed = switched_speed(stretch.moving, stretch.speed, l_opt, slack)
        else:
            c.length = rigid_length(stretch.moving, l_opt, slack, width)
            if wp.static(shaped):
                shortest = bounded_length(of_muscle.row.shortest * l_opt, l_opt, width)
                if c.length <= shortest:  # the tendon is slack
                    c.length = shortest
                    return c
            c.speed = rigid_fibre_speed(stretch.speed, c.length, width)
        x = c.length / l_opt
        speed = c.speed / (row.v_max * l_opt)
        force = fibre_force(of_muscle, activation, x, speed, row.damping)
        c.force = row.f_max * force * pennation_cosine(c.length, width)
        if wp.static(implicit):
            cosine = pennation_cosine(c.length, width)
            slope = fibre_damping(of_muscle, activation, x, speed, row.damping) * cosine * cosine
            c.damping = slope * row.f_max / (row.v_max * l_opt)
        return c

    return rigid


@cache
def compliant_of(curves: int, own: CustomCurves | Shaped | None) -> Any:
    """The Warp function of `contraction_of` for compliant tendons."""
    fibre_equilibrium, compliant_step, compliant_force, bounded_length = (
        with_curves(function, own, curves)
        for function in (
            muscle.fibre_equilibrium, muscle.compliant_step, muscle.compliant_force, muscle.bounded_fibre_length,
        )
    )  # fmt: skip
    curves_of, shaped = curves_of_muscle(curves, own), isinstance(own, Shaped)

    @wp.func
    def compliant(
        instance: int, m: int, activation: float, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef
    ) -> Contraction:
        l_opt = row.l_opt
        l_slack = row.l_slack
        width = row.width
        shortest = wp.float32(0.0)
        of_muscle = curves_of(instance, m, model)
        if wp.static(shaped):
            shortest = bounded_length(of_muscle.row.shortest * l_opt, l_opt, width)
        path_length = stretch.fixed + stretch.moving
        unsettled = state.muscles.fibre_length[instance, m] == UNSETTLED
        if state.step[instance] == 0 or unsettled:
            settled = fibre_equilibrium(of_muscle, activation, path_length, l_opt, l_slack, width)
            if wp.static(shaped):
                settled = wp.max(settled, shortest)
            state.muscles.fibre_length[instance, m] = settled
            state.muscles.previous_fibre_length[instance, m] = settled
        before = state.muscles.fibre_length[instance, m]
        c = Contraction()
        c.length = compliant_step(
            of_muscle, activation, path_length, before, state.muscles.previous_fibre_length[instance, m],
            l_opt, l_slack, width, row.v_max, row.damping, model.time_step,
        )  # fmt: skip
        if wp.static(shaped):
            c.length = wp.max(c.length, shortest)
        state.muscles.previous_fibre_length[instance, m] = before
        state.muscles.fibre_length[instance, m] = c.length
        c.speed = (c.length - before) / model.time_step
        c.force = row.f_max * compliant_force(of_muscle, path_length, c.length, l_slack, width)
        return c

    return compliant
