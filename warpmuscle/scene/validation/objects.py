"""What the types of a scene cannot say about objects beside the character."""

from __future__ import annotations

import itertools

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.scene.objects.part import AnyObject, BoxObject, Held, Hinge
from warpmuscle.scene.objects.shape import rounded
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.checks import Checks, known


def check_objects(checks: Checks) -> None:
    """Check sizes and masses of objects, which bodies touch them, and which hold them.

    Raises:
        SceneError: the first thing wrong, with its key, such as `objects.ball.radius`.
    """
    objects = checks.checked.objects
    check_size("solids", len(objects), lambda text: SceneError(text, "objects"))
    for name, solid in objects.items():
        key = f"objects.{name}"
        if "\0" in name or "." in name or name != name.encode(errors="replace").decode():
            raise SceneError(f"{name!r} has a character that no name of an object can have", key="objects")
        _check_solid(key, solid, checks)
        _check_bodies(key, solid, checks)
        _check_touched(key, name, solid, checks)
        if solid.held is not None:
            _check_held(f"{key}.held", solid, solid.held, checks)
        if solid.hinge is not None:
            _check_hinge(f"{key}.hinge", solid, solid.hinge, checks)


def object_warnings(scene: Scene) -> list[SceneError]:
    """Objects that touch nothing where that is probably a mistake: errors that are not raised, see `doubts_of`."""
    found: list[SceneError] = []
    if not any(solid.held is None for solid in scene.objects.values()):
        return found
    objects = {name: solid for name, solid in at_start(scene).objects.items() if solid.held is None}
    if not any(body.shapes for body in scene.character.bodies.values()):
        said = "no body has shapes, so that all pass through objects; give those shapes that are to touch one"
        found.append(SceneError(said, f"objects.{next(iter(objects))}"))
    for (name, one), (other_name, other) in itertools.combinations(objects.items(), 2):
        strange = name not in other.touches and other_name not in one.touches
        if strange and not (one.fixed and other.fixed) and _one_above_the_other(one, other):
            said = f"{name!r} and {other_name!r} lie one above the other and pass through each other"
            found.append(SceneError(f"{said}: name one in the other's touches", f"objects.{name}.touches"))
    return found


def _one_above_the_other(one: AnyObject, other: AnyObject) -> bool:
    """Whether the middle of one of two objects starts over or below the other one."""
    apart = np.abs(plain_vector(one.position) - plain_vector(other.position))
    return any(bool(np.all(apart[[0, 2]] <= _extent(solid)[[0, 2]])) for solid in (one, other))


def _extent(solid: AnyObject) -> Floats:
    """How far an object goes from its middle along each axis of the world, m."""
    shape = rounded(solid)
    turn = plain_vector(solid.orientation)
    turned = [np.abs(rotate(turn / np.linalg.norm(turn), edge)) for edge in np.diag(shape.half[0])]
    extent: Floats = np.sum(turned, axis=0) + shape.radius[0]
    return extent


def _check_solid(key: str, solid: AnyObject, checks: Checks) -> None:
    """It has an orientation, and speeds only where it can move."""
    checks.not_zero(f"{key}.orientation", solid.orientation, "quaternion")
    if solid.fixed and any(checks.interval(v) != (0.0, 0.0) for v in (*solid.velocity, *solid.angular_velocity)):
        raise SceneError("a fixed object does not move; leave out its velocities", f"{key}.fixed")


def _check_bodies(key: str, solid: AnyObject, checks: Checks) -> None:
    """Bodies that touch it are there, once each, and have shapes."""
    bodies = checks.checked.character.bodies
    for number, body in enumerate(solid.bodies):
        place = f"{key}.bodies.{number}"
        known(body, bodies, "body", place)
        if not bodies[body].shapes:
            raise SceneError(f"body {body!r} has no shape that could touch it", place)
        if body in solid.bodies[:number]:
            raise SceneError(f"{body!r} is there twice", place)


def _check_touched(key: str, name: str, solid: AnyObject, checks: Checks) -> None:
    """Other objects that it touches are there, once each."""
    objects = checks.checked.objects
    for number, other in enumerate(solid.touches):
        place = f"{key}.touches.{number}"
        known(other, objects, "object", place)
        if other == name:
            raise SceneError("an object does not touch itself", place)
        if other in solid.touches[:number]:
            raise SceneError(f"{other!r} is there twice", place)
        if solid.fixed and objects[other].fixed:
            raise SceneError(f"neither it nor {other!r} moves", place)


def _check_hinge(key: str, solid: AnyObject, hinge: Hinge, checks: Checks) -> None:
    """It has an axis, and nothing else holds the object."""
    if solid.fixed or solid.held is not None:
        other = "fixed" if solid.fixed else "held"
        raise SceneError(f"a {other} object cannot turn on a hinge; leave one of the two out", key)
    if any(checks.interval(v) != (0.0, 0.0) for v in solid.velocity):
        own = f"{key.removesuffix('.hinge')}.velocity"
        raise SceneError("a hinged object can only turn, by its angular_velocity; leave this out", own)
    checks.not_zero(f"{key}.axis", hinge.axis, "axis")


def _check_held(key: str, solid: AnyObject, held: Held, checks: Checks) -> None:
    """The body that holds it is there, and nothing else says where it is."""
    known(held.body, checks.checked.character.bodies, "body", f"{key}.body")
    if solid.fixed:
        raise SceneError("an object cannot be both fixed and held; leave one of the two out", key)
    for name in ("position", "orientation", "velocity", "angular_velocity"):
        if getattr(solid, name) != getattr(BoxObject(), name):
            own = f"{key.removesuffix('.held')}.{name}"
            raise SceneError("a held object starts where its body holds it; leave this out", own)
    checks.not_zero(f"{key}.orientation", held.orientation, "quaternion")
