"""Checks of the forces of a scene."""

from __future__ import annotations

from warpmuscle.core.errors import SceneError
from warpmuscle.scene.validation.checks import Checks, known


def check_forces(check: Checks) -> None:
    """Every force acts on one joint that moves, or on one body."""
    character = check.checked.character
    for name, force in check.checked.forces.items():
        key = f"forces.{name}"
        if bool(force.joint) == bool(force.body):
            raise SceneError("name either a joint or a body that it acts on", key=key)
        if force.joint:
            known(force.joint, character.joints, "joint", f"{key}.joint")
            if character.joints[force.joint].type == "fixed":
                raise SceneError(f"joint {force.joint!r} does not move", key=f"{key}.joint")
        else:
            known(force.body, character.bodies, "body", f"{key}.body")
