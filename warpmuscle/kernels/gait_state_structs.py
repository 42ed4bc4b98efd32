"""Device structures of reflexes that the state of gait of each leg switches on and off."""

import warp as wp

from warpmuscle.kernels.reflex_structs import ReflexSpan

UNKNOWN, EARLY_STANCE, LATE_STANCE, LIFTOFF, SWING, LANDING = 0, 1, 2, 3, 4, 5  # states of a leg
FIBRE_LENGTH, FIBRE_VELOCITY, FIBRE_FORCE, ANGLE, ANGLE_RATE, LEAN, LEAN_RATE = 0, 1, 2, 3, 4, 5, 6  # what is sensed
NOTHING = -1  # in the place of a sensor


@wp.struct
class GaitSensor:
    """What is sensed once a control step, and remembered for late reflexes."""

    kind: int  # FIBRE_LENGTH ... LEAN_RATE
    source: int  # the muscle, or the body on the joint


@wp.struct
class StateReflexPlan:
    """What stays the same of a term of a muscle's excitation."""

    sensor: int  # NOTHING: the signal is 1
    states: int  # bit k - 1 for each state k in which it acts
    positive: int  # 1: only what is positive of it counts
    angle: int  # sensors of an angle and of its rate that may silence it, or NOTHING
    rate: int


@wp.struct
class StateReflexRow:
    """Its numbers."""

    gain: float
    offset: float  # of the signal
    low: float  # rad: below it and falling, or above `high` and rising, the angle silences the term
    high: float
    delay_steps: int  # control steps


@wp.struct
class GaitThresholds:
    """At what a leg comes from one state to the next."""

    stance_load: float  # body weights
    swing_load: float
    landing: float  # m, of the foot in front of the base
    late_stance: float
    liftoff: float
    least: float  # excitation that a muscle always has


@wp.struct
class GaitStates:
    """States of gait and the reflexes of all muscles; only kernels that have them compiled in read them."""

    every: int  # steps a control step
    base: int  # the body that feet are in front of
    sensor: wp.array[GaitSensor]  # (sensors,)
    span: wp.array[ReflexSpan]  # (muscles,)
    plan: wp.array[StateReflexPlan]  # (terms,)
    row: wp.array2d[StateReflexRow]  # (rows, terms)
    thresholds: wp.array2d[GaitThresholds]  # (rows, 1)


@wp.struct
class GaitMemory:
    """What instances remember of it."""

    phase: wp.array2d[int]  # (instances, 2) state of the left and the right leg
    heard: wp.array3d[float]  # (instances, control steps, sensors) a ring, see `activation.delayed_slot`
