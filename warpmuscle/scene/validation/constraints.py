"""Checks of constraints between bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene import Character, Constraint, Scene
from warpmuscle.scene.constraints.pose import ROWS, constraint_errors, start_coordinates
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.checks import Checks, known

OPEN = 2.0e-3  # m and rad, by which a constraint may be off at the start
UNEQUAL = 1.0e5  # of masses in one loop, from which single precision lets it open by 0.1 mrad, and soon by more


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


def loop_warnings(scene: Scene) -> list[SceneError]:
    """Loops of bodies whose masses are so unequal that they open: errors that are not raised, see `start.doubts_of`.

    A body counts with those that are fixed to it. What hangs on a body of a loop counts as its load.
    """
    if not scene.character.constraints:
        return []
    plain = at_start(scene)
    names, (own, loads) = topology(plain.character), _masses(plain.character)
    found = []
    for key, constraint in plain.character.constraints.items():
        ways = [
            _way_to_root(names.bodies.index(body), names.parents) for body in (constraint.body, constraint.other_body)
        ]
        members = [names.bodies[k] for k in sorted(set(ways[0]) ^ set(ways[1])) if k > 0]
        if not members:
            continue
        light, heavy = min(members, key=own.__getitem__), max(members, key=loads.__getitem__)
        if loads[heavy] > UNEQUAL * own[light] > 0.0:
            message = (
                f"body {light!r} of its loop has {own[light]:.2g} kg and {heavy!r} carries {loads[heavy]:.3g} kg: the "
                f"loop will open, since numbers have seven digits; give {light!r} more mass, or fix it to a neighbour"
            )
            found.append(SceneError(message, key=f"character.constraints.{key}"))
    return found


def _way_to_root(body: int, parents: Sequence[int]) -> list[int]:
    """Numbers of a body and of those that carry it, the root the last."""
    found = [body]
    while found[-1] > 0:
        found.append(parents[found[-1]])
    return found


def _masses(character: Character) -> tuple[dict[str, float], dict[str, float]]:
    """Mass of every body, kg, with those fixed to it, and of all that it carries, itself included."""
    names = topology(character)
    groups, loads = list(range(len(names.bodies))), [plain_number(character.bodies[name].mass) for name in names.bodies]
    own = list(loads)
    for k in range(1, len(names.bodies)):
        if character.joints[names.joints[k - 1]].type == "fixed":
            groups[k] = groups[names.parents[k]]
            own[groups[k]] += own[k]
    for k in reversed(range(1, len(names.bodies))):
        loads[names.parents[k]] += loads[k]
    return (
        {name: own[group] for name, group in zip(names.bodies, groups, strict=True)},
        dict(zip(names.bodies, loads, strict=True)),
    )
