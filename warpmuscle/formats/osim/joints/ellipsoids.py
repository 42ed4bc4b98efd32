"""Joints whose child slides on an ellipsoid, as rows of turns and constant shifts.

The child's z axis is the normal n of a sphere that is stretched into the ellipsoid, so that with its turns by q0 about
x and by q1 about the new y axis its place is

    p = (a sin q1, -b sin q0 cos q1, c cos q0 cos q1)
      = (a + b)/2 n(q0, q1) + (c - b)/2 n(-q0, q1) + (c - a)/2 n(q0, -q1),    n(s, t) = Rx(s) Ry(t) z.

So three levers along z, each in another frame, carry the child there, exactly: a row of turns that follow q0 and q1.
(Simbody, MobilizedBody::Ellipsoid; Seth et al. 2016, PLoS ONE 11(1) e0141028, for the scapula.)
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import Function
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import Axis, Ellipsoid, Joint, Vec3

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
RADII = {"EllipsoidJoint": "radii_x_y_z", "ScapulothoracicJoint": "thoracic_ellipsoid_radii_x_y_z"}
QUARTER = 0.5 * math.pi  # by which the scapula's ellipsoid is turned, so that abduction and elevation are positive

Row = Iterator[tuple[bool, Axis]]  # whether it turns, about or along what


def read_ellipsoid(element: Element, own: Properties) -> Ellipsoid:
    """The ellipsoid of a joint of one of the classes in `RADII`.

    Raises:
        SceneError: its radii are not given, or none that an ellipsoid has.
    """
    tag = RADII[element.tag]
    given = own.find(element, tag)
    if given is None or not given.words():
        element.fail(f"has no <{tag}>, the radii of its ellipsoid")
    a, b, c = given.numbers(3)
    if 0.0 in (a, b, c):
        given.fail(f"no radius of an ellipsoid is 0, not {a:g} {b:g} {c:g}")
    if element.tag != "ScapulothoracicJoint":
        return Ellipsoid((a, b, c))
    place = own.find(element, "scapula_winging_axis_origin")
    x, y = place.numbers(2) if place is not None and place.words() else (0.0, 0.0)
    return Ellipsoid((a, b, c), (x, y), own.number(element, "scapula_winging_axis_direction", 0.0))


def winging_axis(ellipsoid: Ellipsoid) -> Vec3:
    """The axis about which the scapula comes off the thorax: y, turned about z by the axis's direction."""
    return -math.sin(ellipsoid.direction), math.cos(ellipsoid.direction), 0.0


def ellipsoid_row(joint: Joint, ellipsoid: Ellipsoid) -> Row:
    """What moves in a joint with an ellipsoid, in order from its parent's frame to its child's."""
    names = [coordinate.name for coordinate in joint.coordinates]
    if joint.kind != "ScapulothoracicJoint":
        yield from _on_surface(names, ellipsoid.radii, joint.line)
        return
    a, b, c = ellipsoid.radii
    x, y = ellipsoid.origin
    yield True, _constant(Z, QUARTER, joint.line)
    yield from _on_surface(names, (b, a, c), joint.line)
    yield True, _constant(Z, -QUARTER, joint.line)
    yield False, _constant(X, x, joint.line)
    yield False, _constant(Y, y, joint.line)
    yield True, _turn(winging_axis(ellipsoid), names[3], 1.0, joint.line)
    yield False, _constant(X, -x, joint.line)
    yield False, _constant(Y, -y, joint.line)


def _on_surface(names: list[str], radii: Vec3, line: int) -> Row:
    """The levers of the head of this file, and a turn about the normal."""
    a, b, c = radii
    levers = ((-1.0, 1.0, 0.5 * (c - b)), (1.0, -1.0, 0.5 * (c - a)), (1.0, 1.0, 0.5 * (a + b)))
    first = second = 0.0  # how often the frame is turned by q0 and q1
    for about_x, about_y, length in levers:
        if length == 0.0:
            continue
        if about_x != first:
            if second != 0.0:
                yield True, _turn(Y, names[1], -second, line)
            yield True, _turn(X, names[0], about_x - first, line)
            first, second = about_x, 0.0
        if about_y != second:
            yield True, _turn(Y, names[1], about_y - second, line)
            second = about_y
        yield False, _constant(Z, length, line)
    yield True, _turn(Z, names[2], 1.0, line)


def _turn(axis: Vec3, coordinate: str, slope: float, line: int) -> Axis:
    return Axis(axis, (coordinate,), Function((0.0, slope)), line)


def _constant(axis: Vec3, value: float, line: int) -> Axis:
    return Axis(axis, (), Function((value,)), line)
