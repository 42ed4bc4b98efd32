"""How a route goes round its surfaces: what is known of it, and one segment round one surface."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.memory.register_rows import RowsOf, rows_in, rows_of
from warpmuscle.kernels.path.wrap_cylinder import cylinder_touch_of
from warpmuscle.kernels.path.wrap_ellipsoid import ellipsoid_touch_of
from warpmuscle.kernels.path.wrap_mujoco import mujoco_cylinder_touch, mujoco_sphere_touch
from warpmuscle.kernels.path.wrap_sphere import smooth_sphere_touch, sphere_touch
from warpmuscle.kernels.path.wrap_torus import torus_touch_of
from warpmuscle.kernels.path.wrap_touch import Touch
from warpmuscle.kernels.structs import RouteWrap

CYLINDER, SPHERE, ELLIPSOID, TORUS = 0, 1, 2, 3
WRAP_BIT = 24  # of a stop on the first wrap of a route, in `Lever.beyond`; the points come before
LEVER_BITS = 31  # of a stop, in `RoutePoint.levers`
NOWHERE = -1
FAR = 1.0e30  # m, longer than any way
ROUNDING = 1.0e-6  # m, by which detours may be wrong
MANY_LEVERS = 8  # from which on they are taken by their bits
MANY_WRAPS = 3  # from which on the rounds of a route take long


class RouteKind(NamedTuple):
    """What is compiled in for routes."""

    wraps: int = 0  # the most that one has
    levers: int = 0  # the same
    surfaces: tuple[int, ...] = ()  # CYLINDER ..., those that there are
    motions: int = 0  # the most that a point has
    conditions: bool = True  # whether some count only at times
    exact: bool = False  # whether routes around cylinders are the shortest ones, see `wrap_cylinder.py`
    smooth: bool = False  # whether no route jumps off cylinders, spheres and ellipsoids
    mujoco: bool = False  # whether each surface is between two points of its own, see `wrap_mujoco.py`; then exact
    branches: bool = False  # whether the ways to some points count more or less than others
    rows: bool = False  # whether some go over several surfaces between two of their points, see `route_rows.py`
    across: bool = False  # whether motions of points pull on segments between two bodies alone
    points: int = 0  # for how many of a route there is room, where some wrap
    near: bool = False  # whether a GPU has them and the bends in the shared memory of a block, see `near_rows_of`
    groups: bool = False  # whether some levers are groups of joints, see `coordinate_joint.put_groups`

    @property
    def places(self) -> int:
        """Points whose places a lane keeps, see `route_points.placed_of`; 0: it finds each where it is asked for."""
        return max(self.points, 1) if self.wraps > 0 and not self.rows else 0

    @property
    def as_opensim(self) -> bool:
        """Whether arcs are all OpenSim's, see `wrap_cylinder.py`."""
        return not self.smooth and not self.exact

    @property
    def in_rounds(self) -> bool:
        """Whether routes go round many surfaces, in rounds: a lane then keeps them in memory of its own.

        That has room in a GPU's first cache only where a kernel of their own finds them, see `MuscleKind.may_be_apart`.
        """
        return self.wraps >= MANY_WRAPS and not self.mujoco

    @property
    def bend_numbers(self) -> int:
        """Numbers of the bends; the places of points come behind them where these are near."""
        return 13 * max(self.wraps, 1)

    @property
    def numbers(self) -> int:
        """Numbers of bends and places."""
        return self.bend_numbers + 3 * self.places

    @property
    def places_start(self) -> int:
        """Where places are among the numbers that are near; -1: they are not near."""
        return self.bend_numbers if self.near else -1

    @property
    def many_levers(self) -> bool:
        """Whether a walk takes levers by their bits, and does not look at all of a route at each segment."""
        return self.levers >= MANY_LEVERS

    @property
    def keeps(self) -> bool:
        """Whether detours are measured between the places where a route first touched other surfaces, as in OpenSim.

        Only tori have several detours to choose from in most poses, so smooth routes past others are spared the cost.
        """
        return self.wraps > 1 and (self.as_opensim or (self.smooth and TORUS in self.surfaces))

    @property
    def slips(self) -> bool:
        """Whether speeds of those round several surfaces are OpenSim's, see `route_walk.py`."""
        return self.as_opensim and self.wraps > 1


