"""Scenes as models of others have them: muscles round surfaces of all kinds, and a loop of bodies."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from muscle_arm import REACH, constant, leg
from warpmuscle.scene import (
    Body,
    Constraint,
    CylinderSurface,
    EllipsoidSurface,
    Joint,
    Scene,
    SphereSurface,
    TorusSurface,
    Wrap,
)
from warpmuscle.scene.muscles import MuscleModel
from warpmuscle.scene.muscles.curves import MujocoCurves

X_AND_Z = [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]


def wrapped(wrapping: str, more: bool = False) -> Scene:
    """A leg whose muscles go round a cylinder and a sphere, an ellipsoid, and a cylinder with a side and a torus.

    Args:
        more: whether one goes round a third surface: then a GPU finds paths by a kernel of their own.
    """
    scene = leg()
    character = scene.character
    character.wrapping = wrapping
    character.surfaces = {
        "knee": CylinderSurface("thigh", (0.0, -0.2, 0.0), 0.03, 0.2, (0.1, 1.4, 0.2), "+x"),
        "ball": SphereSurface("pelvis", (0.02, -0.1, -0.05), 0.03),
        "head": EllipsoidSurface("thigh", (0.03, 0.12, 0.04), (0.03, 0.05, 0.025), (0.2, 0.3, 0.1)),
        "shin": CylinderSurface("thigh", (0.0, -0.15, 0.02), 0.03, 0.2, (0.1, 1.4, 0.2)),
        "ring": TorusSurface("shank", (0.0, 0.16, 0.05), 0.01, 0.03, (1.5, 0.0, 0.0)),
    }
    character.muscles["both"].wraps = [Wrap("knee"), Wrap("ball", 1, 2)]
    if more:
        character.muscles["both"].wraps.append(Wrap("shin"))
    character.muscles["hip"].wraps = [Wrap("head")]
    character.muscles["knee"].wraps = [Wrap("shin"), Wrap("ring")]
    for muscle in character.muscles.values():
        muscle.excitation = constant(0.4)
    return scene


def pulled_as_in_mujoco() -> Scene:
    """A leg whose muscles have MuJoCo's curves, their passive force with numbers of its own."""
    scene = leg()
    shape = MujocoCurves(active_from=0.4, active_until=1.7, passive_force=1.6, passive_from=0.8, passive_until=1.5)
    scene.muscle_model = MuscleModel(curves="mujoco", curve_shape=shape)
    for muscle in scene.character.muscles.values():
        muscle.excitation = constant(0.4)
    return scene


def looped() -> Scene:
    """A leg, a rod and a bar that hang side by side: a point closes the one loop, and a distance holds the shank."""
    scene = leg()
    character = scene.character
    character.bodies |= {"bar": Body(0.8, (0.01, 0.005, 0.01)), "rod": Body(0.5, (0.01, 0.004, 0.01))}
    character.joints["bar"] = Joint("ball", "pelvis", "bar", (0.1, -0.05, 0.0), (0.0, REACH, 0.0))
    character.joints["rod"] = Joint("universal", "bar", "rod", (0.0, -REACH, 0.0), (0.05, 0.0, 0.0), X_AND_Z)
    character.constraints = {
        "closed": Constraint("point", "rod", "thigh", (-0.05, 0.0, 0.0), (0.0, -REACH, 0.0)),
        "strap": Constraint(
            "distance", "shank", "bar", (0.0, -0.1, 0.0), (0.0, -REACH, 0.0), distance=0.3162277660168379
        ),
    }
    for muscle in character.muscles.values():
        muscle.excitation = constant(0.4)
    return scene


MODEL_KINDS: dict[str, Callable[[Path], Scene]] = {
    "wrapped": lambda _: wrapped("smooth"),
    "wrapped thrice": lambda _: wrapped("smooth", more=True),
    "wrapped as OpenSim": lambda _: wrapped("opensim"),
    "as in MuJoCo": lambda _: pulled_as_in_mujoco(),
    "looped": lambda _: looped(),
}
