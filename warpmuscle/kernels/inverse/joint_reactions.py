"""What joints put on a body beyond muscles and loads, at a frame on the body and in the axes of a chosen one."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.struct
class ReactionJoint:
    """A joint, the body that it is asked to act on, and the axes that are asked for."""

    body: int  # whose joint it is
    sign: float  # 1: what acts on that body; -1: on its parent
    acting: int  # the body that it acts on; -1: the ground
    place: wp.vec3  # m, of the joint's frame there, from the body's joint in its axes, or from the ground's origin
    shown: int  # the body whose axes are meant; -1: the ground
    origin: wp.vec3  # m, of that body's centre of mass from its joint
    turn: wp.mat33  # from the axes of the body, or the ground, to those of OpenSim
    center: wp.vec3  # m, of that body's centre of mass in OpenSim's body


@wp.struct
class JointWrenches:
    """What every joint puts on its child, world axes, and where bodies are."""

    moment: wp.array2d[wp.vec3]  # (frames, bodies) N m, about the joint of the body
    force: wp.array2d[wp.vec3]  # (frames, bodies) N
    pulled_moment: wp.array2d[wp.vec3]  # the part of it that muscles make; empty: none does
    pulled_force: wp.array2d[wp.vec3]
    position: wp.array2d[wp.vec3]  # (frames, bodies) m, of the joint
    orientation: wp.array2d[wp.quat]  # (frames, bodies) of the body


@wp.func
def place_on(frame: int, body: int, point: wp.vec3, wrenches: JointWrenches) -> wp.vec3:
    """World place of a point of a body, m; the point itself on the ground, which is -1."""
    place = point
    if body >= 0:
        place = wrenches.position[frame, body] + wp.quat_rotate(wrenches.orientation[frame, body], point)
    return place


@wp.func
def shown_as(frame: int, joint: ReactionJoint, vector: wp.vec3, wrenches: JointWrenches) -> wp.vec3:
    """A world vector in the axes that are asked for."""
    own = vector
    if joint.shown >= 0:
        own = wp.quat_rotate_inv(wrenches.orientation[frame, joint.shown], vector)
    return joint.turn * own


@wp.kernel
def joint_reactions(
    # in
    joints: wp.array[ReactionJoint], wrenches: JointWrenches,
    # out
    force: wp.array2d[wp.vec3], moment: wp.array2d[wp.vec3], point: wp.array2d[wp.vec3],
):  # fmt: skip
    """Force (frames, joints), N, moment about the joint's frame, N m, and where that is, m, in the axes asked for."""
    frame, k = wp.tid()
    joint = joints[k]
    carried = wrenches.force[frame, joint.body]
    turning = wrenches.moment[frame, joint.body]
    if wrenches.pulled_force.shape[0] > 0:
        carried -= wrenches.pulled_force[frame, joint.body]
        turning -= wrenches.pulled_moment[frame, joint.body]
    at = place_on(frame, joint.acting, joint.place, wrenches)
    turning += wp.cross(wrenches.position[frame, joint.body] - at, carried)
    origin = wp.vec3(0.0)
    if joint.shown >= 0:
        origin = place_on(frame, joint.shown, joint.origin, wrenches)
    force[frame, k] = shown_as(frame, joint, joint.sign * carried, wrenches)
    moment[frame, k] = shown_as(frame, joint, joint.sign * turning, wrenches)
    point[frame, k] = shown_as(frame, joint, at - origin, wrenches) + joint.center
