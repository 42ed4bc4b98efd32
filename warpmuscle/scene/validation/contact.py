"""What the types of a scene cannot say about its ground and the bodies' contacts with it."""

from __future__ import annotations

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Box, ContactMaterial
from warpmuscle.scene.validation.checks import Checks


def check_ground(checks: Checks) -> None:
    """Check the plane, its law of contact, and what the shapes of bodies are made of.

    Raises:
        SceneError: no normal, a number out of its range, or a shape or material that the law does not know.
    """
    ground = checks.checked.ground
    checks.not_zero("ground.normal", ground.normal, "normal")
    checks.not_negative("ground", ground, "stiffness", "damping", "tangential_damping", "friction")
    spring = ground.law == "spring"
    _material("ground.material", ground.material, spring, checks)
    for name, body in checks.checked.character.bodies.items():
        for index, shape in enumerate(body.shapes):
            key = f"character.bodies.{name}.shapes.{index}"
            if not isinstance(shape, Box):
                _material(f"{key}.material", shape.material, spring, checks)
            elif not spring:
                raise SceneError("a box has no Hunt-Crossley contact; give spheres or capsules", key)


def _material(key: str, material: ContactMaterial | None, spring: bool, checks: Checks) -> None:
    """A material is one of Hunt-Crossley contact, and its numbers make forces."""
    if material is None:
        return
    if spring:
        raise SceneError("only Hunt-Crossley contact knows materials; give `ground.law`, or leave it out", key)
    checks.not_negative(key, material, "stiffness", "dissipation")
    checks.not_negative(key, material, "static_friction", "dynamic_friction", "viscous_friction")
    checks.positive(key, material, "transition_velocity", "hertz_smoothing", "hunt_crossley_smoothing")
    checks.positive(key, material, "constant_force")
