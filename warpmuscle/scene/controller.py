"""The controller of a scene; units are SI and radians, see `scene.py`."""

from __future__ import annotations

from typing import Literal

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import Part, Side
from warpmuscle.scene.reflexes import Reflexes


class PD(Part):
    """Proportional-derivative gains of a joint; `scale` and the torque limit act along the child's axes."""

    kp: Number  # N m/rad
    kd: Number  # N m s/rad
    torque_limit: Number = 10000.0  # N m, times scale
    scale: Vector = (1.0, 1.0, 1.0)


class Curve(Part):
    """A Catmull-Rom curve over the phase of a state; constant beyond its knots."""

    phase: list[Number]
    value: list[Number]


class Feedback(Part):
    """Linear balance feedback: cd (d . axis) + cv (v . axis), in the character frame.

    d is the vector from the stance foot to the whole body's centre of mass, v the velocity of the latter.
    """

    axis: Vector
    cd: Number = 0.0  # rad/m
    cv: Number = 0.0  # rad s/m
    d_limits: tuple[Number, Number] = (-1000.0, 1000.0)  # clamp of d . axis, m
    v_limits: tuple[Number, Number] = (-1000.0, 1000.0)  # clamp of v . axis, m/s


class Component(Part):
    """One rotation of a target: a base angle over the phase plus balance feedback, about `axis`."""

    axis: Vector
    phase: list[Number] = []
    angle: list[Number] = []  # rad, one a phase
    reverse_on: Side | Literal["never"] = "never"  # stance in which the base angle changes its sign
    feedback: Feedback | None = None


class Trajectory(Part):
    """Target orientation of a joint: the rotations of its components, the first one applied first."""

    components: list[Component] = []
    frame: Literal["parent", "character"] = "parent"  # the swing hip's is always the character frame
    strength: Curve | None = None  # factor on the joint's PD torque; 1 if absent


class Balance(Part):
    """Set points of the balance feedback over the phase, in the character frame; x changes sign in right stance."""

    distance_x: Curve | None = None  # m
    distance_z: Curve | None = None
    velocity_x: Curve | None = None  # m/s
    velocity_z: Curve | None = None


class State(Part):
    """A state of the controller's machine. Trajectories are named by joint, `root`, `SWING_X` or `STANCE_X`."""

    time: Number  # s, nominal duration
    trajectories: dict[str, Trajectory] = {}
    next: int = 0
    transition: Literal["foot_down", "time_up"] = "foot_down"
    stance: Literal["reverse", "same", "left", "right"] = "reverse"  # stance on entering this state
    balance: Balance | None = None
    description: str = ""


class Controller(Part):
    """A SIMBICON controller (Yin, Loken, van de Panne 2007; as in the Controller Editor Framework 1.5)."""

    states: list[State]
    pd: dict[str, PD] = {}  # by joint, or `root`; a joint without an entry gets no torque
    feet: tuple[str, str] = ("lFoot", "rFoot")  # bodies, left and right
    hips: tuple[str, str] = ("lHip", "rHip")  # joints, left and right
    stance_hip_damping: Number = -1.0  # N m s^2/rad^2; off unless positive
    stance_hip_max_velocity: Number = 4.0  # rad/s
    root_predictive_torque_scale: Number = 0.0
    heading_control: bool = True  # False: the root's target follows the character's own heading
    desired_heading: Number = 0.0  # rad
    start_state: int = 0
    start_stance: Side = "left"
    reflexes: Reflexes | None = None  # of muscles, in place of the torques that these are to give
