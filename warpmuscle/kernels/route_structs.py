"""Device structures of routes: paths whose points move, come in all at once, or that wrap around surfaces."""

import warp as wp

from warpmuscle.kernels.body_structs import CubicPiece


@wp.struct
class RouteSpan:
    """Where the route of a muscle stands in the lists of all routes; no points: its path is none."""

    first_point: int
    end_point: int  # the one after its last
    first_wrap: int
    end_wrap: int
    first_lever: int
    end_lever: int
    origin: int  # the body from whose joint all of it is measured


@wp.struct
class RoutePoint:
    """A point of a route."""

    body: int
    condition: int  # -1: it always counts
    fixed: int  # 1: the segment from the point before is part of the fixed length
    levers: int  # a bit a lever, of the first LEVER_BITS of the route, that it is beyond
    first_motion: int
    end_motion: int


@wp.struct
class RouteMotion:
    """A way that a point moves with a joint's coordinate."""

    joint: int
    crossing: int
    first_piece: int  # of the function of the coordinate
    end_piece: int
    low: float  # coordinate below which the point stays where it is, and above which; its rate may go on
    high: float


@wp.struct
class RouteWrap:
    """A surface that a route wraps around; its points are counted from its first."""

    body: int
    kind: int  # CYLINDER ...
    axis: int  # of the half that the route must stay on
    side: int  # 1 or -1; 0: there is none
    first: int  # point of the route between which it wraps
    last: int
    surface: int  # number of the surface
    method: int  # HYBRID, MIDPOINT or AXIAL
    levers: int  # the same of the surface


@wp.struct
class WrapRow:
    """The place and size of a surface."""

    rotation: wp.mat33  # from its axes to those of its body
    position: wp.vec3  # m, of its centre, from the joint of its body
    size: wp.vec3  # m: radius and length of a cylinder, radius, radii, inner and outer radius


@wp.struct
class Lever:
    """A joint that a route acts on, or one that moves with it."""

    crossing: int
    joint: int
    beyond: int  # a bit a stop that is beyond the joint: points first, then wraps from WRAP_BIT on
    group: int  # of joints that moves as one, the joint being its first; -1: the joint by itself
    last: int  # 1: the one behind it is of another crossing, or has another kind of joint; or there is none


@wp.struct
class PolynomialSpan:
    """Where the polynomial of a muscle stands in the lists of all; no terms: its path is none."""

    first_variable: int
    end_variable: int  # the one after its last
    first_term: int
    end_term: int


@wp.struct
class Variable:
    """A coordinate that a polynomial depends on."""

    joint: int
    axis: int  # which of the joint's coordinates
    crossing: int
    first: int  # 1: no variable before belongs to the crossing
    first_term: int  # of the derivative by it
    end_term: int


@wp.struct
class Monomial:
    """A product of powers of coordinates: one of lower degree, times a coordinate."""

    before: int
    joint: int
    axis: int


@wp.struct
class PolynomialTerm:
    """What a term of a polynomial, or of a derivative, multiplies."""

    coefficient: float  # m
    monomial: int


@wp.struct
class Routes:
    """Routes and polynomials of all muscles, one behind the other; only kernels with some compiled in read them."""

    order: wp.array[int]  # (muscles,) in which lanes take them, so that those that wrap are taken at the same time
    span: wp.array[RouteSpan]  # (muscles,)
    point: wp.array[RoutePoint]  # (points,)
    share: wp.array2d[float]  # (rows, points) what the way to each counts, where paths have branches
    place: wp.array2d[wp.vec3]  # (rows, points) m, from the joint of the point's body
    wrap: wp.array[RouteWrap]  # (wraps,)
    wrap_row: wp.array2d[WrapRow]  # (rows, wraps)
    side_point: wp.array2d[wp.vec3]  # (rows, wraps) m, surface's axes; only MuJoCo's wrapping reads it
    lever: wp.array[Lever]  # (levers,)
    motion: wp.array[RouteMotion]  # (motions,)
    motion_axis: wp.array2d[wp.vec3]  # (rows, motions) unit vectors, axes of the point's body
    piece: wp.array2d[CubicPiece]  # (rows, pieces)
    polynomial: wp.array[PolynomialSpan]  # (muscles,)
    variable: wp.array[Variable]  # (variables,)
    term: wp.array2d[PolynomialTerm]  # (rows, terms)
    monomial: wp.array[Monomial]  # (monomials,) by degree, of all polynomials; the first is 1
    degree_start: wp.array[int]  # (degrees + 1,) of the monomials
