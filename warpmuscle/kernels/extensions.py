"""Parameters and state that controllers and forces bring along, as the last argument of the fused kernel.

The controller, and every kind of force, has one `Extension` there, with an entry for each thing of its kind in a scene.
The functions that are compiled in take parameters and state of their entry as their last arguments, where they
want them.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class NoParameters:
    """Those of what has none."""

    unused: float


@wp.struct
class NoExtensions:
    """Where nothing has any; and the end of a list."""

    unused: int


@cache
def extension_type(parameters: Any = None, memory: int = 0, of_bodies: bool = False, pairs: bool = False) -> Any:
    """The structure of the entries of one kind, whose parameters are of this structure of floats.

    Args:
        memory: floats of the state of an entry. of_bodies: whether entries belong to bodies, of which each has its own.
        pairs: whether each entry of a body has another body.
    """
    if parameters is None and memory == 0 and not of_bodies:
        return NoExtensions
    struct = NoParameters if parameters is None else parameters
    if pairs:

        @wp.struct
        class PairExtension:
            parameters: wp.array2d[struct]  # (rows, entries)
            start: wp.array[int]  # (bodies + 1,) first entry of each body
            other: wp.array[int]  # (entries,) the other body
            second: wp.array[int]  # (entries,) 1 if the body is the second of both

        return PairExtension

    @wp.struct
    class Extension:
        parameters: wp.array2d[struct]  # (rows, entries)
        memory: wp.array3d[float]  # (instances, entries, floats)
        start: wp.array[int]  # (bodies + 1,) first entry of each body, if they belong to bodies

    return Extension


@cache
def touch_extension(struct: Any) -> Any:
    """The structure of pairs of bodies that may touch, whose parameters are of this structure of floats."""

    @wp.struct
    class TouchExtension:
        parameters: wp.array2d[struct]  # (rows, pairs)
        memory: wp.array3d[float]  # (instances, pairs, 1) 1: they may touch before the next look
        first: wp.array[int]  # (pairs,) one body of each, and
        second: wp.array[int]  # (pairs,) the other

    return TouchExtension


@cache
def extension_list(types: tuple[Any, ...]) -> Any:
    """The structure with extensions of these types, one within the other."""
    if not types:
        return NoExtensions
    head, tail = types[0], extension_list(types[1:])

    @wp.struct
    class ExtensionList:
        first: head
        rest: tail

    return ExtensionList


def takes_parameters(function: Any, parameters: Any) -> bool:
    """Whether a Warp function takes a structure of parameters."""
    return parameters is not None and any(kind is parameters for kind in function.input_types.values())


def takes_state(function: Any) -> bool:
    """Whether a Warp function takes the state of its own, an array of floats, which is its last argument then."""
    return hasattr(list(function.input_types.values())[-1], "ndim")


@cache
def of_body(function: Any, result: Any, parameters: Any, extension_struct: Any) -> Any:
    """The Warp function (instance, body, entry, model, state, work, extension) that calls one of a body or a muscle.

    Args:
        function: (instance, body, model, state, work [, parameters] [, state of its own]).
        result: the type that it returns. parameters: of what is declared, see `takes_parameters`.
        extension_struct: type of the extension.
    """
    with_parameters, with_state = takes_parameters(function, parameters), takes_state(function)

    @wp.func
    def call(
        instance: int,
        body: int,
        entry: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ) -> result:
        if wp.static(with_parameters and with_state):
            p = at(extension.parameters, instance, entry)
            return function(instance, body, model, state, work, p, extension.memory[instance, entry])
        elif wp.static(with_parameters):
            return function(instance, body, model, state, work, at(extension.parameters, instance, entry))
        elif wp.static(with_state):
            return function(instance, body, model, state, work, extension.memory[instance, entry])
        else:
            return function(instance, body, model, state, work)

    return call


@cache
def of_instance(function: Any, parameters: Any, extension_struct: Any) -> Any:
    """The Warp function (instance, model, state, work, extension) that calls one without a body, as in `of_body`."""
    with_parameters, with_state = takes_parameters(function, parameters), takes_state(function)

    @wp.func
    def call(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, extension: wp.ref[extension_struct]):
        if wp.static(with_parameters and with_state):
            p = at(extension.parameters, instance, 0)
            function(instance, model, state, work, p, extension.memory[instance, 0])
        elif wp.static(with_parameters):
            function(instance, model, state, work, at(extension.parameters, instance, 0))
        elif wp.static(with_state):
            function(instance, model, state, work, extension.memory[instance, 0])
        else:
            function(instance, model, state, work)

    return call
