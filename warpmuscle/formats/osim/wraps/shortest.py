"""Paths that are the shortest ones over obstacles between their points (Scholz2015GeometryPath)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import Frames
from warpmuscle.formats.osim.properties import Properties, last_name
from warpmuscle.formats.osim.records import Model, PathWrap, Point, Surface, Vec3

TAG = "Scholz2015GeometryPath"
POINT, OBSTACLE = "Scholz2015GeometryPathPoint", "Scholz2015GeometryPathObstacle"
KINDS = {"ContactCylinder": "WrapCylinder", "ContactSphere": "WrapSphere"}
DRAWN = 4.0  # radii, the length that a cylinder without ends is drawn with
BESIDE = 2.0  # radii from the axis of a cylinder: the point that says on which side of it a path runs
MIXED = (
    f"its path is the shortest one over obstacles ({TAG}), and other muscles go round surfaces by a GeometryPath; here "
    "all of a model's paths go by one rule; it is left out, and pulls on nothing"
)
Route = tuple[tuple[Point, ...], tuple[PathWrap, ...]]


def read_shortest(
    element: Element, muscle: str, shapes: Mapping[str, Element], found: Model, frames: Frames, own: Properties
) -> Route | str:
    """Points and wraps of a path, whose obstacles become surfaces of the model; or why it cannot be had.

    Args:
        shapes: elements of the model's shapes of contact by name.
    """
    points: list[Point] = []
    surfaces: dict[str, Surface] = {}
    wraps: list[PathWrap] = []
    holder = element.child("path_elements")
    path = f"/forceset/{muscle}/path"
    members = holder.children if holder is not None else []
    for one in members:
        one.used = True
        if one.tag == POINT and (inner := one.child("PathPoint")) is not None:
            frame = frames.socket(inner, f"{path}/{one.name}/{inner.name}", "parent_frame")
            points.append(Point(one.name, one.line, frame, own.vector(inner, "location")))
        elif one.tag == OBSTACLE:
            made = _surface(one, f"{muscle}_{len(wraps) + 1}", shapes, frames, own)
            if isinstance(made, str):
                return made
            surfaces[made.name] = made
            wraps.append(PathWrap(made.name, one.line, "hybrid", (len(points), len(points) + 1)))
        else:
            one.fail(f"elements of this class are not known in a path; {POINT} and {OBSTACLE} are")
    if len(points) < 2 or members[0].tag != POINT or members[-1].tag != POINT:
        element.fail("begins and ends with a point")
    found.surfaces |= surfaces
    found.obstacles |= {last_name(one.word()) for one in element.all() if one.tag == "socket_contact_geometry"}
    return tuple(points), tuple(wraps)


def _surface(
    element: Element, name: str, shapes: Mapping[str, Element], frames: Frames, own: Properties
) -> Surface | str:
    """The surface of an obstacle, or why it cannot be had."""
    socket = element.child("socket_contact_geometry")
    shape = shapes.get(last_name(socket.word())) if socket is not None else None
    if shape is None:
        element.fail("names no shape of the ContactGeometrySet")
    hint = element.child("contact_hint")
    place = own.vector(element, "contact_hint") if hint is not None and "nan" not in hint.text.lower() else None
    if shape.tag not in KINDS:
        return (
            f"the shortest path over a {shape.tag} ({shape.name}) is not known, only that over spheres and cylinders; "
            "it is left out, and pulls on nothing"
        )
    radius = own.number(shape, "radius", 0.0)
    if not radius > 0.0:
        shape.fail(f"an obstacle needs a radius greater than 0, not {radius:g}")
    frame = frames.socket(shape, f"/contactgeometryset/{shape.name}", "frame")
    side: Vec3 | None = None
    sizes: tuple[float, ...] = (radius,)
    if shape.tag == "ContactCylinder":
        out = math.hypot(place[0], place[1]) if place is not None else 0.0
        if place is None or not 0.0 < out < math.inf:
            return (
                f"its obstacle in line {element.line} has no <contact_hint> off the axis of the cylinder, which says "
                "on which side of it the path runs; it is left out, and pulls on nothing"
            )
        side = (place[0] * BESIDE * radius / out, place[1] * BESIDE * radius / out, place[2])
        sizes = (radius, DRAWN * radius)
    return Surface(
        KINDS[shape.tag], name, element.line, frame, own.vector(shape, "orientation"), own.vector(shape, "location"),
        "all", sizes, side,
    )  # fmt: skip


def settle_mixed(found: Model) -> list[tuple[str, str, int]]:
    """Take muscles with such paths out of a model in which others go round surfaces; class, name and line of each."""
    shortest = [muscle for muscle in found.muscles if muscle.shortest and muscle.wraps]
    if not shortest or not any(muscle.wraps and not muscle.shortest for muscle in found.muscles):
        return []
    found.muscles = [muscle for muscle in found.muscles if muscle not in shortest]
    return [(muscle.kind, muscle.name, muscle.line) for muscle in shortest]
