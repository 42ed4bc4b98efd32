"""Parts of a task of a scene's own: their values at a decision, for all instances, with a working set of poses.

A function is called where poses and velocities are known, for one instance. Of observations, rewards, ends and
curricula it takes (instance, model, state, work [, decision]); of goals and starts (instance, model, state, work,
decision, random), where `random` begins a sequence of numbers for `wp.randf`; then its parameters and memory, if any.
"""

from functools import cache
from typing import Any, Literal, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.random_numbers import BOX, CUSTOM_START, GOAL, random_of
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.learning.episodes import Episodes
from warpmuscle.kernels.objective.parts import Plug, of_instance, reader_of
from warpmuscle.kernels.stages import kinematics_stage, work_of
from warpmuscle.kernels.structs import Model, ModelRef, ScratchRef, State, StateRef

wp.set_module_options({"enable_backward": False})

GREATEST = 1.0e30  # of a value; one beyond it, or none, counts as 0

Base = Literal["instance", "decision", "draw"]


class DecisionPlug(NamedTuple):
    """A part of a task as it is compiled in."""

    plug: Plug
    base: Base  # what it takes besides what is its own
    result: Any  # float, bool or wp.vec3; None of one that writes to the state

    @property
    def width(self) -> int:
        """Numbers of a value."""
        return 3 if self.result is wp.vec3 else 1


@cache
def called_of(part: DecisionPlug) -> Any:
    """The Warp function (instance, model, state, work, decision, random) -> result of a part."""
    function, parameters, remembers, row = (
        part.plug.function, part.plug.parameters, part.plug.memory, part.plug.first_row,
    )  # fmt: skip
    result, given, draws = part.result, parameters is not None, part.base == "draw"
    struct, read = (parameters, reader_of(parameters, part.plug.first_value)) if given else (Decision, of_instance)
    if part.base == "instance":
        plain = of_instance(part.plug, result)

        @wp.func
        def of_body(
            instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32
        ) -> result:
            return plain(instance, model, state, work)

        return of_body

    @wp.func
    def of_decision(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32
    ) -> result:
        if wp.static(given):
            values = struct()
            read(values, instance, 0, model)
            if wp.static(remembers):
                memory = state.part_memory[instance, wp.static(row)]
                return function(instance, model, state, work, decision, values, memory)
            else:
                return function(instance, model, state, work, decision, values)
        elif wp.static(remembers):
            return function(instance, model, state, work, decision, state.part_memory[instance, wp.static(row)])
        else:
            return function(instance, model, state, work, decision)

    @wp.func
    def of_draw(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32
    ) -> result:
        if wp.static(given):
            values = struct()
            read(values, instance, 0, model)
            if wp.static(remembers):
                memory = state.part_memory[instance, wp.static(row)]
                return function(instance, model, state, work, decision, random, values, memory)
            else:
                return function(instance, model, state, work, decision, random, values)
        elif wp.static(remembers):
            return function(instance, model, state, work, decision, random, state.part_memory[instance, wp.static(row)])
        else:
            return function(instance, model, state, work, decision, random)

    @wp.func
    def of_start(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32
    ):
        if wp.static(given):
            values = struct()
            read(values, instance, 0, model)
            if wp.static(remembers):
                memory = state.part_memory[instance, wp.static(row)]
                function(instance, model, state, work, decision, random, values, memory)
            else:
                function(instance, model, state, work, decision, random, values)
        elif wp.static(remembers):
            function(instance, model, state, work, decision, random, state.part_memory[instance, wp.static(row)])
        else:
            function(instance, model, state, work, decision, random)

    if part.result is None:
        return of_start
    return of_draw if draws else of_decision


@wp.func
def sound(value: float) -> float:
    """A value, or 0 for one that is none or beyond all bounds."""
    if wp.abs(value) < GREATEST:
        return value
    return 0.0


@wp.func
def no_value(
    instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32,
    values: wp.array2d[float],
):  # fmt: skip
    """No part has a value."""


