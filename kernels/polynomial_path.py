"""Musculotendon paths whose length is a polynomial of joints' coordinates, and whose moment arms are its gradient."""

import warp as wp

from warpmuscle.kernels.path import PathState, add_crossings, coordinate_gradient
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

MOST_VARIABLES, EXPONENT_BITS = 6, 5  # of the exponents of a term, which share an integer
EXPONENT = 31  # the largest, all bits set

variables = wp.types.vector(length=MOST_VARIABLES, dtype=float)


@wp.func
def power(x: float, exponent: int) -> float:
    """x to a whole power, 1 for 0."""
    result = wp.float32(1.0)
    for _ in range(exponent):
        result *= x
    return result


@wp.func
def monomial(exponents: int, q: variables, count: int, by: int) -> float:
    """The product of powers of q, or its derivative by one of them; by -1: itself.

    Args:
        exponents: of each, in its bits. count: how many there are.
    """
    result = wp.float32(1.0)
    for i in range(count):
        exponent = (exponents >> (EXPONENT_BITS * i)) & EXPONENT
        if i == by:
            result *= float(exponent)
            exponent = wp.max(exponent - 1, 0)
        result *= power(q[i], exponent)
    return result


@wp.func(inline=True)
def polynomial_stretch(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
) -> PathState:
    """What `path.segments_stretch_of` says, of a path that is a polynomial."""
    routes = model.routes
    span = routes.polynomial[muscle]
    count = span.end_variable - span.first_variable
    q = variables()
    for i in range(count):
        own = routes.variable[span.first_variable + i]
        q[i] = state.coordinates[instance, model.skeleton.plan[own.joint].coordinate_start + own.axis]
    total = PathState()
    for k in range(span.first_term, span.end_term):
        total.moving += at(routes.coefficient, instance, k) * monomial(routes.exponents[k], q, count, -1)
    for i in range(count):
        own = routes.variable[span.first_variable + i]
        slope = wp.float32(0.0)
        for k in range(span.first_term, span.end_term):
            slope += at(routes.coefficient, instance, k) * monomial(routes.exponents[k], q, count, i)
        r = coordinate_gradient(instance, own.joint, own.axis, model, work) * slope
        if own.first == 0:
            r += arm[own.crossing]
        arm[own.crossing] = r
    add_crossings(total, muscle, model, work, arm)
    return total
