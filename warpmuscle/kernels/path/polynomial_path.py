"""Musculotendon paths whose length is a polynomial of joints' coordinates, and whose moment arms are its gradient.

Muscles that cross the same joints share most powers and products of their coordinates. So all of these are computed
once a step, each from one of lower degree; length and derivatives of a path are then sums of some of them, times
coefficients.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.path.conditions import coordinate_gradient
from warpmuscle.kernels.path.path import PathState, add_crossings
from warpmuscle.kernels.structs import ModelRef, PolynomialTerm, ScratchRef, StateRef, nonnegative


@func
def monomial_value(instance: int, k: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """A product of powers of coordinates, from one of lower degree."""
    own = model.routes.monomial[k]
    start = model.skeleton.plan[own.joint].coordinate_start
    return work.monomial[nonnegative(own.before)] * state.coordinates[instance, nonnegative(start + own.axis)]


@func
def monomials_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """All products of powers that some path needs, degree by degree. Ends with a barrier."""
    start = model.routes.degree_start
    if lane == 0:
        work.monomial[0] = 1.0
    synchronize()
    for degree in range(1, start.shape[0] - 1):
        for k in range(nonnegative(start[degree] + lane), start[degree + 1], lanes):
            work.monomial[k] = monomial_value(instance, k, model, state, work)
        synchronize()


@wp.func_native(
    snippet="""
const wp::int32 row = wp::min(instance, terms.shape[0] - 1);
float total = 0.0f;
#if defined(__CUDA_ARCH__)
const float2* own = reinterpret_cast<const float2*>(wp::address(terms, row, 0));
#pragma unroll 8
for (int k = first; k < end; ++k) {
    const float2 term = own[k];
    total += term.x * monomials.data[__float_as_int(term.y)];
}
#else
for (int k = first; k < end; ++k) {
    const auto& term = *wp::address(terms, row, k);
    total += term.coefficient * monomials.data[term.monomial];
}
#endif
return total;
"""
)
def weighted_sum(
    instance: int, first: int, end: int, terms: wp.array2d[PolynomialTerm], monomials: wp.array[float]
) -> float: ...  # the sum of some terms, in order, of which a GPU fetches several at once, each whole


@func(inline=True)
def polynomial_stretch(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
) -> PathState:
    """What `path.segments_stretch_of` says, of a path that is a polynomial."""
    routes = model.routes
    span = routes.polynomial[muscle]
    total = PathState()
    total.moving = weighted_sum(instance, span.first_term, span.end_term, routes.term, work.monomial)
    for i in range(span.first_variable, span.end_variable):
        own = routes.variable[i]
        slope = weighted_sum(instance, own.first_term, own.end_term, routes.term, work.monomial)
        r = coordinate_gradient(instance, own.joint, own.axis, model, work) * slope
        if own.first == 0:
            r += arm[own.crossing]
        arm[own.crossing] = r
    add_crossings(total, muscle, model, work, arm)
    return total
