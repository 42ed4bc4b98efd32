"""A small scene without a fault, for tests to change."""

from warpmuscle.scene import (
    PD,
    Actuation,
    Balance,
    Body,
    Box,
    Character,
    Component,
    Condition,
    Controller,
    Curve,
    Excitation,
    Feedback,
    Joint,
    MachineState,
    Muscle,
    Objective,
    Scene,
    Sphere,
    Trajectory,
    ViaPoint,
)
from warpmuscle.scene.number import Free

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
        objective=Objective(torque=1.0),
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
            states=[MachineState(0.7, {"SWING_Hip": trajectory}, balance=Balance(distance_x=Curve([0.0], [0.1])))],
            pd={"root": PD(10.0, 1.0), "lHip": PD(Free(10.0, 5.0, 20.0), 1.0)},
        ),
    )


def muscle_scene() -> Scene:
    """The small scene with toes on a hinge and two muscles, one on a hip and one on the toes; passive on the other hip.

    The toe muscle has a conditional point and an excitation of its own.
    """
    scene = sound_scene()
    character = scene.character
    character.bodies["lToes"] = Body(0.5, (0.1, 0.1, 0.1))
    character.joints["lToe"] = Joint("hinge", "lFoot", "lToes", (0.0, 0.0, 0.1), (0.0, 0.0, -0.1), axes=[X])
    character.muscles = {
        "HFL": Muscle(
            path=[ViaPoint("pelvis", (0.0, 0.1, 0.1)), ViaPoint("lFoot", (0.0, -0.3, 0.1))],
            f_max=1000.0,
            l_opt=0.2,
            l_slack=0.15,
            delay=0.01,
        ),
        "TFL": Muscle(
            path=[
                ViaPoint("lFoot", (0.0, 0.3, 0.0)),
                ViaPoint("lFoot", (0.0, 0.1, 0.05), Condition("lToe", -1.0, 0.5)),
                ViaPoint("lToes", (0.0, -0.1, 0.0)),
            ],
            f_max=500.0,
            l_opt=0.1,
            l_slack=0.2,
            pennation=0.3,
            excitation=Excitation([0.0, 0.5], [0.0, 1.0], period=1.0),
        ),
    }
    scene.actuation = {"rHip": Actuation("passive", stiffness=10.0, damping=1.0)}
    return scene
