"""The kernel that finds the paths of all muscles before a step, one muscle of one instance a thread, and what it needs.

A step in which few instances share a multiprocessor's memory leaves paths round surfaces little of its first cache and
few warps that hide how long they wait. Here all of that cache is theirs, and neighbours in a block, and the blocks that
run at the same time, follow the same muscle: they fetch the same code and the same numbers of the model.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_velocities, put_groups
from warpmuscle.kernels.body.joint_stages import joint_stages_of
from warpmuscle.kernels.functions import CPU_FLAGS, build_options
from warpmuscle.kernels.known_kernels import known_kernel
from warpmuscle.kernels.memory.compiler_hints import known_rows_of
from warpmuscle.kernels.memory.register_rows import NEAR_NUMBERS, NEAR_THREADS
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_pipeline import stretch_stage_of
from warpmuscle.kernels.path.path import joint_velocities
from warpmuscle.kernels.step_parts import StepKind
from warpmuscle.kernels.structs import (
    RUNNING,
    Model,
    ModelRef,
    RecordRef,
    Scratch,
    ScratchRef,
    State,
    StateRef,
    nonnegative,
    not_unrolled,
)

PATH_BLOCK = NEAR_THREADS  # threads on a GPU
PATH_REGISTERS = 168  # of a thread: three blocks of a multiprocessor

OTHERS = "actuation.effort", "muscles.knot_value"  # which others give with any strides
know_model = known_rows_of(Model, OTHERS, pairs=("muscles.curve_table",))


NEAR_ROWS = True  # whether threads of a GPU have points and bends of a route in shared memory


def with_near_rows(kind: MuscleKind) -> MuscleKind:
    """The kind with points and bends of its routes in the shared memory of a block, if there is room for them."""
    routes = kind.paths.routes
    if routes is None or not routes.in_rounds or routes.numbers > NEAR_NUMBERS:
        return kind
    return kind._replace(paths=kind.paths._replace(routes=routes._replace(near=True)))


@cache
def paths_kernel(kind: MuscleKind, across: bool) -> Any:
    """The kernel of muscles of a kind: launch with dim=(muscles, running instances or some more).

    Args:
        across: whether numbers of neighbouring instances lie side by side in the state, as on a GPU.
    """
    own = with_near_rows(kind) if across and NEAR_ROWS else kind
    stretch_stage, know_state = stretch_stage_of(own), known_rows_of(State, side_by_side=across)
    options = {"enable_backward": False, "max_unroll": 1, **build_options()}
    options |= {"fast_math": True, "cpu_compiler_flags": CPU_FLAGS, "block_dim": PATH_BLOCK if across else 1}

    @known_kernel(
        kind, across, enable_backward=False, cuda_max_registers=PATH_REGISTERS, module_options=options,
        grid_stride=False if across else None,
    )  # fmt: skip
    def find_paths(running: wp.array[int], model: Model, state: State):
        place, i = wp.tid()
        if i >= running.shape[0]:
            return
        instance = nonnegative(running[i])
        if state.status[instance] != RUNNING:
            return
        character = model
        changing = state
        know_model(character)
        know_state(changing)
        m = nonnegative(model.routes.order[place])
        work = Scratch()
        work.rotation = changing.muscles.apart.rotation[instance]
        work.position = changing.muscles.apart.position[instance]
        work.angular_velocity = changing.muscles.apart.angular_velocity[instance]
        work.lag_angular = changing.muscles.apart.lag_angular[instance]
        work.joint_velocity = changing.muscles.apart.joint_velocity[instance]
        work.torque = changing.muscles.apart.joint_velocity[instance]  # what joints want is found later
        work.coordinate_turning = changing.muscles.apart.coordinate_turning[instance]
        work.coordinate_moving = changing.muscles.apart.coordinate_moving[instance]
        stretch = stretch_stage(instance, m, character, changing, work, changing.muscles.moment_arm[instance])
        changing.muscles.apart.stretch[instance, m] = wp.vec2(stretch.moving, stretch.speed)

    return find_paths


@cache
def places_for_paths_of(kind: StepKind) -> Any:
    """The Warp function that places the bodies and leaves what the kernel needs to know that finds paths.

    It is called as the one that makes a step, see `step.one_step_of`.
    """
    kinematics_stage = joint_stages_of(kind.skeleton, kind.several_warps).kinematics
    coordinates, extensions_struct = kind.skeleton.with_coordinates, kind.extensions
    coordinate_speeds = coordinate_velocities if coordinates else None
    grouped = kind.muscles is not None and kind.muscles.paths.groups > 0
    join = put_groups if grouped else None

    @wp.func(inline=True)
    def places_for_paths(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> int:  # fmt: skip
        kinematics_stage(instance, lane, lanes, model, state, work)
        synchronize()
        if wp.static(grouped):
            join(instance, lane, lanes, model, state, work)
        joint_velocities(lane, lanes, model, work)
        if wp.static(coordinates):
            coordinate_speeds(instance, lane, lanes, model, work)
        for body in range(lane, model.body_count, lanes):
            not_unrolled()
            state.muscles.apart.rotation[instance, body] = work.rotation[body]
            state.muscles.apart.position[instance, body] = work.position[body]
            state.muscles.apart.angular_velocity[instance, body] = work.angular_velocity[body]
            state.muscles.apart.lag_angular[instance, body] = work.lag_angular[body]
            state.muscles.apart.joint_velocity[instance, body] = work.joint_velocity[body]
            if wp.static(coordinates):
                state.muscles.apart.coordinate_turning[instance, body] = work.coordinate_turning[body]
                state.muscles.apart.coordinate_moving[instance, body] = work.coordinate_moving[body]
        return RUNNING

    return places_for_paths
