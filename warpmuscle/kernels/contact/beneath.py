"""What is beneath a body on ground that is not flat: asked once a body, once a sphere, and once for each way of these.

Each answer spares most of the next questions. About a body, the ground may be too low to be touched, or level, so that
all of its spheres touch one plane. A sphere may be above all ground, or have no walls beside it.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.contact.terrain import (
    ABOUT,
    Footing,
    has_bounds,
    has_walls,
    highest_about,
    in_tile,
    nearest_footing,
)
from warpmuscle.kernels.contact.walls import Beneath, sphere_plane, ways_of
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at

SPANS = (0.2, 0.5, 0.8)  # m beside a cell, within which the lowest and the highest ground are known beforehand
BEYOND = wp.constant(3.0 * ABOUT)  # m beside a point that is deep in the ground, which is looked at; see `terrain`


@wp.struct
class About:
    """The ground where a body may touch it."""

    highest: float  # m over the ground's plane, along the normal of that, at most
    level: int  # 1: it is as high as that everywhere, so that no sphere of the body has to ask


@func
def bounded_about(instance: int, body: int, tallest: About, model: ModelRef, work: ScratchRef) -> About:
    """The ground about a body, from the bounds of its tile, which are those of cells about the joint.

    Args:
        tallest: what is returned where there are no bounds for so large a body.
    """
    place = at(model.contacts.terrain.place, instance, 0)
    grid = model.contacts.terrain.bounds[place.tile]
    reach = at(model.contacts.reach, instance, body)
    if grid.rows == 0 or reach > wp.static(SPANS[2]):
        return tallest
    row = wp.where(reach > wp.static(SPANS[1]), 2, wp.where(reach > wp.static(SPANS[0]), 1, 0))
    joint = work.position[body]
    own = in_tile(joint[0], joint[2], place)
    i = wp.clamp(int(wp.floor((own[0] - grid.x) * grid.per_metre)), 0, grid.columns - 1)
    j = wp.clamp(int(wp.floor((own[1] - grid.z) * grid.per_metre)), 0, grid.rows - 1)
    span = model.contacts.terrain.span[row, grid.first + j * grid.columns + i]
    about = About()
    about.highest = at(model.contacts.normal, instance, 0)[1] * (place.scale * span[1])
    known = wp.where(row == 2, wp.static(SPANS[2]), wp.where(row == 1, wp.static(SPANS[1]), wp.static(SPANS[0])))
    if span[0] == span[1] and reach + BEYOND <= known:
        about.level = 1
    return about


@cache
def about_body_of(terrain: int) -> Any:
    """The Warp function of the ground about a body.

    Args:
        terrain: what is compiled in, see `terrain.py`.
    """
    bounds = has_bounds(terrain)

    @wp.func
    def about_body(instance: int, body: int, height: float, model: ModelRef, work: ScratchRef) -> About:
        about = About()
        about.highest = highest_about(instance, body, model, work)
        if wp.static(bounds):  # noqa: SIM102, with `and` it would be compiled in all the same
            if height <= at(model.contacts.reach, instance, body) + about.highest:
                about = bounded_about(instance, body, about, model, work)
        return about

    return about_body


@cache
def beneath_sphere_of(terrain: int) -> Any:
    """The Warp function of what is beneath a sphere of a body: in how many ways it may touch, and how that rises."""
    walls, bounds = has_walls(terrain), has_bounds(terrain)

    @wp.func
    def beneath_sphere(
        instance: int, body: int, about: About, plane: Footing, up: wp.vec3, place: wp.vec3, radius: float,
        margin: float, model: ModelRef, work: ScratchRef,
    ) -> Beneath:  # fmt: skip
        """Args: plane: of the ground, without what rises over it. up, place: its normal, the middle, m; body axes."""
        beneath = Beneath()
        if wp.static(bounds):  # noqa: SIM102, with `and` it would be compiled in all the same
            if about.level == 1:
                beneath.ways = 1
                return beneath
        if radius - plane.height - wp.dot(up, place) + about.highest > -margin:
            beneath.ways = 1
            if wp.static(walls):
                arm = work.rotation[body] * place
                point = work.position[body] + arm
                return ways_of(instance, plane.normal, plane.height, arm, point, radius, margin, model)
        return beneath

    return beneath_sphere


@cache
def plane_of_way_of(terrain: int) -> Any:
    """The Warp function of the plane that a sphere touches in a way, see `walls.sphere_plane`."""
    walls, bounds = has_walls(terrain), has_bounds(terrain)

    @wp.func
    def plane_of_way(
        instance: int, body: int, way: int, about: About, beneath: Beneath, plane: Footing, place: wp.vec3,
        radius: float, margin: float, model: ModelRef, work: ScratchRef,
    ) -> Footing:  # fmt: skip
        if wp.static(bounds):  # noqa: SIM102, with `and` it would be compiled in all the same
            if about.level == 1:
                below = Footing()
                below.normal = plane.normal
                below.height = plane.height - about.highest
                return below
        arm = work.rotation[body] * place
        point = work.position[body] + arm
        if wp.static(walls):
            return sphere_plane(instance, way, beneath, plane.normal, plane.height, arm, point, radius, margin, model)
        return nearest_footing(instance, plane.normal, plane.height, arm, point, radius, model)

    return plane_of_way
