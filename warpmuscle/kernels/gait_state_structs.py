"""Device structures of reflexes that the state of gait of each leg switches on and off."""

import warp as wp

from warpmuscle.kernels.reflex_structs import ReflexSpan

UNKNOWN, EARLY_STANCE, LATE_STANCE, LIFTOFF, SWING, LANDING = 0, 1, 2, 3, 4, 5  # states of a leg
FIBRE_LENGTH, FIBRE_VELOCITY, FIBRE_FORCE, ANGLE, ANGLE_RATE, LEAN, LEAN_RATE = 0, 1, 2, 3, 4, 5, 6  # what is sensed
POSITION, SPEED, TURN, TURN_RATE, BALANCE, BALANCE_SPEED, TURN_ANGLE = 7, 8, 9, 10, 11, 12, 13
SPINDLE, ACTIVATION = 14, 15  # of muscles, too
NOTHING = -1  # in the place of a sensor, or of the pivot of a balance: the middle between both feet
LINEAR, FLAT, CONSTANT, POLYNOMIAL = 0, 1, 2, 3  # shapes of patterns


@wp.struct
class GaitSensor:
    """What is sensed once a control step, and remembered for late reflexes."""

    kind: int  # FIBRE_LENGTH ... ACTIVATION
    source: int  # the muscle, the body on the joint, or the body
    place: wp.vec3  # m, of a point from the body's centre of mass, in its axes
    along: wp.vec3  # a point's direction in the world, an axis in the body, or a direction in the root


@wp.struct
class StateReflexPlan:
    """What stays the same of a term of a muscle's excitation."""

    sensor: int  # NOTHING: the signal is 1
    states: int  # bit k - 1 for each state k in which it acts
    positive: int  # 1: only what is positive of it counts, 2: only what its signal exceeds the offset by
    change: int  # 1: the signal is how much the sensor has changed over a control step, a second
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
    noise: float  # standard deviation of excitations, and what each one's own adds to it
    noise_share: float


@wp.struct
class GaitPatternPlan:
    """What stays the same of a pattern of a muscle's excitation over time."""

    first: int  # its knots
    end: int
    shape: int  # LINEAR, FLAT, CONSTANT or POLYNOMIAL
    states: int  # bit k - 1 for each state k in which it acts


@wp.struct
class GaitStates:
    """States of gait and the reflexes of all muscles; only kernels that have them compiled in read them."""

    every: int  # steps a control step
    base: int  # the body that feet are in front of
    sensor: wp.array[GaitSensor]  # (sensors,)
    span: wp.array[ReflexSpan]  # (muscles,)
    plan: wp.array[StateReflexPlan]  # (terms,)
    row: wp.array2d[StateReflexRow]  # (rows, terms)
    thresholds: wp.array2d[GaitThresholds]  # (rows, 2) of the left and the right leg
    pattern_span: wp.array[ReflexSpan]  # (muscles,)
    pattern: wp.array[GaitPatternPlan]  # (patterns,) none where the scene has none
    knot: wp.array2d[wp.vec2]  # (rows, knots) time, s, and value
    control_step: float  # s
    noise_seed: int
    begins: int  # whether muscles start at the first excitations
    settles: int  # and fibres in equilibrium with them


@wp.struct
class GaitMemory:
    """What instances remember of it."""

    phase: wp.array2d[int]  # (instances, 2) state of the left and the right leg
    began: wp.array2d[int]  # (instances, patterns) control step since which a pattern acts, or NOTHING
    heard: wp.array3d[float]  # (instances, control steps, sensors) a ring, see `activation.delayed_slot`
