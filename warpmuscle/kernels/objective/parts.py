"""Parts of a scene's own as plain functions: each finds its parameters in the model and its memory in the state.

What a part is says its `declaration.Declaration`. All parameters of a scene's parts lie side by side in
`Model.part_values`, all memories in rows of `State.part_memory`; where those of a part begin is compiled in.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


class Plug(NamedTuple):
    """A part as it is compiled in."""

    function: Any
    parameters: Any = None  # a structure of floats
    memory: bool = False  # whether the function takes one
    first_value: int = 0  # of its parameters; those of each muscle or body are one behind the other
    first_row: int = 0  # of its memories, a row each

    @property
    def plain(self) -> bool:
        """Whether the function needs nothing of its own."""
        return self.parameters is None and not self.memory


@cache
def reader_of(parameters: Any, first: int) -> Any:
    """The Warp function (values, instance, entry, model) that reads the parameters of one muscle, body or instance."""
    count = len(parameters.vars)
    lines = ["int row = instance < model.part_values.shape[0] ? instance : model.part_values.shape[0] - 1;"]
    lines += [
        f"values.{name} = *wp::address(model.part_values, row, {first + k} + {count} * entry);"
        for k, name in enumerate(parameters.vars)
    ]

    @wp.func_native(snippet="\n".join(lines))
    def read(values: wp.ref[parameters], instance: int, entry: int, model: ModelRef): ...

    return read


@cache
def of_instance(plug: Plug, result: Any) -> Any:
    """The Warp function (instance, model, state, work) -> result of a part of the whole instance."""
    if plug.plain:
        return plug.function
    function, parameters, remembers, row = plug.function, plug.parameters, plug.memory, plug.first_row
    given = parameters is not None
    struct, read = (parameters, reader_of(parameters, plug.first_value)) if given else (MuscleWork, of_instance)

    @wp.func
    def call(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> result:
        if wp.static(given):
            values = struct()
            read(values, instance, 0, model)
            if wp.static(remembers):
                return function(instance, model, state, work, values, state.part_memory[instance, wp.static(row)])
            else:
                return function(instance, model, state, work, values)
        else:
            return function(instance, model, state, work, state.part_memory[instance, wp.static(row)])

    return call


@cache
def of_body(plug: Plug) -> Any:
    """The Warp function (instance, body, model, state, work) -> float of a part of each joint."""
    if plug.plain:
        return plug.function
    function, parameters, remembers, row = plug.function, plug.parameters, plug.memory, plug.first_row
    given = parameters is not None
    struct, read = (parameters, reader_of(parameters, plug.first_value)) if given else (MuscleWork, of_instance)

    @wp.func
    def call(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
        if wp.static(given):
            values = struct()
            read(values, instance, body, model)
            if wp.static(remembers):
                memory = state.part_memory[instance, wp.static(row) + body]
                return function(instance, body, model, state, work, values, memory)
            else:
                return function(instance, body, model, state, work, values)
        else:
            return function(instance, body, model, state, work, state.part_memory[instance, wp.static(row) + body])

    return call


@cache
def of_muscle(plug: Plug) -> Any:
    """The Warp function (instance, muscle, what it does, model, state) -> float of a part of each muscle.

    Of one that needs nothing of its own it is that itself, which does not take the state.
    """
    if plug.plain:
        return plug.function
    function, parameters, remembers, row = plug.function, plug.parameters, plug.memory, plug.first_row
    given = parameters is not None
    struct, read = (parameters, reader_of(parameters, plug.first_value)) if given else (MuscleWork, of_instance)

    @wp.func
    def call(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef) -> float:
        if wp.static(given):
            values = struct()
            read(values, instance, m, model)
            if wp.static(remembers):
                return function(instance, m, w, model, values, state.part_memory[instance, wp.static(row) + m])
            else:
                return function(instance, m, w, model, values)
        else:
            return function(instance, m, w, model, state.part_memory[instance, wp.static(row) + m])

    return call
