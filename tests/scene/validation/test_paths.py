"""What is refused about paths that wrap around surfaces, move, or are polynomials; and that the rest is read back."""

from typing import Any

import pytest

from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.scene import (
    Condition,
    CylinderSurface,
    EllipsoidSurface,
    Muscle,
    PointMotion,
    PolynomialPath,
    Scene,
    SphereSurface,
    TorusSurface,
    Wrap,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.paths import crosses
from warpmuscle.scene.validation.scene import check_scene

FLEXOR = "character.muscles.flexor"
SURFACES = "character.surfaces"


def wrapped_arm() -> Scene:
    """An arm whose flexor wraps around one surface of each kind, moves, and whose extensor is a polynomial."""
    scene = arm()
    character = scene.character
    character.surfaces = {
        "elbow": CylinderSurface("base", (0.0, 0.0, 0.0), 0.03, 0.2, (0.0, 1.5, 0.0), "+x"),
        "ball": SphereSurface("base", (0.0, 0.1, 0.0), Free(0.02, 0.01, 0.03)),
        "egg": EllipsoidSurface("tip", (0.0, 0.1, 0.0), (0.02, 0.03, 0.02)),
        "ring": TorusSurface("tip", (0.0, 0.1, 0.04), 0.01, 0.03),
    }
    flexor = character.muscles["flexor"]
    flexor.wraps = [Wrap("elbow"), Wrap("ball", 1, 2), Wrap("egg", method="axial"), Wrap("ring", first=2)]
    flexor.path[1].condition = Condition("elbow", -1.0, 0.5, 0.0)
    flexor.path[2].motion = [PointMotion((0.0, 0.0, 1.0), x=[-1.0, 0.0, 1.0], y=[0.0, 0.01, 0.0], joint="elbow")]
    polynomial = PolynomialPath(["elbow"], [[0], [1], [2]], [0.3, 0.02, Free(0.01, 0.0, 0.1)])
    character.muscles["extensor"] = Muscle(polynomial=polynomial, f_max=400.0, l_opt=0.15, l_slack=0.1)
    return scene


def test_all_kinds_of_paths_are_accepted_written_and_read(tmp_path):
    scene = wrapped_arm()
    check_scene(scene)
    save(scene, tmp_path / "arm.toml")
    assert load(tmp_path / "arm.toml") == scene


def changed(scene: Scene, key: str, value: Any) -> None:
    owner: Any = scene
    *path, last = key.split(".")
    for name in path:
        owner = owner[int(name)] if name.isdigit() else owner[name] if isinstance(owner, dict) else getattr(owner, name)
    if last.isdigit():
        owner[int(last)] = value
    else:
        setattr(owner, last, value)


@pytest.mark.parametrize(
    ("key", "value", "at", "message"),
    [
        (f"{SURFACES}.elbow.body", "bass", f"{SURFACES}.elbow.body", "did you mean 'base'"),
        (f"{SURFACES}.elbow.radius", 0.0, f"{SURFACES}.elbow.radius", "must be greater than 0"),
        (f"{SURFACES}.elbow.length", -0.1, f"{SURFACES}.elbow.length", "must not be negative"),
        (f"{SURFACES}.ball.radius", Free(0.1, -0.1, 0.2), f"{SURFACES}.ball.radius", "greater than 0, is -0.1"),
        (f"{SURFACES}.egg.radii", (0.1, 0.0, 0.1), f"{SURFACES}.egg.radii.1", "must be greater than 0"),
        (f"{SURFACES}.ring.inner_radius", 0.03, f"{SURFACES}.ring.inner_radius", "less than the outer radius 0.03"),
        (f"{SURFACES}.elbow.side", "x", "", "side"),
        (f"{FLEXOR}.wraps.0.surface", "elbo", f"{FLEXOR}.wraps.0.surface", "did you mean 'elbow'"),
        (f"{FLEXOR}.wraps.1.last", 4, f"{FLEXOR}.wraps.1.last", "points 1 to 3, not 4"),
        (f"{FLEXOR}.wraps.1.first", 0, f"{FLEXOR}.wraps.1.first", "leave `first` out"),
        (f"{FLEXOR}.wraps.1.first", 3, f"{FLEXOR}.wraps.1.first", "must not come after `last`, 2"),
        (f"{FLEXOR}.wraps", [Wrap("elbow")] * 9, f"{FLEXOR}.wraps", "7 surfaces at most, got 9"),
        (f"{FLEXOR}.path.1.condition.blend", -0.1, f"{FLEXOR}.path.1.condition.blend", "must not be negative"),
        (f"{FLEXOR}.path.1.condition.blend", Free(0.1, 0.0, 0.2), f"{FLEXOR}.path.1.condition.blend", "always above 0"),
        (f"{FLEXOR}.path.2.motion.0.joint", "knee", f"{FLEXOR}.path.2.motion.0.joint", "no joint 'knee'"),
        (f"{FLEXOR}.path.2.motion.0.y", [0.1], f"{FLEXOR}.path.2.motion.0.y", "1 value for 3 knots"),
        (f"{FLEXOR}.path.2.motion.0.axis", (0.0, 0.0, 0.0), f"{FLEXOR}.path.2.motion.0.axis", "no length"),
        ("character.muscles.extensor.wraps", [Wrap("elbow")], "character.muscles.extensor.polynomial", "not both"),
        ("character.muscles.extensor.polynomial.joints", ["elbow", "x"],
         "character.muscles.extensor.polynomial.joints.1", "there is no joint 'x'"),
        ("character.muscles.extensor.polynomial.axes", [1], "character.muscles.extensor.polynomial.axes.0", "angle 1"),
        ("character.muscles.extensor.polynomial.coefficients", [1.0],
         "character.muscles.extensor.polynomial.coefficients", "1 coefficient for 3 rows"),
        ("character.muscles.extensor.polynomial.exponents.2", [1, 2],
         "character.muscles.extensor.polynomial.exponents.2", "2 exponents for 1 joint"),
        ("character.muscles.extensor.polynomial.exponents.2", [-1],
         "character.muscles.extensor.polynomial.exponents.2.0", "within 0 and 20, is -1"),
        ("character.muscles.extensor.polynomial", None, "character.muscles.extensor", "or a `polynomial`"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_key(key: str, value: Any, at: str, message: str):
    scene = wrapped_arm()
    changed(scene, key, value)
    with pytest.raises(SceneError, match=message) as error:
        check_scene(scene)
    assert not at or error.value.key == at


def test_a_muscle_crosses_a_joint_by_its_surface_its_moving_point_or_its_polynomial():
    scene = wrapped_arm()
    character = scene.character
    extensor, flexor = (character.muscles[name] for name in ("extensor", "flexor"))
    assert crosses(extensor, "elbow", character)
    flexor.path = flexor.path[:2]
    flexor.path[1].condition = None
    assert crosses(flexor, "elbow", character)
    flexor.wraps = [Wrap("elbow")]
    assert not crosses(flexor, "elbow", character)
    flexor.path[1].motion = [PointMotion((0.0, 0.0, 1.0), slope=0.1, joint="elbow")]
    assert crosses(flexor, "elbow", character)
