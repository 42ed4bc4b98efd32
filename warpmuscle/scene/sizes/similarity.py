"""Gains, times and speeds of a gait for a body of another size, by dynamic similarity.

Two bodies that are alike, and move alike under the same gravity, differ by a factor l of length, m of mass and sqrt(l)
of time (Alexander, Jayes 1983; Hof 1996). So a number of the unit kg^a m^b s^c is multiplied by m^a l^b l^(c/2): a
stiffness in N m/rad by m l, a time by sqrt(l), a gain in rad/m by 1/l, a speed by sqrt(l). With them the gait of one
body is that of the other in slow motion, but for ground, muscles and thresholds that stay as they are.
"""

from __future__ import annotations

import re
from functools import cache

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import leaves
from warpmuscle.scene.scaling import multiplied
from warpmuscle.scene.units import unit_at

BASE: dict[str, tuple[int, int, int]] = {  # powers of kg, m and s
    "1": (0, 0, 0), "rad": (0, 0, 0), "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2),
    "J": (1, 2, -2), "W": (1, 2, -3), "Hz": (0, 0, -1), "Pa": (1, -1, -2),
}  # fmt: skip
PARTS = ("controller.", "objective.target_speed", "failure.no_progress", "initial_state.root_velocity.",
         "initial_state.root_angular_velocity.", "initial_state.joints.")  # fmt: skip
AS_THEY_ARE = ("controller.reflexes.", "controller.parameters.", "controller.by_")  # whose units say too little


@cache
def powers(unit: str) -> tuple[int, int, int]:
    """Powers of kg, m and s of a unit such as "N m s/rad" or "m/(N s)".

    Raises:
        ValueError: it is made of other units.
    """
    above, _, below = unit.partition("/")
    total = [0, 0, 0]
    for text, sign in ((above, 1), (below.strip("()"), -1)):
        for word in text.split():
            found = re.fullmatch(r"([A-Za-z1]+)(?:\^(\d+))?", word)
            if found is None or found[1] not in BASE:
                raise ValueError(f"unit {unit!r} has no known size")
            for k, power in enumerate(BASE[found[1]]):
                total[k] += sign * power * int(found[2] or 1)
    return (total[0], total[1], total[2])


def factor_of(unit: str, length: float, mass: float) -> float:
    """By what a number of a unit is multiplied for a body that is longer and heavier by these factors."""
    kilograms, metres, seconds = powers(unit)
    return float(mass**kilograms * length ** (metres + 0.5 * seconds))


def gait_of_size(scene: Scene, length: float, mass: float) -> Scene:
    """The scene with gains, times and speeds of its gait for a body that is longer and heavier by these factors.

    The body itself, ground and muscles stay as they are. Of numbers that follow commands, rates are multiplied as they
    are.

    Args:
        scene: it is not changed.

    Raises:
        SceneError: a factor is not positive, or a free parameter cannot be multiplied.
    """
    for name, factor in (("length", length), ("mass", mass)):
        if not 0.0 < factor < float("inf"):
            raise SceneError(f"a body grows by a positive factor, not by {factor:g}", key=name)
    factors: dict[str, float] = {}
    for path, leaf in leaves(scene):
        numeric = isinstance(leaf, int | float) and not isinstance(leaf, bool)
        if path.startswith(PARTS) and not path.startswith(AS_THEY_ARE) and (numeric or isinstance(leaf, Free)):
            unit = _of_kind(scene, path, unit_at(scene, path))
            if unit and powers(unit) != (0, 0, 0):
                factors[path] = factor_of(unit, length, mass)
    if scene.controller is not None:  # a switch: negative ones mean that it is off
        factors |= {
            path: 1.0 for path in ("controller.stance_hip_damping",) if _is_off(scene.controller.stance_hip_damping)
        }
    return multiplied(scene, factors)


def _of_kind(scene: Scene, path: str, unit: str) -> str:
    """Of "rad or m" the unit that a joint's coordinate has."""
    words = path.split(".")
    angle, _, length = unit.partition(" or ")
    joint = scene.character.joints.get(words[2]) if path.startswith("initial_state.joints.") else None
    return length if length and joint is not None and joint.type == "slide" else angle


def _is_off(number: object) -> bool:
    return isinstance(number, int | float) and number <= 0.0
