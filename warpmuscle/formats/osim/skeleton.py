"""Bodies, frames, joints and constraints of a model file as records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import GROUND, Frames
from warpmuscle.formats.osim.functions import IDENTITY, ZERO, Function, owned_function
from warpmuscle.formats.osim.joints.ellipsoids import RADII, X, Y, Z, read_ellipsoid
from warpmuscle.formats.osim.joints.rods import ROD, read_rod
from warpmuscle.formats.osim.joints.several import Terms, read_terms
from warpmuscle.formats.osim.properties import Properties, last_name
from warpmuscle.formats.osim.records import Axis, Body, Coordinate, Coupler, Joint, Model, Vec3

MOTIONS: dict[str, tuple[tuple[Vec3, ...], tuple[Vec3, ...]]] = {  # axes of turns and shifts, one a coordinate
    "WeldJoint": ((), ()),
    "PinJoint": ((Z,), ()),
    "SliderJoint": ((), (X,)),
    "UniversalJoint": ((X, Y), ()),
    "GimbalJoint": ((X, Y, Z), ()),
    "BallJoint": ((X, Y, Z), ()),
    "FreeJoint": ((X, Y, Z), (X, Y, Z)),
    "PlanarJoint": ((Z,), (X, Y)),
    "EllipsoidJoint": ((X, Y, Z), ()),  # and with the turns along an ellipsoid
    "ScapulothoracicJoint": ((X, Y, Z, Y), ()),
    ROD: ((X, Z, Y), ()),  # and with the first two along an arc
}
ONE_BY_ONE = 30500  # version of the file from which on moments of inertia stand together
INERTIAS = ("inertia_xx", "inertia_yy", "inertia_zz", "inertia_xy", "inertia_xz", "inertia_yz")


def read_bodies(bodies: Element | None, ground: Element | None, model: Model, frames: Frames, own: Properties) -> None:
    """Bodies with their frames, and the ground, which every model has."""
    frames.add(GROUND, ground if ground is not None else Element("Ground", model.file, model.line, "ground"))
    if ground is not None:
        ground.child("mass", "mass_center", *INERTIAS)  # which a ground that was a body has
    for element in bodies.objects() if bodies is not None else ():
        if element.tag != "Body":
            element.fail("is no body that is known here")
        if not element.name or "/" in element.name:
            element.fail("a body needs a name, without a slash")
        path = f"/bodyset/{element.name}"
        frames.add(path, element)
        center = np.array(own.vector(element, "mass_center"))
        mass = own.number(element, "mass", 0.0)
        model.bodies.append(Body(path, element.name, element.line, mass, center, _inertia(element, own, model.version)))
    check_size("bodies", len(model.bodies), lambda text: SceneError(text, file=model.file))


def _inertia(element: Element, own: Properties, version: int) -> Floats:
    """The inertia matrix, from six numbers together or, in old layouts alone, one by one; moments not given are 1."""
    together = own.find(element, "inertia")
    if together is not None and together.words():
        xx, yy, zz, xy, xz, yz = together.numbers(6)
    elif version < ONE_BY_ONE:
        usual = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
        xx, yy, zz, xy, xz, yz = (own.number(element, tag, one) for tag, one in zip(INERTIAS, usual, strict=True))
    else:
        xx, yy, zz, xy, xz, yz = (0.0,) * 6
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def read_joint(element: Element, model: Model, frames: Frames, own: Properties) -> Joint:
    """A joint of one of the known kinds; its frames are connected already.

    Raises:
        SceneError: of another kind, or without bodies; an axis that depends on an unknown coordinate.
    """
    path = f"/jointset/{element.name}"
    if element.tag not in (*MOTIONS, "CustomJoint"):
        element.fail(f"joints of this class are not known; {', '.join((*MOTIONS, 'CustomJoint'))} are")
    parent, child = (frames.socket(element, path, f"{end}_frame") for end in ("parent", "child"))
    holder = element.child("coordinates")
    coordinates = [_coordinate(one, path, own) for one in (holder.children if holder is not None else ())]
    if element.tag == "CustomJoint":
        rotations, translations = _custom_axes(element, own)
        _find_coordinates(element, path, coordinates, (*rotations, *translations))
    else:
        rotations, translations = _axes_of_class(element, path, coordinates)
    ellipsoid = read_ellipsoid(element, own) if element.tag in RADII else None
    element.child("reverse")  # the tree of bodies decides on that
    return Joint(
        element.tag, element.name, path, element.line, parent, child, tuple(coordinates), rotations, translations,
        ellipsoid, read_rod(element, own) if element.tag == ROD else None,
    )  # fmt: skip


def _find_coordinates(element: Element, path: str, coordinates: list[Coordinate], axes: tuple[Axis, ...]) -> None:
    """Make the coordinates of a joint's axes, where it lists none; else they must be among them."""
    known = {coordinate.name for coordinate in coordinates}
    given = ", ".join(known)
    for axis in axes:
        for name in axis.coordinates:
            if name not in known and given:
                message = f"axis in line {axis.line}: its coordinate {name!r} is none of the joint's: {given}"
                element.fail(message)
            if name not in known:
                coordinates.append(_made_coordinate(path, name, axis.line))
                known.add(name)


