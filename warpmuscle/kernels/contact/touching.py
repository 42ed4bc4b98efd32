"""Bodies that touch each other: which of them may, and what they do to each other. A lane takes a pair.

Every few steps all pairs are looked at, in between only those that were so near then that they may touch before the
next look. Lanes push their bodies one after the other, in the order of pairs, so that sums do not depend on the number
of lanes. All instances of a warp pass the same barriers, or they would go on one after the other.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import any_lane, synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at, not_unrolled


@wp.struct
class Touch:
    """What two bodies do to each other at one point, world axes."""

    force: wp.vec3  # N, on the second one; its opposite acts on the first
    first_arm: wp.vec3  # m, to that point from the centre of mass of the first
    second_arm: wp.vec3  # m, from that of the second
    near: float  # 1 if they may touch before the next look, else 0


@func
def push(instance: int, body: int, force: wp.vec3, arm: wp.vec3, model: ModelRef, work: ScratchRef):
    """Add a force to the bias forces of a body.

    Args:
        force: N. arm: to where it acts, from the centre of mass, m.
    """
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    work.bias_force[body] = work.bias_force[body] - force
    work.bias_moment[body] = work.bias_moment[body] - wp.cross(arm, force) - wp.cross(c, force)


@func
def begin_looking(step: int, model: ModelRef, work: ScratchRef):
    """Forget, in a step that looks at all pairs, which were near. One lane calls it, before a barrier."""
    if step % model.touch_interval == 0:
        work.near[0] = 0


@cache
def push_each_other_of(touch_between: Any, extension_struct: Any) -> Any:
    """The Warp function that adds to the bias forces of bodies what those of one kind that touch do to each other.

    Args:
        touch_between: see `forces.ForceKind`. extension_struct: type of the kind's extension.
    """

    @wp.func
    def push_each_other(
        instance: int,
        lane: int,
        lanes: int,
        step: int,
        model: ModelRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):
        looks = step % model.touch_interval == 0
        if not any_lane(looks or work.near[0] != 0):
            return
        count = extension.first.shape[0]
        for begin in range(0, count, lanes):
            pair = begin + lane
            touch = Touch()
            if pair < count:  # noqa: SIM102, Warp evaluates both sides of an `and`
                if looks or extension.memory[instance, pair, 0] > 0.0:
                    p = at(extension.parameters, instance, pair)
                    touch = touch_between(instance, extension.first[pair], extension.second[pair], model, work, p)
                    if looks:
                        extension.memory[instance, pair, 0] = touch.near
                        if touch.near > 0.0:
                            work.near[0] = 1
            touches = wp.length_sq(touch.force) > 0.0
            if any_lane(touches):
                for turn in range(lanes):
                    not_unrolled()
                    if turn == lane and touches:
                        push(instance, extension.first[pair], -touch.force, touch.first_arm, model, work)
                        push(instance, extension.second[pair], touch.force, touch.second_arm, model, work)
                    synchronize()

    return push_each_other


@cache
def touching_stage_of(forces: tuple[ForceKind, ...]) -> Any:
    """The stage of those of the forces that act between bodies that touch."""
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    touches = forces[0].touch is not None
    of_kind = push_each_other_of(forces[0].touch, forces[0].extension) if touches else touching_stage_of(forces[1:])

    @wp.func
    def touching_stage(
        instance: int,
        lane: int,
        lanes: int,
        step: int,
        model: ModelRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ):
        if wp.static(touches):
            of_kind(instance, lane, lanes, step, model, work, extensions.first)
        else:
            of_kind(instance, lane, lanes, step, model, work, extensions.rest)

    return touching_stage
