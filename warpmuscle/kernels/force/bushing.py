"""Springs and dampers between frames on two bodies, in all six directions: OpenSim's bushings."""

import warp as wp

from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

LARGEST_SINE = 0.999999  # of the second angle, at whose right angle the other two are no longer told apart


@wp.struct
class Bushing:
    """Where two frames are on their bodies, and what acts between them by angle, rad, and shift, m, of the second one.

    An element such as `fx_y` is the force along x, N, that a shift along y takes, `fx_ty` that a turn about y takes.
    """

    first_x: float  # m, from the centre of mass of the first body
    first_y: float
    first_z: float
    first_turn_x: float  # rad, rotation vector from the frame's axes to those of the body
    first_turn_y: float
    first_turn_z: float
    second_x: float
    second_y: float
    second_z: float
    second_turn_x: float
    second_turn_y: float
    second_turn_z: float
    mx: float  # N m, at rest in the first frame
    my: float
    mz: float
    fx: float  # N
    fy: float
    fz: float
    mx_tx: float  # N m/rad
    mx_ty: float
    mx_tz: float
    mx_x: float  # N
    mx_y: float
    mx_z: float
    my_tx: float
    my_ty: float
    my_tz: float
    my_x: float
    my_y: float
    my_z: float
    mz_tx: float
    mz_ty: float
    mz_tz: float
    mz_x: float
    mz_y: float
    mz_z: float
    fx_tx: float  # N/rad
    fx_ty: float
    fx_tz: float
    fx_x: float  # N/m
    fx_y: float
    fx_z: float
    fy_tx: float
    fy_ty: float
    fy_tz: float
    fy_x: float
    fy_y: float
    fy_z: float
    fz_tx: float
    fz_ty: float
    fz_tz: float
    fz_x: float
    fz_y: float
    fz_z: float
    damping_tx: float  # N m s/rad
    damping_ty: float
    damping_tz: float
    damping_x: float  # N s/m
    damping_y: float
    damping_z: float


@func
def turning(vector: wp.vec3) -> wp.mat33:
    """The rotation matrix of a rotation vector."""
    angle = wp.length(vector)
    if angle < 1.0e-12:
        return wp.identity(n=3, dtype=float)
    return wp.quat_to_matrix(wp.quat_from_axis_angle(vector / angle, angle))


@func
def body_fixed_angles(r: wp.mat33) -> wp.vec3:
    """Angles about x, the new y and the new z axis that a rotation matrix is made of."""
    sine = wp.clamp(r[0, 2], -LARGEST_SINE, LARGEST_SINE)
    return wp.vec3(wp.atan2(-r[1, 2], r[2, 2]), wp.asin(sine), wp.atan2(-r[0, 1], r[0, 0]))


@func
def rates_of_angles(angles: wp.vec3) -> wp.mat33:
    """What takes an angular velocity in the axes before the turns to the rates of these angles."""
    sine = wp.sin(angles[0])
    cosine = wp.cos(angles[0])
    slope = wp.tan(angles[1])
    upright = 1.0 / wp.cos(angles[1])
    return wp.mat33(
        1.0, sine * slope, -cosine * slope,
        0.0, cosine, sine,
        0.0, -sine * upright, cosine * upright,
    )  # fmt: skip


@wp.struct
class BushingFrames:
    """Where both frames are on their bodies."""

    first: wp.vec3  # m, from the centre of mass of the first body
    first_turn: wp.vec3  # rad, rotation vector from the frame's axes to those of the body
    second: wp.vec3
    second_turn: wp.vec3


@wp.struct
class BushingMotion:
    """How the second frame lies and moves in the first one."""

    angles: wp.vec3  # rad, body-fixed
    shift: wp.vec3  # m
    rates: wp.vec3  # rad/s, of the angles
    speed: wp.vec3  # m/s, of the shift
    axes: wp.mat33  # of the first frame, in the world
    to_rates: wp.mat33  # see `rates_of_angles`
    first_arm: wp.vec3  # m, from the centre of mass of each body to the second frame, world
    second_arm: wp.vec3


