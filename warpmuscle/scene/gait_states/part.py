"""States of gait of a leg, and the reflexes that act in them; units are SI and radians.

The equations stand in `kernels/control/gait_states.py`.
"""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, FRACTION, FROM_0, Part

State = Literal["early_stance", "late_stance", "liftoff", "swing", "landing"]
STATES: tuple[State, ...] = ("early_stance", "late_stance", "liftoff", "swing", "landing")  # in their order
Signal = Literal[
    "length", "velocity", "force", "spindle", "activation", "angle", "rate", "position", "speed", "acceleration"
]
Side = Literal["both", "left", "right"]
Shape = Literal["linear", "constant", "polynomial"]
Fixed = tuple[float, float, float]
ROOT = "root"  # what `joint` calls the lean of the root


class SensedPoint(Part):
    """A point of a body, sensed along a direction of the world, whose length is a factor.

    That is where it is, how fast it moves, and how much its speed has changed in a second over the last control step.
    """

    body: str
    direction: Annotated[Fixed, "1"]
    place: Annotated[Fixed, "m"] = (0.0, 0.0, 0.0)  # from the body's centre of mass, in its axes


class SensedTurn(Part):
    """How far a body is turned about one of its axes: its rotation vector, rad, times this axis.

    With `angles` in place of this vector those by which it turns about y, then its x, then its z.
    """

    body: str
    axis: Annotated[Fixed, "1"]  # in the body, for a muscle of the right leg
    mirrored: bool = True  # in the sagittal plane, for one of the left leg
    angles: bool = False


class SensedBalance(Part):
    """Where the centre of mass is from a body, along a level direction that turns with the root, and how fast it goes.

    For a muscle of the left leg the direction is mirrored in the sagittal plane.
    """

    direction: Annotated[Fixed, "1"]  # in the root, for a muscle of the right leg
    pivot: str = ""  # the body; the middle between both feet if empty


class GaitReflex(Part):
    """What some signals add to a muscle's excitation while its leg is in some states.

    It is constant + length_gain (length - length_offset) and the same of velocity, force, spindle and activation of
    muscle `of`, where a spindle tells length + 0.325 sqrt(velocity), the root with its sign, and 0 below that, and
    angle_gain (angle_target - angle) + rate_gain (rate_target - rate) of `joint` or `turn`, and
    position_gain (position_target - position) + speed_gain (speed_target - speed) of `point` or `balance`, and
    acceleration_gain (acceleration_target - acceleration) of `point`, all sensed `delay` ago. Of signals in `positive`
    only what they add beyond 0 counts, and of those of muscles only what they exceed their offset by.
    Names are without their side: `soleus` stands for `soleus_l` and `soleus_r`, or for `lsoleus` and `rsoleus`.
    """

    muscle: str
    during: list[State]
    side: Side = "both"  # whose muscle it acts on: for legs that are not alike
    opposite: bool = False  # what is sensed is of the other leg
    delay: Annotated[Number, "s", FROM_0] = 0.0
    constant: Annotated[Number, "1"] = 0.0
    of: str = ""  # muscle that is sensed; the muscle itself if empty
    length_gain: Annotated[Number, "1"] = 0.0  # per l_opt
    length_offset: Annotated[Number, "1"] = 1.0  # l_opt
    velocity_gain: Annotated[Number, "s"] = 0.0  # per l_opt/s
    velocity_offset: Annotated[Number, "l_opt/s"] = 0.0
    force_gain: Annotated[Number, "1"] = 0.0  # per f_max
    force_offset: Annotated[Number, "1"] = 0.0  # f_max
    spindle_gain: Annotated[Number, "1"] = 0.0
    spindle_offset: Annotated[Number, "1"] = 0.0
    activation_gain: Annotated[Number, "1"] = 0.0
    activation_offset: Annotated[Number, "1"] = 0.0
    joint: str = ""  # of one coordinate, or `root`, whose angle is how far it leans backwards
    angle_gain: Annotated[Number, "1/rad"] = 0.0
    angle_target: Annotated[Number, "rad"] = 0.0
    rate_gain: Annotated[Number, "s/rad"] = 0.0
    rate_target: Annotated[Number, "rad/s"] = 0.0
    turn: SensedTurn | None = None
    point: SensedPoint | None = None
    balance: SensedBalance | None = None
    position_gain: Annotated[Number, "1/m"] = 0.0
    position_target: Annotated[Number, "m"] = 0.0
    speed_gain: Annotated[Number, "s/m"] = 0.0
    speed_target: Annotated[Number, "m/s"] = 0.0
    acceleration_gain: Annotated[Number, "s^2/m"] = 0.0
    acceleration_target: Annotated[Number, "m/s^2"] = 0.0
    positive: list[Signal] = msgspec.field(default_factory=lambda: list[Signal](["velocity"]))
    within_joint: str = ""  # beyond whose interval, and on the way further, the signals do not count
    within_low: Annotated[Number, "rad"] = -1.0e3
    within_high: Annotated[Number, "rad"] = 1.0e3


