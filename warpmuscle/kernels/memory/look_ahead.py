"""What lanes without a body fetch meanwhile: of a body that comes next, all that is in a GPU's main memory.

In a pass over a tree few lanes have a body at a time, and all others wait for them. What these lanes fetch is in the
first cache when it is read. One number of a vector is enough, since those of neighbouring instances fill the lines of
all of it; of a matrix two are.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import ALL, LEANER
from warpmuscle.kernels.structs import (
    Contribution,
    Crossing,
    CurveRow,
    Lever,
    ModelRef,
    MuscleRow,
    PathSpan,
    RoutePoint,
    RouteSpan,
    RouteWrap,
    ScratchRef,
    Segment,
    SegmentEnds,
    StateRef,
    WrapRow,
    at,
    component,
    nonnegative,
)


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
asm volatile("" :: "f"(x));
#endif
"""
)
def fetched(x: float): ...  # a number that a GPU has to fetch, though nothing is done with it


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
asm volatile("" :: "r"(x));
#endif
"""
)
def fetched_integer(x: int): ...


@func
def matrix_fetched(a: wp.array[wp.mat33], i: int):
    """A matrix, of all neighbouring instances."""
    m = a[i]
    fetched(m[0, 0])
    fetched(m[1, 1])


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
asm volatile("prefetch.global.L1 [%0];" :: "l"(wp::address(a, i, j)));
#endif
"""
)
def number_ahead(a: wp.array2d[float], i: int, j: int): ...  # a GPU fetches it without waiting for it


ROW_AHEAD = """
#if defined(__CUDA_ARCH__)
const unsigned part = 32u * (threadIdx.x % 32u);
if (part < sizeof(*a.data))
    asm volatile("prefetch.global.L1 [%0];" :: "l"(reinterpret_cast<const char*>(wp::address(a, i, j)) + part));
#endif
"""


def row_ahead_of(struct: Any) -> Any:
    """The Warp function that lets a GPU fetch a row of structures, of which each lane of a warp asks for a part."""

    @wp.func_native(snippet=ROW_AHEAD)
    def row_ahead(a: wp.array2d[struct], i: int, j: int): ...

    return row_ahead


muscle_row_ahead, curve_row_ahead = row_ahead_of(MuscleRow), row_ahead_of(CurveRow)

RANGE_AHEAD = """
#if defined(__CUDA_ARCH__)
const size_t start = size_t(first) * sizeof(*a.data) / 32u * 32u + 32u * (threadIdx.x % 32u);
if (start < size_t(end) * sizeof(*a.data))
    asm volatile("prefetch.global.L1 [%0];" :: "l"(reinterpret_cast<const char*>({data}) + start));
#endif
"""


def range_ahead_of(struct: Any) -> Any:
    """The Warp function (list, first, end) that lets a GPU fetch part of a list, each lane of a warp some of it.

    Lanes whose parts differ fetch only some of theirs.
    """

    @wp.func_native(snippet=RANGE_AHEAD.format(data="a.data"))
    def range_ahead(a: wp.array[struct], first: int, end: int): ...

    return range_ahead


def range_in_row_ahead_of(struct: Any) -> Any:
    """The same (table, instance, first, end) of an instance's row of a table."""

    @wp.func_native(snippet=RANGE_AHEAD.format(data="wp::address(a, i, 0)"))
    def range_in_row_ahead(a: wp.array2d[struct], i: int, first: int, end: int): ...

    @func
    def range_ahead(a: wp.array2d[struct], instance: int, first: int, end: int):
        range_in_row_ahead(a, nonnegative(wp.min(instance, a.shape[0] - 1)), first, end)

    return range_ahead


segments_ahead, ends_ahead = range_ahead_of(Segment), range_in_row_ahead_of(SegmentEnds)
contributions_ahead, crossings_ahead = range_ahead_of(Contribution), range_ahead_of(Crossing)
points_ahead, places_ahead = range_ahead_of(RoutePoint), range_in_row_ahead_of(wp.vec3)
wraps_ahead, wrap_rows_ahead = range_ahead_of(RouteWrap), range_in_row_ahead_of(WrapRow)
levers_ahead = range_ahead_of(Lever)


@func
def segments_of_path_ahead(instance: int, span: PathSpan, model: ModelRef):
    """What is known of the segments of a path."""
    segments_ahead(model.paths.segment, span.first_segment, span.end_segment)
    ends_ahead(model.paths.ends, instance, span.first_segment, span.end_segment)


@func
def route_ahead(instance: int, muscle: int, span: RouteSpan, model: ModelRef):
    """What is known of a route."""
    points_ahead(model.routes.point, span.first_point, span.end_point)
    places_ahead(model.routes.place, instance, span.first_point, span.end_point)
    levers_ahead(model.routes.lever, span.first_lever, span.end_lever)
    own = model.paths.span[muscle]
    crossings_ahead(model.paths.of_muscle, own.first_crossing, own.end_crossing)
    if span.end_wrap > span.first_wrap:
        wraps_ahead(model.routes.wrap, span.first_wrap, span.end_wrap)
        wrap_rows_ahead(model.routes.wrap_row, instance, span.first_wrap, span.end_wrap)


