"""What the fit of coordinates to markers is told, and what it works on.

A body is a chain of elements, each a turn about an axis or a shift along it, as a function of one coordinate says; the
elements of a joint stand one behind the other, and each frame of the recording is a problem of its own.
"""

import warp as wp

from warpmuscle.kernels.structs import CubicPiece


@wp.struct
class FitElement:
    """A turn about an axis, or a shift along it."""

    parent: int  # element that carries it; -1: the ground
    coordinate: int  # -1: it does not move
    turns: int  # 1: a turn; 0: a shift
    first_piece: int  # of its function of the coordinate
    end_piece: int
    axis: wp.vec3  # in the parent's axes
    offset: wp.vec3  # m, of its origin from that of its parent


@wp.struct
class FitMarker:
    """Where a marker is in the model."""

    element: int  # that carries it; -1: the ground
    point: wp.vec3  # m, from the element's origin, in its axes


@wp.struct
class FitCoordinate:
    """What a coordinate may be, and what it should be besides."""

    low: float
    high: float
    weight: float  # of its squared distance from its target, rad^2 or m^2, beside the mean of the markers' squares
    turns: int  # 1: some element turns with it, so that its steps are bounded


@wp.struct
class FitModel:
    """A model and its markers."""

    element: wp.array[FitElement]  # parents first
    piece: wp.array[CubicPiece]
    marker: wp.array[FitMarker]  # in the order of their elements
    coordinate: wp.array[FitCoordinate]


@wp.struct
class FitFrames:
    """Recorded frames, and what was found in them."""

    measured: wp.array2d[wp.vec3]  # (frames, markers) m
    weight: wp.array2d[float]  # (frames, markers), 0 where a marker was not seen
    target: wp.array2d[float]  # (frames or 1, coordinates)
    value: wp.array2d[float]  # (frames, coordinates): where to start, then the solution
    error: wp.array2d[wp.vec3]  # (frames, markers) m: measured less fitted
    iterations: wp.array[int]
    loose: wp.array2d[int]  # (frames, coordinates): 1 where markers do not tell the coordinate


@wp.struct
class FitScratch:
    """Numbers that one frame needs on the way; one row a frame that is at work."""

    orientation: wp.array2d[wp.quat]  # (rows, elements)
    origin: wp.array2d[wp.vec3]  # m
    turning: wp.array2d[wp.vec3]  # angular velocity by a unit rate of the element's coordinate
    moving: wp.array2d[wp.vec3]  # velocity, by the same, of what is at the ground's origin
    mass: wp.array2d[float]  # sum of the weights of all markers that an element carries
    first_moment: wp.array2d[wp.vec3]  # and their moments about the ground's origin
    second_moment: wp.array2d[wp.mat33]
    pull: wp.array2d[wp.vec3]  # sum of the weighted errors
    twist: wp.array2d[wp.vec3]  # and of their moments
    spread: wp.array2d[wp.mat33]  # and of the products p e' of places and weighted errors
    matrix: wp.array3d[float]  # (rows, coordinates, coordinates): J' W J, below the diagonal and on it
    slope: wp.array2d[float]  # (rows, coordinates): J' W e, then the step
    diagonal: wp.array2d[float]  # of J' W J
    last: wp.array2d[float]  # values before the step
    held: wp.array2d[int]  # 1 at a limit, beyond which the markers pull