@cache
def bends_of(count: int) -> Any:
    """The structure of how a route goes round its surfaces, with room for so many."""

    @wp.struct
    class Bends:
        first: wp.types.matrix(shape=(count, 3), dtype=float)  # m, where it reaches each, from the route's origin
        second: wp.types.matrix(shape=(count, 3), dtype=float)  # m, and leaves it
        arc: wp.types.vector(length=count, dtype=float)  # m, on each
        after: wp.types.vector(length=count, dtype=int)  # the stop before, NOWHERE if the route does not touch it
        kept: int  # a bit a surface that is measured from those of the first round:
        kept_first: wp.types.matrix(shape=(count, 3), dtype=float)
        kept_second: wp.types.matrix(shape=(count, 3), dtype=float)
        near: int  # see `RouteKind.near`

    return Bends


class BendRows(NamedTuple):
    """Warp functions on the fields of `bends_of`, by surface."""

    first: RowsOf
    second: RowsOf
    arc: RowsOf
    kept_first: RowsOf
    kept_second: RowsOf


@cache
def bend_rows_of(kind: RouteKind) -> BendRows:
    """Those for routes of a kind."""
    count, few = max(kind.wraps, 1), 0 if kind.in_rounds else kind.wraps
    starts = (0, 3 * count, 6 * count, 7 * count, 10 * count) if kind.near else (-1,) * len(BendRows._fields)
    fields = zip(BendRows._fields, starts, strict=True)
    return BendRows(*(rows_in(bends_of(count), field, count, max(few, 1), start) for field, start in fields))


@cache
def touch_of(surfaces: tuple[int, ...], smooth: bool = False, as_opensim: bool = False) -> Any:
    """The Warp function of how a segment from a to b, in a surface's axes, goes round it.

    Args:
        surfaces: the kinds that there are. smooth: see `RouteKind`. as_opensim: see `wrap_cylinder.py`.
    """
    cylinder_touch, ellipsoid_touch = cylinder_touch_of(smooth, as_opensim), ellipsoid_touch_of(smooth, as_opensim)
    torus_touch = torus_touch_of(as_opensim)
    round_sphere = smooth_sphere_touch if smooth else sphere_touch
    cylinders, spheres, ellipsoids, tori = (kind in surfaces for kind in (CYLINDER, SPHERE, ELLIPSOID, TORUS))

    @wp.func
    def touch(a: wp.vec3, b: wp.vec3, wrap: RouteWrap, size: wp.vec3, where: int) -> Touch:
        result = Touch()
        if wp.static(cylinders) and wrap.kind == CYLINDER:
            result = cylinder_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        if wp.static(spheres) and wrap.kind == SPHERE:
            result = round_sphere(a, b, size[0], wrap.axis, wrap.side)
        if wp.static(ellipsoids) and wrap.kind == ELLIPSOID:
            result = ellipsoid_touch(a, b, size, wrap.axis, wrap.side, wrap.method)
        if wp.static(tori) and wrap.kind == TORUS:
            result = torus_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        return result

    return touch


@cache
def mujoco_touch_of(surfaces: tuple[int, ...]) -> Any:
    """The same of MuJoCo's surfaces, of which `wrap.side` says whether they have a side point."""
    cylinders, spheres = (kind in surfaces for kind in (CYLINDER, SPHERE))

    @wp.func
    def touch(a: wp.vec3, b: wp.vec3, wrap: RouteWrap, size: wp.vec3, point: wp.vec3) -> Touch:
        result = Touch()
        if wp.static(cylinders) and wrap.kind == CYLINDER:
            result = mujoco_cylinder_touch(a, b, size[0], wrap.side, point)
        if wp.static(spheres) and wrap.kind == SPHERE:
            result = mujoco_sphere_touch(a, b, size[0], wrap.side, point)
        return result

    return touch


@cache
def bend_after_of(count: int) -> Any:
    """The Warp function of the wrap whose surface a route reaches behind a stop, NOWHERE if there is none."""
    stops = wp.types.vector(length=count, dtype=int)
    number = rows_of(count).number

    @wp.func
    def bend_after(stop: int, wraps: int, after: stops) -> int:
        found = int(NOWHERE)
        for w in range(count):
            if w < wraps and found == NOWHERE and number(after, w) == stop:
                found = w
        return found

    return bend_after
