"""What the walking controller asks of a body: its legs, how large it is, and how high the ground lies."""

import warp as wp

from warpmuscle.kernels.contact.terrain import rise_at
from warpmuscle.kernels.control.walking.parameters import HALF_WIDTH, HEEL, LEG, OF_BODY, SOLE, STATE, TOE
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import LEFT, ModelRef, ScratchRef, at


@wp.struct
class Leg:
    """Bodies of a leg."""

    thigh: int
    shank: int
    foot: int


@func
def leg_of(side: int, model: ModelRef) -> Leg:
    """The bodies of a leg, from the foot inwards."""
    leg = Leg()
    leg.foot = wp.where(side == LEFT, model.feet.left, model.feet.right)
    leg.shank = model.skeleton.plan[leg.foot].parent
    leg.thigh = model.skeleton.plan[leg.shank].parent
    return leg


@func
def outwards(side: int) -> float:
    """Sign along x of what is to the outer side of a leg."""
    return wp.where(side == LEFT, 1.0, -1.0)


@func
def measure_points(instance: int, body: int, origin: wp.vec3, model: ModelRef, memory: wp.array[float]):
    """Let the sole reach to all points of contact of a body whose joint lies there from the ankle, reference pose."""
    for k in range(model.skeleton.plan[body].first_point, model.skeleton.plan[body].end_point):
        point = at(model.contacts.point, instance, k)
        place = origin + point.place
        memory[SOLE] = wp.max(memory[SOLE], point.radius - place[1])
        memory[HEEL] = wp.min(memory[HEEL], place[2] - point.radius)
        memory[TOE] = wp.max(memory[TOE], place[2] + point.radius)
        memory[HALF_WIDTH] = wp.max(memory[HALF_WIDTH], wp.abs(place[0]) + point.radius)


@func
def measure(instance: int, model: ModelRef, memory: wp.array[float]):
    """Lengths of leg and foot, of the left ones, into the memory."""
    leg = leg_of(LEFT, model)
    plan = model.skeleton.plan[leg.foot]
    measure_points(instance, leg.foot, wp.vec3(0.0), model, memory)
    for child in range(plan.first_child, plan.first_child + plan.child_count):
        measure_points(instance, child, at(model.skeleton.row, instance, child).anchor, model, memory)
    thigh = wp.length(at(model.skeleton.row, instance, leg.shank).anchor)
    shank = wp.length(at(model.skeleton.row, instance, leg.foot).anchor)
    memory[LEG] = thigh + shank + memory[SOLE]


@func
def ground_height(instance: int, x: float, z: float, model: ModelRef) -> float:
    """Height of the ground at a place of the world, m."""
    normal = at(model.contacts.normal, instance, 0)
    plane = (at(model.contacts.height, instance, 0) - normal[0] * x - normal[2] * z) / normal[1]
    if model.contacts.terrain.tile.shape[0] > 0:
        rise = rise_at(instance, x, z, model)
        plane += rise[0]
    return plane


@func
def carried_moment(body: int, memory: wp.array[float]) -> wp.vec3:
    """Mass times centre of mass, kg m, of a body and all that it carries outwards."""
    k = STATE + OF_BODY * body
    return wp.vec3(memory[k + 4], memory[k + 5], memory[k + 6])


@func
def carried_mass(body: int, memory: wp.array[float]) -> float:
    """Mass of these, kg."""
    return memory[STATE + OF_BODY * body + 3]


@func
def carry(instance: int, model: ModelRef, work: ScratchRef, memory: wp.array[float]):
    """Masses and moments of all that each body carries outwards; no torque or damping yet."""
    for body in range(model.body_count):
        row = at(model.skeleton.row, instance, body)
        moment = (work.position[body] + work.rotation[body] * row.com) * row.mass
        k = STATE + OF_BODY * body
        for axis in range(3):
            memory[k + axis] = 0.0
            memory[k + 4 + axis] = moment[axis]
            memory[k + 7 + axis] = 0.0
        memory[k + 3] = row.mass
    for i in range(model.body_count - 1):
        body = model.body_count - 1 - i
        to = STATE + OF_BODY * model.skeleton.plan[body].parent
        for n in range(3, 7):
            memory[to + n] = memory[to + n] + memory[STATE + OF_BODY * body + n]


@func
def torque_on(body: int, memory: wp.array[float]) -> wp.vec3:
    """Torque of its joint on a body, world, N m."""
    k = STATE + OF_BODY * body
    return wp.vec3(memory[k], memory[k + 1], memory[k + 2])


@func
def add_torque(body: int, torque: wp.vec3, memory: wp.array[float]):
    """Add to it."""
    k = STATE + OF_BODY * body
    for axis in range(3):
        memory[k + axis] = memory[k + axis] + torque[axis]


@func
def damping_of(body: int, memory: wp.array[float]) -> wp.vec3:
    """Damping of its joint about the axes of a body, N m s/rad."""
    k = STATE + OF_BODY * body + 7
    return wp.vec3(memory[k], memory[k + 1], memory[k + 2])


@func
def add_damping(body: int, damping: wp.vec3, memory: wp.array[float]):
    """Add to it."""
    k = STATE + OF_BODY * body + 7
    for axis in range(3):
        memory[k + axis] = memory[k + axis] + damping[axis]