@func
def bushing_motion(
    instance: int, one: int, two: int, frames: BushingFrames, model: ModelRef, work: ScratchRef
) -> BushingMotion:
    """How the frame on the second body lies and moves in that on the first one."""
    first_center = at(model.skeleton.row, instance, one).com
    second_center = at(model.skeleton.row, instance, two).com
    arm_one = work.rotation[one] * (frames.first + first_center)
    arm_two = work.rotation[two] * (frames.second + second_center)
    m = BushingMotion()
    m.axes = work.rotation[one] * turning(frames.first_turn)
    from_world = wp.transpose(m.axes)
    apart = work.position[two] - work.position[one] + arm_two - arm_one
    m.angles = body_fixed_angles(from_world * work.rotation[two] * turning(frames.second_turn))
    m.shift = from_world * apart
    spin = work.angular_velocity[two] - work.angular_velocity[one]
    moving = work.velocity[two] + wp.cross(work.angular_velocity[two], arm_two) - work.velocity[one]
    moving -= wp.cross(work.angular_velocity[one], arm_one + apart)
    m.to_rates = rates_of_angles(m.angles)
    m.rates = m.to_rates * (from_world * spin)
    m.speed = from_world * moving
    m.first_arm = arm_one + apart - work.rotation[one] * first_center
    m.second_arm = arm_two - work.rotation[two] * second_center
    return m


@func
def bushing_wrench(about: wp.vec3, along: wp.vec3, second: int, m: BushingMotion) -> Wrench:
    """What acts on one of both bodies, where the angles and shifts take the generalised force -(about, along).

    Its work is that of a moment N^T f on the second body, N as in `rates_of_angles` (OpenSim's TwoFrameLinker).
    """
    force = -(m.axes * along)
    moment = -(m.axes * (wp.transpose(m.to_rates) * about))
    w = Wrench()
    if second == 1:
        w.force = force
        w.moment = moment + wp.cross(m.second_arm, force)
    else:
        w.force = -force
        w.moment = -moment - wp.cross(m.first_arm, force)
    return w


@func
def bushing(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    given: Bushing,
) -> Wrench:  # fmt: skip
    """What a bushing does to one of its bodies, of which `second` says whether it is the second one.

    The angles and shifts q of the second frame in the first one take the generalised force -(f0 + K q + D q').
    """
    frames = BushingFrames()
    frames.first = wp.vec3(given.first_x, given.first_y, given.first_z)
    frames.first_turn = wp.vec3(given.first_turn_x, given.first_turn_y, given.first_turn_z)
    frames.second = wp.vec3(given.second_x, given.second_y, given.second_z)
    frames.second_turn = wp.vec3(given.second_turn_x, given.second_turn_y, given.second_turn_z)
    one = wp.where(second == 1, other, body)
    two = wp.where(second == 1, body, other)
    m = bushing_motion(instance, one, two, frames, model, work)
    mt = wp.mat33(given.mx_tx, given.mx_ty, given.mx_tz, given.my_tx, given.my_ty, given.my_tz,
                  given.mz_tx, given.mz_ty, given.mz_tz)  # fmt: skip
    ms = wp.mat33(given.mx_x, given.mx_y, given.mx_z, given.my_x, given.my_y, given.my_z,
                  given.mz_x, given.mz_y, given.mz_z)  # fmt: skip
    ft = wp.mat33(given.fx_tx, given.fx_ty, given.fx_tz, given.fy_tx, given.fy_ty, given.fy_tz,
                  given.fz_tx, given.fz_ty, given.fz_tz)  # fmt: skip
    fs = wp.mat33(given.fx_x, given.fx_y, given.fx_z, given.fy_x, given.fy_y, given.fy_z,
                  given.fz_x, given.fz_y, given.fz_z)  # fmt: skip
    damping = wp.vec3(given.damping_tx, given.damping_ty, given.damping_tz)
    resistance = wp.vec3(given.damping_x, given.damping_y, given.damping_z)
    about = wp.vec3(given.mx, given.my, given.mz) + mt * m.angles + ms * m.shift + wp.cw_mul(damping, m.rates)
    along = wp.vec3(given.fx, given.fy, given.fz) + ft * m.angles + fs * m.shift + wp.cw_mul(resistance, m.speed)
    return bushing_wrench(about, along, second, m)
