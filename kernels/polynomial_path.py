"""Musculotendon paths whose length is a polynomial of joints' coordinates, and whose moment arms are its gradient.

Muscles that cross the same joints share most powers and products of their coordinates. So all of these are computed
once a step, each from one of lower degree; length and derivatives of a path are then sums of some of them, times
coefficients.
"""

import warp as wp

from warpmuscle.kernels.path import PathState, add_crossings, coordinate_gradient
from warpmuscle.kernels.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at, whole


@wp.func
def monomial_value(instance: int, k: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """A product of powers of coordinates, from one of lower degree."""
    own = model.routes.monomial[k]
    start = model.skeleton.plan[own.joint].coordinate_start
    return work.monomial[whole(own.before)] * state.coordinates[instance, whole(start + own.axis)]


@wp.func
def monomials_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """All products of powers that some path needs, degree by degree. Ends with a barrier."""
    start = model.routes.degree_start
    if lane == 0:
        work.monomial[0] = 1.0
    synchronize()
    for degree in range(1, start.shape[0] - 1):
        for k in range(whole(start[degree] + lane), start[degree + 1], lanes):
            work.monomial[k] = monomial_value(instance, k, model, state, work)
        synchronize()


@wp.func
def weighted_sum(instance: int, first: int, end: int, model: ModelRef, work: ScratchRef) -> float:
    """The sum of some terms, in order."""
    total = wp.float32(0.0)
    for k in range(whole(first), end):
        term = at(model.routes.term, instance, k)
        total += term.coefficient * work.monomial[whole(term.monomial)]
    return total


@wp.func(inline=True)
def polynomial_stretch(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
) -> PathState:
    """What `path.segments_stretch_of` says, of a path that is a polynomial."""
    routes = model.routes
    span = routes.polynomial[muscle]
    total = PathState()
    total.moving = weighted_sum(instance, span.first_term, span.end_term, model, work)
    for i in range(span.first_variable, span.end_variable):
        own = routes.variable[i]
        slope = weighted_sum(instance, own.first_term, own.end_term, model, work)
        r = coordinate_gradient(instance, own.joint, own.axis, model, work) * slope
        if own.first == 0:
            r += arm[own.crossing]
        arm[own.crossing] = r
    add_crossings(total, muscle, model, work, arm)
    return total
