"""Length, lengthening speed and moment arms of muscles whose paths are of several kinds."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.path.path import PathState, stretch_of
from warpmuscle.kernels.path.polynomial_path import polynomial_stretch
from warpmuscle.kernels.path.route import route_stretch_of
from warpmuscle.kernels.path.route_bends import RouteKind
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


class PathKind(NamedTuple):
    """What is compiled in besides paths of points that are fixed or come in smoothly."""

    routes: RouteKind | None = None  # paths that wrap, move, or whose points come in at once
    monomials: int = 0  # that polynomials have in common, see `polynomial_path.py`; 0: no path is a polynomial
    others: bool = True  # whether some paths are neither
    gathers: bool = False  # whether some segments of these act on a crossing by several joints
    groups: int = 0  # of joints that move as one for paths, see `coordinate_joint.put_groups`

    @property
    def wraps(self) -> bool:
        """Whether some paths wrap around surfaces."""
        return self.routes is not None and self.routes.wraps > 0


@cache
def any_stretch_of(
    kind: PathKind,
    pulleys: bool = True,
    conditions: bool = True,
    straight: bool = False,
    coordinate_joints: bool = False,
    followers: bool = False,
    wrench: bool = False,
) -> Any:
    """The Warp function of the length and speed of a path of any kind, see `path.stretch_of`."""
    grouped = kind.groups > 0
    others = stretch_of(pulleys, conditions, straight, coordinate_joints, followers, wrench, kind.gathers, grouped)
    some_others = kind.others
    routes, polynomials = kind.routes is not None, kind.monomials > 0
    if not routes and not polynomials:
        return others
    route_stretch = route_stretch_of(kind.routes or RouteKind(), coordinate_joints, followers, wrench)

    @wp.func(inline=True)
    def any_stretch(
        instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
    ) -> PathState:
        if wp.static(polynomials) and (
            model.routes.polynomial[muscle].end_term > model.routes.polynomial[muscle].first_term
        ):
            return polynomial_stretch(instance, muscle, model, state, work, arm)
        if wp.static(routes) and model.routes.span[muscle].end_point > model.routes.span[muscle].first_point:
            return route_stretch(instance, muscle, model, state, work, arm)
        if wp.static(some_others):
            return others(instance, muscle, model, state, work, arm)
        return PathState()

    return any_stretch
