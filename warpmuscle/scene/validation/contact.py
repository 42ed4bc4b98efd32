"""What the types of a scene cannot say about its ground and the bodies' contacts with it."""

from __future__ import annotations

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Box, ContactMaterial, Ground
from warpmuscle.scene.validation.checks import Checks

POINTS = ("spring", "soft_constraint")  # laws by which all shapes touch the ground, at points


def check_ground(checks: Checks) -> None:
    """Check the plane, its law of contact, and what the shapes of bodies are made of.

    Raises:
        SceneError: no normal, a number out of its range, or a shape or material that the law does not know.
    """
    ground = checks.checked.ground
    checks.not_zero("ground.normal", ground.normal, "normal")
    checks.not_negative("ground", ground, "stiffness", "damping", "tangential_damping", "friction")
    points = ground.law in POINTS
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
                raise SceneError('only the law "soft_constraint" asks for it; leave it out', f"ground.{name}")
    checks.fraction("ground.restitution", ground.restitution)
    checks.fraction("ground.penalty", ground.penalty)
    checks.positive("ground", ground, "softness")


def _material(key: str, material: ContactMaterial | None, points: bool, checks: Checks) -> None:
    """A material is one of Hunt-Crossley contact, and its numbers make forces."""
    if material is None:
        return
    if points:
        raise SceneError("only Hunt-Crossley contact knows materials; give `ground.law`, or leave it out", key)
    checks.not_negative(key, material, "stiffness", "dissipation")
    checks.not_negative(key, material, "static_friction", "dynamic_friction", "viscous_friction")
    checks.positive(key, material, "transition_velocity", "hertz_smoothing", "hunt_crossley_smoothing")
    checks.positive(key, material, "constant_force")
