"""Numbers of the walking controller, and where its memory keeps what.

All but speeds, angles and times that a command names are relative: lengths to that of the legs L, times to sqrt(L/g),
stiffnesses to m g L and dampings to m g L sqrt(L/g). So the numbers of one body walk on another one.
"""

import warp as wp


@wp.struct
class Walking:
    """Of the whole."""

    speed: float  # m/s, wanted along the heading; 0: to stand
    heading: float  # rad, wanted, to the left of the z axis
    acceleration: float  # m/s^2, by which the speed that is followed changes at most
    turn_rate: float  # rad/s, by which the heading that is followed changes at most
    step_time: float  # sqrt(L/g), of a step at speed 0
    quickening: float  # by which steps are quicker at higher speeds: step_time / (1 + quickening V / sqrt(g L))
    step_height: float  # L, how high a foot is lifted over level ground
    step_width: float  # L, between the feet
    least_width: float  # L, by which a foot is put beside the other one at least
    retreat: float  # 1: how far a foot is put back, so that the pendulum keeps its speed
    tuning: float  # share of the speed that a step lacked that the next one is planned to have more
    speed_gain: float  # m sqrt(g/L), virtual force for each m/s that the speed lacks
    push_off: float  # share of the sole by which the leg that stands pushes off over its toes, at speed sqrt(g L)
    stance_knee: float  # rad, flexion of the leg that stands
    straightens: float  # phase at which the leg that stands is as long as it is to be
    lifts: float  # the same where that lifts the body by a stair
    rise_first: float  # phase at which a foot begins to go forwards that has to rise by a stair
    weight_support: float  # 1: the share of the weight that knees of stance bear beforehand
    lean: float  # rad, of pelvis and trunk, forwards
    toe_up: float  # rad, of the foot at touch-down
    root_kp: float  # m g L
    root_kd: float  # m g L sqrt(L/g)
    turn_kp: float  # m g L, the same about the vertical
    turn_kd: float  # m g L sqrt(L/g)
    sole_use: float  # share of the sole, from the ankle to its ends, that the centre of pressure may go over
    climb: float  # how far a foot is put back for each metre by which its place is higher than the other one's
    sight: float  # 1: feet are put where the ground ahead bears them; 0: it is taken to be level


@wp.struct
class WalkingJoint:
    """Of a joint: PD towards a turn from the reference pose, a vector along its axis as long as its angle."""

    kp: float  # m g L
    kd: float  # m g L sqrt(L/g)
    x: float  # rad, in the parent
    y: float
    z: float
    swing: float  # rad about x for each by which the left thigh is ahead of the right one
    upright: float  # 1: the turn is from the heading, not from the parent


# The memory of an instance; frames hold what stands first.
PHASE, STANCE, SPEED, HEADING = wp.constant(0), wp.constant(1), wp.constant(2), wp.constant(3)
FOOTHOLD = wp.constant(4)  # m, world: where the ankle is to come down; three numbers
CLEARANCE = wp.constant(7)  # m, of the sole that swings
RECORDED = (
    ("phase", "1"),
    ("stance", "1"),
    ("speed_followed", "m/s"),
    ("heading_followed", "rad"),
    ("foothold_x", "m"),
    ("foothold_y", "m"),
    ("foothold_z", "m"),
    ("clearance", "m"),
)
LIFTED = wp.constant(8)  # m, world: where the ankle was when its leg began to swing; three numbers
BEGUN = wp.constant(11)  # 1 once the numbers below are known
LEG, SOLE = wp.constant(12), wp.constant(13)  # m, length of a leg, and of the ankle above the sole
HEEL, TOE, HALF_WIDTH = wp.constant(14), wp.constant(15), wp.constant(16)  # m, of a foot about the ankle
LOAD = wp.constant(17)  # N, on the left and on the right foot, over the last hundredths of a second
KNEE = wp.constant(19)  # rad, of the leg that stands when it came down
TUNED = wp.constant(20)  # m/s, by which more is planned than is wanted, since less comes of it
WAY, SINCE = wp.constant(21), wp.constant(22)  # m and s, since a foot last came down
HASTE = wp.constant(23)  # by which the phase goes on faster, so that a foot comes down where the ground bears it
STATE = 24
# Floats of each body: torque on it, world, N m; mass that it carries outwards, kg, and its moment, kg m; damping of its
# joint about the body's axes, N m s/rad.
OF_BODY = 10
STANDS, LEFT_STANCE, RIGHT_STANCE = wp.constant(2.0), wp.constant(0.0), wp.constant(1.0)
