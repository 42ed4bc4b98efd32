"""Checks of constraints between bodies."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene import Constraint, Scene
from warpmuscle.scene.constraints.pose import ROWS, constraint_errors, start_coordinates
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.checks import Checks, known

OPEN = 2.0e-3  # m and rad, by which a constraint may be off at the start


def check_constraints(checks: Checks) -> None:
    """Every constraint is between two bodies that can move over each other, and is met at the start.

    Raises:
        SceneError: the first one that is not, with its key.
    """
    character = checks.checked.character
    for name, constraint in character.constraints.items():
        _check(checks, f"character.constraints.{name}", constraint)
    check_size(
        "constraints", sum(ROWS[one.type] for one in character.constraints.values()),
        lambda text: SceneError(text, key="character.constraints"),
    )  # fmt: skip


def _check(checks: Checks, key: str, constraint: Constraint) -> None:
    bodies = checks.checked.character.bodies
    known(constraint.body, bodies, "body", f"{key}.body")
    known(constraint.other_body, bodies, "body", f"{key}.other_body")
    if constraint.body == constraint.other_body:
        raise SceneError("must be between two different bodies", key=f"{key}.other_body")
    checks.not_zero(f"{key}.axis", constraint.axis, "axis")
    for field in ("orientation", "other_orientation"):
        checks.not_zero(f"{key}.{field}", getattr(constraint, field), "quaternion")
    if constraint.type == "distance":
        checks.positive(f"{key}.distance", constraint.distance)


def check_closed(scene: Scene) -> None:
    """A scene's constraints are met at its start; free parameters count with their start values.

    Raises:
        SceneError: one is not, with its key.
    """
    if not scene.character.constraints:
        return
    plain = at_start(scene)
    names = topology(plain.character)
    errors = constraint_errors(plain.character, names, start_coordinates(plain, names))[0]
    first = 0
    for name, constraint in plain.character.constraints.items():
        off = float(np.abs(errors[first : first + ROWS[constraint.type]]).max())
        first += ROWS[constraint.type]
        if off > OPEN:
            message = f"is off by {off:.3g} (m or rad) at the start; let initial_state bring the bodies together"
            raise SceneError(message, key=f"character.constraints.{name}")