def _and_value(others: Any, part: DecisionPlug, column: int) -> Any:
    call, result = called_of(part), part.result
    vector, truth, silent = result is wp.vec3, result is bool, result is None

    @wp.func
    def put(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, decision: Decision, random: wp.uint32,
        values: wp.array2d[float],
    ):  # fmt: skip
        others(instance, model, state, work, decision, random, values)
        own = wp.rand_init(wp.int32(random), wp.static(column))  # no two parts draw the same
        if wp.static(silent):
            call(instance, model, state, work, decision, own)
        elif wp.static(vector):
            point = call(instance, model, state, work, decision, own)
            for k in range(3):
                values[instance, wp.static(column) + k] = sound(point[k])
        elif wp.static(truth):
            values[instance, wp.static(column)] = wp.where(call(instance, model, state, work, decision, own), 1.0, 0.0)
        else:
            values[instance, wp.static(column)] = sound(call(instance, model, state, work, decision, own))

    return put


@cache
def evaluation_of(parts: tuple[DecisionPlug, ...], columns: tuple[int, ...], masked: bool = False) -> Any:
    """The kernel that puts values of parts into columns of an array (instances, numbers). Launch with dim = instances.

    Args:
        masked: only where an episode begins.
    """
    every = no_value
    for part, column in zip(parts, columns, strict=True):
        every = _and_value(every, part, column)
    stream = CUSTOM_START if any(part.result is None for part in parts) else GOAL

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def evaluate(
        # in
        model: Model, episodes: Episodes, decision: Decision, workspace: wp.array2d[float],
        # in and out
        state: State,
        # out
        values: wp.array2d[float],
    ):  # fmt: skip
        i = wp.tid()
        if wp.static(masked):  # noqa: SIM102
            if not episodes.mask[i]:
                return
        character = model
        changing = state
        work = work_of(i, character, workspace)
        kinematics_stage(i, 0, 1, character, changing, work)
        random = random_of(episodes.seed[0], i, episodes.decision[i] + episodes.number[i], wp.static(stream))
        every(i, character, changing, work, decision, random, values)

    return evaluate


@wp.kernel
def draw_in_boxes(
    # in
    episodes: Episodes, low: wp.array[float], high: wp.array[float], column: wp.array[int],
    # out
    goal: wp.array2d[float],
):  # fmt: skip
    """Draw numbers of goals evenly between bounds, where an episode begins. Launch with dim = instances."""
    i = wp.tid()
    if not episodes.mask[i]:
        return
    random = random_of(episodes.seed[0], i, episodes.decision[i] + episodes.number[i], BOX)
    for k in range(low.shape[0]):
        goal[i, column[k]] = wp.lerp(low[k], high[k], wp.randf(random))


@wp.kernel
def clamp_difficulty(
    # in
    episodes: Episodes, value: wp.array2d[float],
    # out
    difficulty: wp.array[float],
):  # fmt: skip
    """Take the difficulty of the next episode over, where one begins. Launch with dim = instances."""
    i = wp.tid()
    if episodes.mask[i]:
        difficulty[i] = wp.clamp(value[i, 0], 0.0, 1.0)


@wp.struct
class AddedTerms:
    """Terms of the objective whose sums are rewards, and what they were at the decision before."""

    part: wp.array[int]  # (rewards,) OF_MUSCLES, OF_BODIES or OF_INSTANCE
    index: wp.array[int]  # (rewards,) of the term among those of its part
    before: wp.array2d[wp.float64]  # (instances, rewards)


OF_MUSCLES, OF_BODIES, OF_INSTANCE = 0, 1, 2


@wp.kernel
def added_terms(
    # in
    added: AddedTerms, state: State, time_step: float,
    # out
    values: wp.array2d[float],
):  # fmt: skip
    """What a decision has added to terms, over time, into the first columns. Launch with dim = (instances, rewards)."""
    i, k = wp.tid()
    total = wp.float64(0.0)
    index = added.index[k]
    if added.part[k] == OF_MUSCLES:
        for m in range(state.muscle_terms.shape[2]):
            total += state.muscle_terms[i, index, m]
    elif added.part[k] == OF_BODIES:
        for body in range(state.body_terms.shape[2]):
            total += state.body_terms[i, index, body]
    else:
        total = state.instance_terms[i, index]
    values[i, k] = sound(float(total - added.before[i, k]) * time_step)
    added.before[i, k] = total


@wp.kernel
def forget_terms(
    # in
    mask: wp.array[bool],
    # out
    before: wp.array2d[wp.float64],
):  # fmt: skip
    """Begin to count anew with an episode. Launch with dim = (instances, rewards)."""
    i, k = wp.tid()
    if mask[i]:
        before[i, k] = wp.float64(0.0)
