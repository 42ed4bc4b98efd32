"""What springs, bushings, limits and other devices of a model do in given frames, besides its muscles.

A state is a frame here. Devices that have a state of their own, or ask for a gait cycle, are for simulations alone.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.force.extensions import extension_list, of_body
from warpmuscle.kernels.force.forces import ForceKind, Wrench, wrench_of
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.stages import kinematics_stage, work_of
from warpmuscle.kernels.structs import Model, ModelRef, ScratchRef, State, StateRef, at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@func
def no_efforts(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, extensions: int,
    effort: wp.array2d[float],
):  # fmt: skip
    """What is added behind the last kind."""


@cache
def add_efforts_of(forces: tuple[ForceKind, ...]) -> Any:
    """The Warp function (instance, body, model, state, work, extensions, effort) that adds devices on a body's joint.

    `effort` (instances, speeds) gets generalised forces, N and N m.
    """
    if not forces:
        return no_efforts
    kind, others = forces[0], add_efforts_of(forces[1:])
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    acts = kind.effort is not None
    acting = of_body(kind.effort, wp.vec3, kind.parameters, kind.extension) if acts else no_efforts
    last = len(forces) == 1

    @wp.func
    def add_efforts(
        instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef,
        extensions: wp.ref[extensions_struct], effort: wp.array2d[float],
    ):  # fmt: skip
        if wp.static(acts):
            first = model.skeleton.plan[body].speed_start
            for entry in range(extensions.first.start[body], extensions.first.start[body + 1]):
                given = acting(instance, body, entry, model, state, work, extensions.first)
                for k in range(model.skeleton.plan[body].speed_end - first):
                    effort[instance, first + k] = effort[instance, first + k] + given[k]
        if wp.static(not last):
            others(instance, body, model, state, work, extensions.rest, effort)

    return add_efforts


@cache
def model_forces_of(forces: tuple[ForceKind, ...]) -> Any:
    """The kernel (model, state, workspace, extensions, effort, force, point, moment) of all devices of a model.

    What it gives:
        effort: (frames, speeds) N and N m, along the speeds of joints.
        force, point, moment: (frames, bodies) N at a body's centre of mass, that, m, and N m about it; world axes.
    """
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    add_efforts, wrench_on = add_efforts_of(forces), wrench_of(forces)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float], extensions: extensions_struct,
        # out
        effort: wp.array2d[float], force: wp.array2d[wp.vec3], point: wp.array2d[wp.vec3], moment: wp.array2d[wp.vec3],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        own = extensions
        kinematics_stage(i, 0, 1, model, state, work)
        for s in range(effort.shape[1]):
            effort[i, s] = 0.0
        for body in range(model.body_count):
            if body > 0:
                add_efforts(i, body, model, state, work, own, effort)
            wrench = Wrench()
            wrench = wrench_on(i, body, wrench, model, state, work, own)
            force[i, body] = wrench.force
            point[i, body] = work.position[body] + work.rotation[body] * at(model.skeleton.row, i, body).com
            moment[i, body] = wrench.moment

    return kernel