class GaitPattern(Part):
    """What is added to a muscle's excitation by the time since its leg came into some states, whatever is sensed.

    `linear` goes straight from knot to knot, `constant` keeps a knot's value up to the next one, and of a `polynomial`
    the values are the coefficients of time^0, time^1, and so on.
    """

    muscle: str
    values: Annotated[list[Number], "1"]  # at the knots, the first of which is at 0
    during: list[State] = msgspec.field(default_factory=lambda: list[State](STATES))
    side: Side = "both"
    shape: Shape = "linear"
    intervals: Annotated[list[Number], "s", ABOVE_0] = []  # from knot to knot
    flat: bool = False  # of linear ones: beyond the last knot its value counts, not the line through the last two


class LegThresholds(Part):
    """What differs for one leg; by default nothing."""

    stance_load: Annotated[Number | None, "1", FROM_0] = None
    swing_load: Annotated[Number | None, "1", FROM_0] = None
    late_stance: Annotated[Number | None, "1"] = None
    liftoff: Annotated[Number | None, "1"] = None
    landing: Annotated[Number | None, "1"] = None


class GaitNoise(Part):
    """Noise of excitations: normal, drawn anew each control step, the same for all candidates of a search."""

    base: Annotated[Number, "1", FROM_0] = 0.0  # standard deviation
    proportional: Annotated[Number, "1", FROM_0] = 0.0  # the same of each excitation
    seed: int = 123


class GaitStates(Part):
    """A controller of muscles by reflexes, which the states of both legs switch on and off.

    A leg is in one of five states, in this order: early_stance, late_stance once its foot is behind the base, liftoff
    once the other foot carries a load in front of it, swing once it is unloaded, landing once it is in front again.
    """

    reflexes: dict[str, GaitReflex]  # by names of one's own
    base: str  # body that feet are in front of, or behind
    leg_length: Annotated[Number, "m", ABOVE_0] = 1.0
    stance_load: Annotated[Number, "1", FROM_0] = 0.1  # body weights; a leg that carries more stands
    swing_load: Annotated[Number | None, "1", FROM_0] = None  # one that carries no more swings; by default the same
    late_stance: Annotated[Number, "1"] = 0.0  # leg lengths in front of the base, like the next two
    liftoff: Annotated[Number, "1"] = -1.0
    landing: Annotated[Number, "1"] = 0.0
    control_step: Annotated[float, "s", ABOVE_0] = 0.005
    least: Annotated[Number, "1", FRACTION] = 0.01  # excitation that muscles always have
    patterns: dict[str, GaitPattern] = {}  # by names of one's own
    right: LegThresholds | None = None  # of the right leg
    noise: GaitNoise | None = None


def sided(name: str, names: object, side: str) -> str:
    """The name of something on a side, `l` or `r`, among those that there are; the name itself where it has none."""
    for candidate in (f"{name}_{side}", f"{side}{name}"):
        if candidate in names:  # type: ignore[operator]
            return candidate
    return name