@func
def no_route_ahead(instance: int, muscle: int, span: RouteSpan, model: ModelRef):
    """Nothing of it."""


def route_ahead_of() -> Any:
    """The one of both that is compiled in."""
    return route_ahead if PATHS_AHEAD else no_route_ahead


@cache
def muscle_ahead_of(shaped: bool) -> Any:
    """The Warp function that asks for what a muscle needs after its path, which takes long: its numbers and its state.

    Args:
        shaped: whether muscles have curves of their own.
    """

    @func
    def muscle_ahead(instance: int, m: int, model: ModelRef, state: StateRef):
        rows = model.muscles.row
        muscle_row_ahead(rows, nonnegative(wp.min(instance, rows.shape[0] - 1)), m)
        if wp.static(shaped):
            curve_row_ahead(model.muscles.shape, nonnegative(wp.min(instance, model.muscles.shape.shape[0] - 1)), m)
        number_ahead(state.muscles.activation, instance, m)
        number_ahead(state.muscles.fibre_length, instance, m)
        number_ahead(state.muscles.previous_fibre_length, instance, m)
        number_ahead(state.muscles.force, instance, m)

    return muscle_ahead


@func
def later_body(level: int, lane: int, model: ModelRef) -> int:
    """The body of the next level that a lane without one of this level may look at; 0: none."""
    later = model.level_start[level] + lane
    if level + 1 == model.level_count or later < model.level_start[level + 1] or later >= model.level_start[level + 2]:
        return 0
    return later


PATHS_AHEAD = True  # whether a GPU fetches early what is known of a path


class LookAhead(NamedTuple):
    """Warp functions (instance, body, model, work) that fetch what a pass reads of a body besides others' results."""

    place: Any  # `kinematics.place_body`
    reduce: Any  # `followed_reduction.reduce_followed_of`
    accelerate: Any  # `followed.accelerate_followed_of`


@cache
def look_ahead_of(main: int) -> LookAhead:
    """The functions where so much is in main memory, see `scratch.NEAR`."""
    leaner, whole = main >= LEANER, main >= ALL

    @func
    def coordinate(body: int, model: ModelRef, work: ScratchRef):
        fetched_integer(model.skeleton.plan[body].parent)
        fetched(component(work.coordinate_turning, body, 0))
        fetched(component(work.coordinate_moving, body, 0))
        fetched(component(work.coordinate_drift, body, 0))

    @func
    def place(instance: int, body: int, model: ModelRef, work: ScratchRef):
        coordinate(body, model, work)
        fetched(component(work.coordinate_state, body, 0))
        if wp.static(leaner):
            fetched(work.turned[body][0])
            fetched(component(work.anchor, body, 0))
            fetched(component(work.rate, body, 0))
            fetched(component(work.gain, body, 0))
            fetched(component(work.parent_rate, body, 0))
            fetched(component(work.parent_gain, body, 0))
        if wp.static(whole):
            fetched(component(work.coordinate_turning_drift, body, 0))

    @func
    def reduce(instance: int, body: int, model: ModelRef, work: ScratchRef):
        coordinate(body, model, work)
        fetched_integer(model.couplings.joint[body].row)
        fetched_integer(model.couplings.entry_start[body])
        fetched(at(model.skeleton.row, instance, body).axis_a[0])
        fetched(component(work.bias_force, body, 0))
        if wp.static(leaner):
            fetched(component(work.bias_moment, body, 0))
            fetched(work.block_a[body][0])
            fetched(work.block_c[body][0])
            matrix_fetched(work.block_b, body)
        if wp.static(whole):
            parent = nonnegative(model.skeleton.plan[body].parent)
            fetched(component(work.position, parent, 0))
            fetched(component(work.angular_velocity, parent, 0))
            fetched(component(work.position, body, 0))
            fetched(component(work.bias, body, 0))
            fetched(component(work.torque, body, 0))
            fetched(work.stiffness[body][0])
            matrix_fetched(work.rotation, body)

    @func
    def accelerate(instance: int, body: int, model: ModelRef, work: ScratchRef):
        coordinate(body, model, work)
        fetched_integer(model.couplings.joint[body].row)
        matrix_fetched(work.factor_a, body)
        if wp.static(whole):
            fetched(at(model.skeleton.row, instance, body).axis_a[0])
            fetched(component(work.position, body, 0))
            fetched(component(work.bias, body, 0))
            matrix_fetched(work.rotation, body)

    return LookAhead(place, reduce, accelerate)
