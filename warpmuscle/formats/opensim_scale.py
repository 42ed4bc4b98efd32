"""A model with bodies of another size, as OpenSim's ScaleTool makes one.

Each body has three factors, along its own axes. Frames, points, surfaces and markers on it move with them; shifts of a
joint change as its parent does, unless they are a coordinate themselves; masses go with the volume, or stay.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.osim.frames import GROUND, on_body, turned
from warpmuscle.formats.osim.records import Axis, Body, Contact, Joint, Model, Muscle, Point, Surface, Vec3

Factors = Mapping[str, Floats]  # (3,) along x, y and z of a body, by its name


def scaled_model(
    model: Model, factors: Factors, mass: float | None = None, keep_mass_distribution: bool = False
) -> Model:
    """The model with bodies of another size.

    Args:
        factors: of bodies that are not named: 1. mass: kg, of the whole body; by default as the factors make it.
        keep_mass_distribution: whether each body has the part of the whole mass that it had, rather than one that goes
            with its volume.

    Raises:
        SceneError: a factor is of no body, or not positive; a path is a polynomial of joints that change.
    """
    names = {body.name for body in model.bodies}
    for name, factor in factors.items():
        if name not in names:
            raise SceneError(f"a factor is of the body {name!r}, which the model does not have", file=model.file)
        if not (np.isfinite(factor).all() and np.min(factor) > 0.0):
            listed = " ".join(f"{x:g}" for x in factor)
            raise SceneError(f"body {name!r} is scaled by positive factors, not by {listed}", file=model.file)

    def of(frame: str) -> Floats:
        path = on_body(model, frame)[0]
        return np.asarray(factors.get(path.rpartition("/")[2], np.ones(3)), float) if path != GROUND else np.ones(3)

    found = replace(model)
    found.frames = {
        path: replace(frame, translation=frame.translation * of(path)) if frame.parent else frame
        for path, frame in model.frames.items()
    }
    found.bodies = [_body(body, of(body.path), not keep_mass_distribution) for body in model.bodies]
    total = sum(body.mass for body in found.bodies)
    if mass is not None and total > 0.0:
        part = mass / total
        found.bodies = [replace(one, mass=one.mass * part, inertia=one.inertia * part) for one in found.bodies]
    found.joints = [_joint(joint, of(joint.parent), of(joint.child)) for joint in model.joints]
    found.surfaces = {name: _surface(one, of(one.frame)) for name, one in model.surfaces.items()}
    found.muscles = [_muscle(muscle, of) for muscle in model.muscles]
    found.contacts = {name: _contact(one, of(one.frame)) for name, one in model.contacts.items()}
    found.markers = [replace(one, location=_times(one.location, of(one.frame))) for one in model.markers]
    found.meshes = [
        replace(one, translation=_times(one.translation, of(one.frame)), scale=_times(one.scale, of(one.frame)))
        for one in model.meshes
    ]
    return found


def _times(place: Vec3, factor: Floats) -> Vec3:
    x, y, z = np.asarray(place) * factor
    return float(x), float(y), float(z)


def _body(body: Body, s: Floats, with_volume: bool) -> Body:
    """Mass, centre and inertia of a body of another size."""
    volume = float(np.prod(s)) if with_volume else 1.0
    return replace(body, mass=body.mass * volume, center=body.center * s, inertia=_inertia(body, s) * volume)


def _inertia(body: Body, s: Floats) -> Floats:
    """Inertia of a body of the same mass: of a cylinder along the axis about which it is least, as OpenSim takes it."""
    if body.mass <= 0.0:
        return np.zeros((3, 3))
    if s[0] == s[1] == s[2]:
        return np.asarray(body.inertia * s[0] ** 2)
    moments = np.diagonal(body.inertia)
    axis = int(np.argmin(moments))
    other = 1 if axis == 0 else 0  # whose moment tells the length
    flat = moments[axis] * float(np.prod(np.delete(s, axis)))  # m r^2 / 2, and m r^2 / 4 of it about the others
    long = max(moments[other] - 0.5 * moments[axis], 0.0) * s[axis] ** 2
    found = body.inertia * np.outer(s, s)
    np.fill_diagonal(found, 0.5 * flat + long)
    found[axis, axis] = flat
    return np.asarray(found)


def _joint(joint: Joint, s: Floats, of_child: Floats) -> Joint:
    """Shifts that are functions of a coordinate change along their axes; a coordinate itself does not. Radii do, too.

    A rod changes as the child at its end does along y.
    """

    def shifted(axis: Axis) -> Axis:
        if axis.coordinates and axis.function.line is not None and axis.function.line[1] != 0.0:
            return axis
        along = np.asarray(axis.direction) / np.linalg.norm(axis.direction)
        factor = float(np.abs(along) @ s)
        terms = tuple((factor * a, powers) for a, powers in axis.terms)
        return replace(axis, function=axis.function.scaled(factor), terms=terms)

    ellipsoid = joint.ellipsoid
    if ellipsoid is not None:
        ellipsoid = replace(ellipsoid, radii=_times(ellipsoid.radii, s))
    rod = joint.rod
    if rod is not None:
        rod = replace(rod, length=rod.length * float(of_child[1]))
    return replace(joint, translations=tuple(map(shifted, joint.translations)), ellipsoid=ellipsoid, rod=rod)


def _surface(one: Surface, s: Floats) -> Surface:
    """Sizes along the surface's own axes."""
    axes = turned(one.rotation)
    along = np.linalg.norm(axes.T * s, axis=1)  # of the lengths of its x, y and z axes
    sizes = np.array(one.sizes)
    if one.kind == "WrapSphere":
        sizes = sizes * np.mean(s)
    elif one.kind == "WrapEllipsoid":
        sizes = sizes * along
    elif one.kind == "WrapCylinder":
        sizes = sizes * [0.5 * (along[0] + along[1]), along[2]]
    else:
        sizes = sizes * 0.5 * (along[0] + along[1])
    return replace(one, translation=_times(one.translation, s), sizes=tuple(float(x) for x in sizes))


def _contact(one: Contact, s: Floats) -> Contact:
    return replace(one, location=_times(one.location, s))


def _muscle(muscle: Muscle, of: Callable[[str], Floats]) -> Muscle:
    """Points of a path on their bodies."""

    def placed(point: Point) -> Point:
        s = of(point.frame)
        motion = tuple(
            (name, function.scaled(float(f))) for (name, function), f in zip(point.motion, s, strict=bool(point.motion))
        )
        return replace(point, location=_times(point.location, s), motion=motion)

    return replace(muscle, points=tuple(map(placed, muscle.points)))
