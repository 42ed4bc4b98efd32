"""What a scene says of a SIMBICON controller; units are SI and radians, see `scene.py`."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import OF_OWNER, Number, Vector
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part, Side
from warpmuscle.scene.reflexes import Reflexes


class PD(Part):
    """Proportional-derivative gains of a joint; `scale` and the torque limit act along the child's axes."""

    kp: Annotated[Number, "N m/rad", FROM_0]
    kd: Annotated[Number, "N m s/rad", FROM_0]
    torque_limit: Annotated[Number, "N m", FROM_0] = 10000.0  # times scale
    scale: Annotated[Vector, "1", FROM_0] = (1.0, 1.0, 1.0)


class Curve(Part):
    """A Catmull-Rom curve over the phase of a state; constant beyond its knots."""

    phase: Annotated[list[Number], "1"]
    value: Annotated[list[Number], OF_OWNER]


class Feedback(Part):
    """Linear balance feedback: cd (d . axis) + cv (v . axis), in the character frame.

    d is the vector from the stance foot to the whole body's centre of mass, v the velocity of the latter.
    """

    axis: Annotated[Vector, "1"]
    cd: Annotated[Number, "rad/m"] = 0.0
    cv: Annotated[Number, "rad s/m"] = 0.0
    d_limits: Annotated[tuple[Number, Number], "m"] = (-1000.0, 1000.0)  # clamp of d . axis
    v_limits: Annotated[tuple[Number, Number], "m/s"] = (-1000.0, 1000.0)  # clamp of v . axis


class Component(Part):
    """One rotation of a target: a base angle over the phase plus balance feedback, about `axis`."""

    axis: Annotated[Vector, "1"]
    phase: Annotated[list[Number], "1"] = []
    angle: Annotated[list[Number], "rad"] = []  # one a phase
    reverse_on: Side | Literal["never"] = "never"  # stance in which the base angle changes its sign
    feedback: Feedback | None = None


class Trajectory(Part):
    """Target orientation of a joint: the rotations of its components, the first one applied first."""

    components: list[Component] = []
    frame: Literal["parent", "character"] = "parent"  # the swing hip's is always the character frame
    strength: Annotated[Curve | None, "1"] = None  # factor on the joint's PD torque; 1 if absent


class Balance(Part):
    """Set points of the balance feedback over the phase, in the character frame; x changes sign in right stance."""

    distance_x: Annotated[Curve | None, "m"] = None
    distance_z: Annotated[Curve | None, "m"] = None
    velocity_x: Annotated[Curve | None, "m/s"] = None
    velocity_z: Annotated[Curve | None, "m/s"] = None


class MachineState(Part):
    """A state of the controller's machine. Trajectories are named by joint, `root`, `SWING_X` or `STANCE_X`.

    The latter two mean the joints `lX` and `rX`, or the pair X of the controller's `pairs`.
    """

    time: Annotated[Number, "s", ABOVE_0]  # nominal duration
    trajectories: dict[str, Trajectory] = {}
    next: int = 0
    transition: Literal["foot_down", "time_up"] = "foot_down"
    stance: Literal["reverse", "same", "left", "right"] = "reverse"  # stance on entering this state
    balance: Balance | None = None
    description: str = ""
    longest: Annotated[Number, "1"] = 1.0  # phase up to which a state waits for its foot; targets stay as at phase 1


class Simbicon(Part):
    """A SIMBICON controller (Yin, Loken, van de Panne 2007; as in the Controller Editor Framework 1.5)."""

    states: list[MachineState] = []
    pd: dict[str, PD] = {}  # by joint, or `root`; a joint without an entry gets no torque
    feet: tuple[str, str] = ("lFoot", "rFoot")  # bodies, left and right, unless the character names its own
    hips: tuple[str, str] = ("lHip", "rHip")  # joints, left and right
    pairs: dict[str, tuple[str, str]] = {}  # joints, left and right, that `SWING_X` and `STANCE_X` mean by X
    stance_hip_damping: Annotated[Number, "N m s^2/rad^2"] = -1.0  # off unless positive
    stance_hip_max_velocity: Annotated[Number, "rad/s", FROM_0] = 4.0
    root_predictive_torque_scale: Annotated[Number, "kg"] = 0.0
    heading_control: bool = True  # False: the root's target follows the character's own heading
    desired_heading: Annotated[Number, "rad"] = 0.0
    start_state: int = 0
    start_stance: Side = "left"
    reflexes: Reflexes | None = None  # of muscles, in place of the torques that these are to give
