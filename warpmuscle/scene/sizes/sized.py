"""A body of another height, mass and other proportions, with its muscles."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase

import msgspec
import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.scene import InitialState, Scene
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.initial_pose import initial_pose, plain_number, plain_vector
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.scaling import multiplied, scaled_segments
from warpmuscle.scene.sizes.similarity import gait_of_size

HEIGHTS = (0.3, 3.0)  # m, that a body may have
MASSES = (1.0, 500.0)  # kg


def height_of(scene: Scene) -> float:
    """Height of a body in its reference pose, m: from the lowest to the highest point of its shapes.

    Raises:
        SceneError: it has no shapes.
    """
    plain = at_start(scene)
    poses, _ = initial_pose(msgspec.structs.replace(plain, initial_state=InitialState()))
    ends = [
        (position + rotate(orientation, plain_vector(point)))[1] + sign * plain_number(radius)
        for name, (position, orientation) in poses.items()
        for shape in plain.character.bodies[name].shapes
        for point, radius in contact_points(shape)
        for sign in (-1.0, 1.0)
    ]
    if not ends:
        raise SceneError("has no shapes, from which its height would follow", key="character.bodies")
    return float(np.max(ends) - np.min(ends))


def sized(
    scene: Scene,
    height: float | None = None,
    mass: float | None = None,
    *,
    lengths: Mapping[str, float] | None = None,
    masses: Mapping[str, float] | None = None,
    gait: bool = True,
) -> Scene:
    """The scene with a body of another height and mass, and, if wanted, its gait by dynamic similarity.

    All lengths grow with the height, masses with the mass, inertias with both. Fibres and tendons grow as their paths
    do, and strengths with the mass: the volume of people's leg muscles grows with mass times height (Handsfield 2014),
    so that their cross-section does with the mass.

    Args:
        scene: it is not changed. height: m; by default as it is. mass: kg; by default that of the same build, which
            grows with the third power of the height.
        lengths: further factors on lengths of bodies, and masses: on their masses before the whole is brought to
            `mass`; both by name, or by a pattern such as `*arm`.
        gait: whether gains, times and speeds grow as well, see `similarity`.

    Raises:
        SceneError: a height or mass that no body has, a factor that is not positive, or a pattern that names no body.
    """
    plain = at_start(scene)
    own_height, own_mass = height_of(scene), body_mass(plain.character)
    height = own_height if height is None else _within("height", height, HEIGHTS, "m")
    length = height / own_height
    mass = own_mass * length**3 if mass is None else _within("mass", mass, MASSES, "kg")
    stretched = {name: length * _product(name, lengths or {}) for name in scene.character.bodies}
    heavier = {name: _product(name, masses or {}) for name in scene.character.bodies}
    for key, table in (("lengths", lengths or {}), ("masses", masses or {})):
        _check_patterns(scene, key, table)
    made = scaled_segments(scene, stretched, muscles=True)
    before = {name: plain_number(body.mass) for name, body in plain.character.bodies.items()}
    wanted = {name: before[name] * heavier[name] for name in before}
    whole = sum(wanted.values())
    factors: dict[str, float] = {}
    for name in before:
        if before[name] > 0.0:
            grown = mass / whole * heavier[name]  # over the mass that it had
            factors[f"character.bodies.{name}.mass"] = grown / stretched[name] ** 3
            for axis in range(3):
                factors[f"character.bodies.{name}.inertia.{axis}"] = grown / stretched[name] ** 3
    for name in scene.character.muscles:
        factors[f"character.muscles.{name}.f_max"] = mass / own_mass
    made = multiplied(made, factors)
    return gait_of_size(made, length, mass / own_mass) if gait else made


def _within(key: str, number: float, bounds: tuple[float, float], unit: str) -> float:
    if not bounds[0] <= number <= bounds[1]:
        raise SceneError(f"must be between {bounds[0]:g} and {bounds[1]:g} {unit}, is {number:g}", key=key)
    return number


def _product(name: str, table: Mapping[str, float]) -> float:
    """All factors of a body, multiplied."""
    return float(np.prod([factor for pattern, factor in table.items() if fnmatchcase(name, pattern)]))


def _check_patterns(scene: Scene, key: str, table: Mapping[str, float]) -> None:
    for pattern, factor in table.items():
        if not 0.0 < factor < np.inf:
            raise SceneError(f"must be a positive factor, is {factor:g}", key=f"{key}.{pattern}")
        if not any(fnmatchcase(name, pattern) for name in scene.character.bodies):
            known = ", ".join(scene.character.bodies)
            raise SceneError(f"names no body; there are {known}", key=f"{key}.{pattern}")
