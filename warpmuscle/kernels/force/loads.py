"""Forces, moments and efforts that are told, world axes, which change at constant rates from a time on."""

import warp as wp

from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class Load:
    """A force at a body's centre of mass, and a moment."""

    since: float  # s, when they are these
    force_x: float  # N
    force_y: float
    force_z: float
    moment_x: float  # N m
    moment_y: float
    moment_z: float
    force_rate_x: float  # N/s
    force_rate_y: float
    force_rate_z: float
    moment_rate_x: float  # N m/s
    moment_rate_y: float
    moment_rate_z: float


@wp.struct
class PointLoad:
    """A force on a body at a point of the world, and a moment, as a force plate measures them."""

    since: float  # s, when they are these
    force_x: float  # N
    force_y: float
    force_z: float
    point_x: float  # m
    point_y: float
    point_z: float
    moment_x: float  # N m, about the point
    moment_y: float
    moment_z: float
    force_rate_x: float  # N/s
    force_rate_y: float
    force_rate_z: float
    point_rate_x: float  # m/s
    point_rate_y: float
    point_rate_z: float
    moment_rate_x: float  # N m/s
    moment_rate_y: float
    moment_rate_z: float


@wp.struct
class JointLoad:
    """Efforts along the speeds of a joint, by their number."""

    effort_0: float  # N m, or N along a slide
    effort_1: float
    effort_2: float


@func
def time_since(instance: int, since: float, model: ModelRef, state: StateRef) -> float:
    """Time from then to the middle of the step, over which a load acts as it is there, s."""
    return (float(state.step[instance]) + 0.5) * model.time_step - since


@func
def load(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, row: Load) -> Wrench:
    """The force and the moment at the body's centre of mass."""
    t = time_since(instance, row.since, model, state)
    w = Wrench()
    w.force = (
        wp.vec3(row.force_x, row.force_y, row.force_z)
        + wp.vec3(row.force_rate_x, row.force_rate_y, row.force_rate_z) * t
    )
    w.moment = (
        wp.vec3(row.moment_x, row.moment_y, row.moment_z)
        + wp.vec3(row.moment_rate_x, row.moment_rate_y, row.moment_rate_z) * t
    )
    return w


@func
def point_load(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, row: PointLoad) -> Wrench:
    """The force at the point as one at the centre of mass, with its moment."""
    t = time_since(instance, row.since, model, state)
    point = (
        wp.vec3(row.point_x, row.point_y, row.point_z)
        + wp.vec3(row.point_rate_x, row.point_rate_y, row.point_rate_z) * t
    )
    center = work.position[body] + work.rotation[body] * at(model.skeleton.row, instance, body).com
    w = Wrench()
    w.force = (
        wp.vec3(row.force_x, row.force_y, row.force_z)
        + wp.vec3(row.force_rate_x, row.force_rate_y, row.force_rate_z) * t
    )
    w.moment = (
        wp.vec3(row.moment_x, row.moment_y, row.moment_z)
        + wp.vec3(row.moment_rate_x, row.moment_rate_y, row.moment_rate_z) * t
        + wp.cross(point - center, w.force)
    )
    return w


@func
def joint_load(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, row: JointLoad) -> wp.vec3:
    """The efforts."""
    return wp.vec3(row.effort_0, row.effort_1, row.effort_2)
