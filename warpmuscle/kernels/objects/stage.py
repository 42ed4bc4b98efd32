"""The stage of a step that moves objects: contacts with bodies and ground, those that are held, and all others."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.contact.terrain import FLAT
from warpmuscle.kernels.contact.touching import push
from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.object_structs import BEGUN, FREE, HELD, MOMENT, PUSH, ObjectExtension, ObjectMotion
from warpmuscle.kernels.objects.ground import ground_contacts_of
from warpmuscle.kernels.objects.hinge import turned_on
from warpmuscle.kernels.objects.motion import accelerations, is_held, keep, load_holder, motion_now, moved, vector_in
from warpmuscle.kernels.objects.pair import push_each_other_of
from warpmuscle.kernels.objects.touch import object_touch_of
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


class ObjectsKind(NamedTuple):
    """What a step has compiled in for objects."""

    number: int
    pairs: int = 0  # of objects that push each other
    hinged: bool = False  # whether some turn about an axis alone
    turned: bool = False  # whether the principal axes of some bodies are turned against those of their frames
    terrain: int = FLAT  # see `contact.terrain`
    moves: bool = False  # whether the ground moves along itself, see `contact.belts`


@cache
def move_object_of(kind: ObjectsKind) -> Any:
    """The Warp function that moves one object over a step, and pushes the bodies that touch it."""
    ground_contacts = ground_contacts_of(kind.terrain, kind.moves)
    object_touch, hinged, paired = object_touch_of(kind.turned, kind.hinged), kind.hinged, kind.pairs > 0

    @wp.func
    def move_object(
        instance: int, number: int, model: ModelRef, state: StateRef, work: ScratchRef, own: wp.ref[ObjectExtension]
    ):
        row = at(own.row, instance, number)
        motion = motion_now(instance, number, row, model, state, work, own)
        held = is_held(instance, number, row, model, state, own)
        free = own.fixed[number] == 0
        force = wp.vec3(0.0, -row.mass * at(model.gravity, instance, 0), 0.0)
        moment = wp.vec3(0.0)
        if wp.static(paired):
            force += vector_in(own.memory[instance, number], wp.static(PUSH))
            moment += vector_in(own.memory[instance, number], wp.static(MOMENT))
        if not held:
            for pair in range(own.first_pair[number], own.first_pair[number + 1]):
                body = own.body[pair]
                capsule = at(own.capsule, instance, pair)
                touch = object_touch(instance, body, free, own.hinged[number] == 1, capsule, row, motion, model, work)
                if wp.length_sq(touch.force) > 0.0:
                    push(instance, body, touch.force, touch.body_arm, model, work)
                    force -= touch.force
                    moment -= wp.cross(touch.object_arm, touch.force)
        if free:
            contacts = ground_contacts(instance, state.step[instance], row, motion, model)
            memory = own.memory[instance, number]
            if held:
                load_holder(instance, own.holder[number], row, motion, contacts, model, work)
                keep(memory, motion, wp.static(HELD))
            else:
                h = model.time_step
                kick = wp.where(memory[BEGUN] == 0.0, 0.5 * h, h)
                after = ObjectMotion()
                if wp.static(hinged) and own.hinged[number] == 1:
                    after = turned_on(row, motion, force, moment, contacts, kick, h)
                else:
                    found = accelerations(row, motion.orientation, force, moment, contacts)
                    after = moved(motion, found, row, kick, h)
                slow = wp.length(after.velocity) <= at(model.failure, instance, 0).max_speed
                if not (slow and wp.isfinite(after.momentum)):
                    work.flags[1] = 1
                keep(memory, after, wp.static(FREE))

    return move_object


@cache
def objects_stage_of(forces: tuple[Any, ...]) -> Any:
    """The stage of the objects among all kinds of forces. It ends with a barrier.

    One lane moves them one after the other, since several may push the same body.
    """
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    here = forces[0].objects is not None
    of_kind = move_object_of(forces[0].objects) if here else objects_stage_of(forces[1:])
    count, pairs = (forces[0].objects.number, forces[0].objects.pairs) if here else (0, 0)
    push_each_other = push_each_other_of(pairs)

    @wp.func
    def objects_stage(
        instance: int,
        lane: int,
        lanes: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ):
        if wp.static(here):
            if lane == 0:
                if wp.static(pairs > 0):
                    push_each_other(instance, model, state, work, extensions.first)
                for number in range(count):
                    of_kind(instance, number, model, state, work, extensions.first)
            synchronize()
        else:
            of_kind(instance, lane, lanes, model, state, work, extensions.rest)

    return objects_stage
