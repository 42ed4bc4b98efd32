"""Device structures of muscle reflexes."""

import warp as wp

CONSTANT, FORCE, LENGTH, VELOCITY, LEAN, LEAN_AT_LIFT, ANGLE, LOAD, OTHER_LOAD = 0, 1, 2, 3, 4, 5, 6, 7, 8  # signals
ALL, POSITIVE, NEGATIVE = 0, 1, 2  # parts of a signal
EITHER, RISING, FALLING = 0, 1, 2  # ways that a signal moves
ALWAYS, STANCE, SWING, TRAILING = 0, 1, 2, 3  # phases of a leg
ONCE, BY_LOAD, BY_OTHER_LOAD = 0, 1, 2  # what a reflex is multiplied by


@wp.struct
class ReflexPlan:
    """What stays the same of a reflex: one term of a muscle's excitation."""

    signal: int  # CONSTANT ... OTHER_LOAD
    source: int  # the muscle, or the body whose joint, that is sensed
    part: int  # ALL, POSITIVE or NEGATIVE
    moving: int  # EITHER, RISING or FALLING: when it acts
    during: int  # ALWAYS, STANCE, SWING or TRAILING
    times: int  # ONCE, BY_LOAD or BY_OTHER_LOAD


@wp.struct
class ReflexRow:
    """Its numbers."""

    gain: float
    offset: float  # of the signal
    lead: float  # s, how far the signal is looked ahead by its rate


@wp.struct
class ReflexSpan:
    """Which reflexes a muscle has."""

    first: int
    end: int  # the one after the last; none if it is the first
    side: int  # LEFT or RIGHT, the leg of the muscle


@wp.struct
class Reflexes:
    """The reflexes of all muscles, one behind the other; only kernels that have them compiled in read them."""

    trunk: int  # the body whose lean is sensed
    span: wp.array[ReflexSpan]  # (muscles,)
    plan: wp.array[ReflexPlan]  # (reflexes,)
    row: wp.array2d[ReflexRow]  # (rows, reflexes)
    bounds: wp.array2d[wp.vec2]  # (rows, 1) load that makes stance, body weights; least excitation
