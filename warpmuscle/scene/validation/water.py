"""What the types of a scene cannot say about water."""

from __future__ import annotations

from warpmuscle.core.errors import SceneError
from warpmuscle.scene.validation.checks import Checks

DENSEST = 1e5  # kg/m^3


def check_water(checks: Checks) -> None:
    """Check densities and coefficients, and that there is something that could be in water.

    Raises:
        SceneError: a number out of its range, or no body with shapes where these say how large bodies are.
    """
    scene, water = checks.checked, checks.checked.water
    if water is None:
        return
    for name in ("density", "body_density"):
        if checks.interval(getattr(water, name))[1] > DENSEST:
            raise SceneError(f"is greater than {DENSEST:g} kg/m^3", f"water.{name}")
    if checks.interval(water.body_density)[0] < 1.0:
        raise SceneError("bodies are as heavy as air at least, 1 kg/m^3", "water.body_density")
    if water.volume == "shapes" and not any(body.shapes for body in scene.character.bodies.values()):
        raise SceneError("no body has a shape; take volumes from `mass`", "water.volume")
