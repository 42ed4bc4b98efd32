"""Musculotendon paths whose length is a polynomial of joints' coordinates, and whose moment arms are its gradient."""

import warp as wp

from warpmuscle.kernels.path import PathState, add_crossings, coordinate_gradient
from warpmuscle.kernels.register_rows import rows_of
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at, whole

MOST_VARIABLES, EXPONENT_BITS = 6, 5  # of the exponents of a term, which share an integer
EXPONENT = 31  # the largest, all bits set

variables = wp.types.vector(length=MOST_VARIABLES, dtype=float)
entry, with_entry = rows_of(MOST_VARIABLES).length, rows_of(MOST_VARIABLES).with_length


@wp.func
def power(x: float, exponent: int) -> float:
    """x to a whole power, 1 for 0."""
    result = wp.float32(1.0)
    for _ in range(exponent):
        result *= x
    return result


@wp.struct
class Monomial:
    """A product of powers and its derivatives by the variables."""

    value: float
    slopes: variables


@wp.func
def monomial(exponents: int, q: variables, count: int) -> Monomial:
    """The product of powers of q, with its derivatives, from one pass over the variables.

    Args:
        exponents: of each, in its bits. count: how many there are.
    """
    m = Monomial()
    m.value = 1.0
    for i in range(count):
        exponent = (exponents >> (EXPONENT_BITS * i)) & EXPONENT
        if exponent > 0:
            x = entry(q, i)
            below = power(x, exponent - 1)
            m.slopes = with_entry(m.slopes * (below * x), i, m.value * below * float(exponent))
            m.value *= below * x
    return m


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
        now = state.coordinates[instance, model.skeleton.plan[own.joint].coordinate_start + own.axis]
        q = with_entry(q, i, now)
    total = PathState()
    slopes = variables()
    for k in range(span.first_term, span.end_term):
        m = monomial(routes.exponents[whole(k)], q, count)
        coefficient = at(routes.coefficient, instance, k)
        total.moving += coefficient * m.value
        slopes += m.slopes * coefficient
    for i in range(count):
        own = routes.variable[span.first_variable + i]
        r = coordinate_gradient(instance, own.joint, own.axis, model, work) * entry(slopes, i)
        if own.first == 0:
            r += arm[own.crossing]
        arm[own.crossing] = r
    add_crossings(total, muscle, model, work, arm)
    return total
