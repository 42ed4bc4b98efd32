"""The stage of a step that lets water act on bodies."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at
from warpmuscle.kernels.water.section import in_water
from warpmuscle.kernels.water_structs import WaterExtension


@func
def wet(instance: int, body: int, model: ModelRef, work: ScratchRef, own: wp.ref[WaterExtension]):
    """Add water's force on a body to its bias force, and what it moves along to its articulated inertia."""
    gravity = at(model.gravity, instance, 0)
    for part in range(own.start[body], own.start[body + 1]):
        row = at(own.row, instance, part)
        height = work.position[body][1] + (work.rotation[body] * row.middle)[1]
        if height - row.reach < row.level:
            total = in_water(body, row, gravity, model.time_step, work)
            work.block_a[body] = work.block_a[body] + total.a
            work.block_b[body] = work.block_b[body] + total.b
            work.block_c[body] = work.block_c[body] + total.c
            work.bias_moment[body] = work.bias_moment[body] - total.moment
            work.bias_force[body] = work.bias_force[body] - total.force


@cache
def water_stage_of(forces: tuple[Any, ...]) -> Any:
    """The stage of the water among all kinds of forces. It ends with a barrier."""
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    here = forces[0].water
    of_kind = wet if here else water_stage_of(forces[1:])

    @wp.func
    def water_stage(
        instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef, extensions: wp.ref[extensions_struct]
    ):
        if wp.static(here):
            for body in range(lane, model.body_count, lanes):
                of_kind(instance, body, model, work, extensions.first)
            synchronize()
        else:
            of_kind(instance, lane, lanes, model, work, extensions.rest)

    return water_stage
