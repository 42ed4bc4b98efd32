"""What the types of a scene cannot say about its ground, and contacts of the bodies with it and with each other."""

from __future__ import annotations

from collections.abc import Sequence

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Box, Character, ContactMaterial, Ground
from warpmuscle.scene.validation.checks import Checks, known
from warpmuscle.scene.validation.terrain import check_terrain
from warpmuscle.scene.validation.treadmill import check_treadmill

POINTS = ("spring", "soft_constraint")  # laws by which all shapes touch the ground, at points


def check_ground(checks: Checks) -> None:
    """Check the plane, its law of contact, and what the shapes of bodies are made of.

    Raises:
        SceneError: no normal or one that does not point upwards, a number out of its range, or a shape or material that
            the law does not know.
    """
    ground = checks.checked.ground
    checks.not_zero("ground.normal", ground.normal, "normal")
    upwards = checks.start(ground.normal[1])
    if not upwards > 0.0 and checks.start(checks.checked.gravity) > 0.0:
        raise SceneError(
            f"must point upwards, out of the ground: y must be greater than 0, is {upwards:g}", "ground.normal"
        )
    points = ground.law in POINTS
    check_terrain(checks)
    check_treadmill(checks)
    _soft_constraint(ground, checks)
    _material("ground.material", ground.material, points, checks)
    for name, body in checks.checked.character.bodies.items():
        for index, shape in enumerate(body.shapes):
            key = f"character.bodies.{name}.shapes.{index}"
            if not isinstance(shape, Box):
                _material(f"{key}.material", shape.material, points, checks)
            elif not points:
                raise SceneError("a box has no Hunt-Crossley contact; give spheres or capsules", key)


def _soft_constraint(ground: Ground, checks: Checks) -> None:
    """What makes contacts constraints is within its bounds, and given to a law that knows it."""
    names = ("restitution", "softness", "penalty")
    if ground.law != "soft_constraint":
        usual = Ground()
        for name in names:
            if getattr(ground, name) != getattr(usual, name):
                raise SceneError('only the law "soft_constraint" uses this; leave it out', f"ground.{name}")


def _material(key: str, material: ContactMaterial | None, points: bool, checks: Checks) -> None:
    """A material is one of Hunt-Crossley contact, and its numbers make forces."""
    if material is None:
        return
    if points:
        raise SceneError("only Hunt-Crossley contact has materials; set `ground.law`, or leave this out", key)


def check_body_contact(checks: Checks) -> None:
    """Check which bodies push each other, and how.

    Raises:
        SceneError: a number out of its range, or a pair that cannot touch.
    """
    scene = checks.checked
    contact = scene.body_contact
    if contact is None:
        return
    check_pairs(contact.pairs, scene.character, "body_contact.pairs")
    joined = {frozenset((joint.parent, joint.child)) for joint in scene.character.joints.values()}
    for index, pair in enumerate(contact.pairs):
        if frozenset(pair) in joined:
            raise SceneError(
                f"a joint joins {pair[0]!r} and {pair[1]!r}: its limits hold them apart", f"body_contact.pairs.{index}"
            )


def check_pairs(pairs: Sequence[tuple[str, str]], character: Character, key: str) -> None:
    """SceneError unless every pair is two bodies with shapes, and none is named twice."""
    seen = set()
    for index, pair in enumerate(pairs):
        place = f"{key}.{index}"
        for number, body in enumerate(pair):
            known(body, character.bodies, "body", f"{place}.{number}")
            if not character.bodies[body].shapes:
                raise SceneError(f"body {body!r} has no shape that could collide", key=f"{place}.{number}")
        if pair[0] == pair[1]:
            raise SceneError(f"a pair takes two bodies, got {pair[0]!r} twice", key=place)
        if frozenset(pair) in seen:
            raise SceneError(f"the pair {pair[0]!r} and {pair[1]!r} is there twice", key=place)
        seen.add(frozenset(pair))