def _axes_of_class(
    element: Element, path: str, coordinates: list[Coordinate]
) -> tuple[tuple[Axis, ...], tuple[Axis, ...]]:
    """The axes of a joint of a class in `MOTIONS`, whose coordinates are made where it lists none."""
    turns, shifts = MOTIONS[element.tag]
    count = len(turns) + len(shifts)
    if 0 < len(coordinates) < count:
        element.fail(
            f"has {number_of(len(coordinates), 'coordinate')}, a joint of its class {count}; name all of them, or none"
        )
    for index in range(len(coordinates), count):
        coordinates.append(_made_coordinate(path, f"{element.name}_coord_{index}", element.line))
    if len(coordinates) > count:
        element.fail(f"has {number_of(len(coordinates), 'coordinate')}, a joint of its class {count}")
    names = [coordinate.name for coordinate in coordinates]
    axes = [Axis(d, (name,), IDENTITY, element.line) for d, name in zip((*turns, *shifts), names, strict=True)]
    return tuple(axes[: len(turns)]), tuple(axes[len(turns) :])


def _made_coordinate(path: str, name: str, line: int) -> Coordinate:
    return Coordinate(f"{path}/{name}", name, line, 0.0, 0.0, (-10.0, 10.0), False, None)


def _coordinate(element: Element, joint: str, own: Properties) -> Coordinate:
    """A coordinate with its start, range and what is prescribed."""
    element.used = True
    if element.tag != "Coordinate" or not element.name:
        element.fail("a joint has coordinates with names here")
    span = own.find(element, "range")
    low, high = span.numbers(2, infinite=True) if span is not None and span.words() else (-10.0, 10.0)
    given = own.find(element, "prescribed_function")
    function: Function | None = None
    if own.truth(element, "prescribed", False):
        if given is None or not given.children:
            element.fail("is prescribed, but has no prescribed function")
        function = owned_function(given)
    elif given is not None and given.children:
        given.children[0].used = True
    older, value = element.child("initial_value"), own.find(element, "default_value")
    value = older if value is None else value
    start = value.number() if value is not None and value.words() else 0.0
    speed = own.number(element, "default_speed_value", 0.0)
    element.child("motion_type", "is_free_to_satisfy_constraints")
    clamped = own.truth(element, "clamped", True)
    locked = own.truth(element, "locked", False)
    path = f"{joint}/{element.name}"
    return Coordinate(path, element.name, element.line, start, speed, (low, high), locked, function, clamped)


def _custom_axes(element: Element, own: Properties) -> tuple[tuple[Axis, ...], tuple[Axis, ...]]:
    """The axes of a joint's spatial transform; of those that are not given nothing moves."""
    transform = own.find(element, "SpatialTransform")
    if transform is None:
        element.fail("has no <SpatialTransform>")
    axes: dict[str, Axis] = {}
    for child in transform.children:
        if child.tag == "TransformAxis":
            axes[child.name] = _axis(child, own)
    rotations, translations = (
        tuple(axes[f"{kind}{k}"] for k in (1, 2, 3) if f"{kind}{k}" in axes) for kind in ("rotation", "translation")
    )
    if len(rotations) + len(translations) < len(axes):
        transform.fail("its axes are called rotation1 to rotation3 and translation1 to translation3")
    return rotations, translations


def _axis(element: Element, own: Properties) -> Axis:
    """An axis: its direction, its coordinate and the function of that, without which nothing moves.

    An empty `function` is the coordinate itself, as in OpenSim 4.6.
    """
    element.used = True
    named = own.find(element, "coordinates")
    names = tuple(last_name(word) for word in named.words()) if named is not None else ()
    if names in (("Unassigned",), ("unassigned",)):
        names = ()
    direction = own.vector(element, "axis", X)
    if not np.linalg.norm(direction) > 1e-9:
        element.fail("its axis has no length")
    if len(names) > 1:
        terms = _terms_of(element, names, "coordinates", "axis", "name")
        return Axis(direction, names, ZERO, element.line, terms)
    empty = IDENTITY if names and element.child("function") is not None else ZERO
    function = owned_function(element, "coordinates", "axis", "name") or empty
    if function.constant or not names:
        function, names = Function((function.at(0.0),)), ()
    return Axis(direction, names, function, element.line)


def read_constraint(element: Element, own: Properties) -> Coupler | None:
    """A coupler of two coordinates; None if it is not enforced.

    Raises:
        SceneError: a constraint of another class, or a function that is not known.
    """
    if not own.applied(element):
        for child in element.children:
            child.used = True
        return None
    if element.tag != "CoordinateCouplerConstraint":
        element.fail("a constraint of this class cannot be represented; set <isEnforced> to false to do without it")
    names = own.find(element, "independent_coordinate_names")
    independent = [last_name(word) for word in names.words()] if names is not None else []
    if not independent:
        element.fail("has no <independent_coordinate_names>")
    dependent = last_name(own.word(element, "dependent_coordinate_name"))
    if not dependent:
        element.fail("has no <dependent_coordinate_name>")
    holder = own.find(element, "coupled_coordinates_function")
    scale = own.number(element, "scale_factor", 1.0)
    if len(independent) > 1 and holder is not None:
        terms = tuple((scale * a, exponents) for a, exponents in _terms_of(holder, independent))
        return Coupler(element.name, element.line, dependent, independent[0], ZERO, False, tuple(independent), terms)
    function = owned_function(holder) if holder is not None else None
    if function is None:
        element.fail("has no <coupled_coordinates_function>")
    constant = any(one.tag == "Constant" for one in holder.all()) if holder is not None else False
    return Coupler(element.name, element.line, dependent, independent[0], function.scaled(scale), constant)


def _terms_of(element: Element, names: Sequence[str], *others: str) -> Terms:
    """The terms of the function of several coordinates that an element holds, itself or within `function`."""
    wrapper = element.child("function")
    held = wrapper.children if wrapper is not None else [one for one in element.children if one.tag not in others]
    if not held:
        element.fail(f"has no function of its {number_of(len(names), 'coordinate')}")
    return read_terms(held[-1], len(names))
