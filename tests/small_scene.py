"""A small scene without a fault, for tests to change."""

from warpmuscle.number import Free
from warpmuscle.scene import (
    PD,
    Balance,
    Body,
    Box,
    Character,
    Component,
    Controller,
    Curve,
    Feedback,
    Joint,
    Scene,
    Sphere,
    State,
    Trajectory,
)

ZERO = (0.0, 0.0, 0.0)
X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def hip(side: str) -> Joint:
    """A ball joint with limits."""
    return Joint("ball", "pelvis", f"{side}Foot", ZERO, ZERO, axes=[X, Y], limits=[(-1.0, 1.0)] * 3)


def sound_scene() -> Scene:
    """A small scene without a fault."""
    component = Component(X, [0.0, 0.5], [0.1, 0.2], feedback=Feedback(X, 0.3, 0.2))
    trajectory = Trajectory([component], strength=Curve([0.0], [1.0]))
    return Scene(
        name="small",
        character=Character(
            root="pelvis",
            bodies={
                "pelvis": Body(10.0, (1.0, 1.0, 1.0), [Sphere(ZERO, 0.1)]),
                "lFoot": Body(1.0, (0.1, 0.1, 0.1), [Box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))]),
                "rFoot": Body(1.0, (0.1, 0.1, 0.1)),
            },
            joints={"lHip": hip("l"), "rHip": hip("r")},
        ),
        controller=Controller(
            states=[State(0.7, {"SWING_Hip": trajectory}, balance=Balance(distance_x=Curve([0.0], [0.1])))],
            pd={"root": PD(10.0, 1.0), "lHip": PD(Free(10.0, 5.0, 20.0), 1.0)},
        ),
    )
