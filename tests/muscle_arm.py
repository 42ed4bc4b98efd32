"""Small characters with muscles on a fixed root: an arm of two bodies, and a leg with a muscle over two joints."""

from __future__ import annotations

from typing import Any

from warpmuscle.scene import Body, Character, Excitation, Failure, InitialState, Joint, Muscle, Scene, ViaPoint

ZERO, X, Y = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
AXES = {"hinge": [X], "universal": [X, (0.3, 0.2, 1.0)], "ball": [X, Y]}  # of the universal joint not at right angles
REACH = 0.2  # m, from a joint to the centre of mass beyond it
MASS, INERTIA = 2.0, (0.03, 0.01, 0.04)  # kg, kg m^2 about the centre of mass
ABOUT_JOINT = INERTIA[0] + MASS * REACH**2  # kg m^2, about the x axis of the joint above


def muscle(*places: tuple[str, tuple[float, float, float]], **properties: Any) -> Muscle:
    """A muscle through points of bodies."""
    given = {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1, **properties}
    return Muscle(path=[ViaPoint(body, position) for body, position in places], **given)


def arm(kind: str = "hinge", flexor: dict[str, Any] | None = None, **changes: Any) -> Scene:
    """A body that hangs on another one, and a muscle on each side of the joint between them.

    Args:
        kind: of the joint.
        flexor: other properties of the muscle in front, whose path is 0.3 m long as it hangs, 0.08 m of them on the
            upper body; the one behind is its mirror image with the properties of `muscle`.
        changes: fields of the scene.
    """
    bodies = {name: Body(MASS, INERTIA) for name in ("base", "tip")}
    joint = Joint(kind, "base", "tip", ZERO, (0.0, REACH, 0.0), AXES[kind])
    sides = [[("base", (0.0, y, z)) for y in (0.2, 0.12)] + [("tip", (0.0, REACH - 0.1, z))] for z in (0.04, -0.04)]
    muscles = {"flexor": muscle(*sides[0], **flexor or {}), "extensor": muscle(*sides[1])}
    return _hanging("arm", Character("base", bodies, {"elbow": joint}, "fixed", muscles), changes)


def leg(**changes: Any) -> Scene:
    """Two bodies on a ball joint and a hinge, a muscle over each joint, and one over both."""
    bodies = {name: Body(MASS, INERTIA) for name in ("pelvis", "thigh", "shank")}
    joints = {
        "hip": Joint("ball", "pelvis", "thigh", (0.0, -0.05, 0.0), (0.0, REACH, 0.0), [X, Y]),
        "knee": Joint("hinge", "thigh", "shank", (0.0, -REACH, 0.0), (0.0, REACH, 0.0), [X]),
    }
    muscles = {
        "both": muscle(("pelvis", (0.03, 0.0, -0.07)), ("thigh", (0.02, 0.1, -0.05)), ("shank", (0.01, 0.1, -0.04))),
        "hip": muscle(("pelvis", (0.06, 0.05, 0.06)), ("thigh", (0.03, 0.05, 0.04))),
        "knee": muscle(("thigh", (0.0, 0.0, 0.05)), ("shank", (0.01, 0.1, 0.05))),
    }
    return _hanging("leg", Character("pelvis", bodies, joints, "fixed", muscles), changes)


def _hanging(name: str, character: Character, changes: dict[str, Any]) -> Scene:
    scene = Scene(name, character, initial_state=InitialState((0.0, 1.0, 0.0)), failure=Failure(0.0, 0.0))
    for field, value in changes.items():
        setattr(scene, field, value)
    return scene


def constant(excitation: float) -> Excitation:
    """An excitation that does not change."""
    return Excitation([0.0], [excitation])
