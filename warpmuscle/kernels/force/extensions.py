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
def controller_extension(parameters: Any, memory: int, by_joint: Any, by_body: Any, by_muscle: Any) -> Any:
    """The structure of a controller, of which joints, bodies or muscles have parameters of their own, too.

    All are structures of floats, or None. memory: floats of its state.
    """
    if by_joint is None and by_body is None and by_muscle is None:
        return extension_type(parameters, memory)
    of_all, of_joint, of_body, of_muscle = (
        NoParameters if struct is None else struct for struct in (parameters, by_joint, by_body, by_muscle)
    )

    @wp.struct
    class ControllerExtension:
        parameters: wp.array2d[of_all]  # (rows, 1)
        memory: wp.array3d[float]  # (instances, 1, floats)
        by_joint: wp.array2d[of_joint]  # (rows, bodies) of the joint that carries each; the root's are zero
        by_body: wp.array2d[of_body]  # (rows, bodies)
        by_muscle: wp.array2d[of_muscle]  # (rows, simulated muscles)

    return ControllerExtension


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


def takes_table(function: Any, parameters: Any) -> bool:
    """Whether a Warp function takes an array of such structures, of all joints, bodies or muscles."""
    kinds = function.input_types.values()
    return parameters is not None and any(
        hasattr(kind, "ndim") and getattr(kind, "dtype", None) is parameters for kind in kinds
    )


def takes_state(function: Any) -> bool:
    """Whether a Warp function takes the state of its own, an array of floats, which is its last argument then."""
    last = list(function.input_types.values())[-1]
    return hasattr(last, "ndim") and last.dtype in (float, wp.float32)


@cache
def row_of(place: str, struct: Any, extension_struct: Any, table: bool = False) -> Any:
    """The Warp function (instance, number, extension) -> parameters of that joint, body or muscle, or of all of them.

    Args:
        place: field of the extension that has them. struct: theirs. table: whether it gives those of all, an array.
    """

    @wp.func
    def joint_row(instance: int, number: int, extension: wp.ref[extension_struct]) -> struct:
        return at(extension.by_joint, instance, number)

    @wp.func
    def body_row(instance: int, number: int, extension: wp.ref[extension_struct]) -> struct:
        return at(extension.by_body, instance, number)

    @wp.func
    def muscle_row(instance: int, number: int, extension: wp.ref[extension_struct]) -> struct:
        return at(extension.by_muscle, instance, number)

    @wp.func
    def joint_table(instance: int, number: int, extension: wp.ref[extension_struct]) -> wp.array[struct]:
        return extension.by_joint[wp.min(instance, extension.by_joint.shape[0] - 1)]

    @wp.func
    def body_table(instance: int, number: int, extension: wp.ref[extension_struct]) -> wp.array[struct]:
        return extension.by_body[wp.min(instance, extension.by_body.shape[0] - 1)]

    @wp.func
    def muscle_table(instance: int, number: int, extension: wp.ref[extension_struct]) -> wp.array[struct]:
        return extension.by_muscle[wp.min(instance, extension.by_muscle.shape[0] - 1)]

    rows = {"by_joint": joint_row, "by_body": body_row, "by_muscle": muscle_row}
    tables = {"by_joint": joint_table, "by_body": body_table, "by_muscle": muscle_table}
    return (tables if table else rows)[place]


@cache
def of_body(
    function: Any, result: Any, parameters: Any, extension_struct: Any, own: tuple[str, Any] = ("", None)
) -> Any:
    """The Warp function (instance, body, entry, model, state, work, extension) that calls one of a body or a muscle.

    Args:
        function: (instance, body, model, state, work [, parameters] [, those of the body or muscle] [, state]).
        result: the type that it returns. parameters: of what is declared, see `takes_parameters`.
        extension_struct: type of the extension. own: field of it with those of each body or muscle, and their struct.
    """
    with_parameters, with_state = takes_parameters(function, parameters), takes_state(function)
    place, struct = own
    with_own = takes_parameters(function, struct)
    row = row_of(place, struct, extension_struct) if with_own else function

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
        if wp.static(with_parameters and with_own and with_state):
            p = at(extension.parameters, instance, entry)
            memory = extension.memory[instance, entry]
            return function(instance, body, model, state, work, p, row(instance, body, extension), memory)
        elif wp.static(with_parameters and with_own):
            p = at(extension.parameters, instance, entry)
            return function(instance, body, model, state, work, p, row(instance, body, extension))
        elif wp.static(with_own and with_state):
            memory = extension.memory[instance, entry]
            return function(instance, body, model, state, work, row(instance, body, extension), memory)
        elif wp.static(with_own):
            return function(instance, body, model, state, work, row(instance, body, extension))
        elif wp.static(with_parameters and with_state):
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
def of_instance(function: Any, parameters: Any, extension_struct: Any, own: tuple[str, Any] = ("", None)) -> Any:
    """The Warp function (instance, model, state, work, extension) that calls one without a body, as in `of_body`.

    It may take the array of what all bodies or muscles have of their own.
    """
    with_parameters, with_state = takes_parameters(function, parameters), takes_state(function)
    place, struct = own
    with_own = takes_table(function, struct)
    table = row_of(place, struct, extension_struct, True) if with_own else function

    @wp.func
    def call(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, extension: wp.ref[extension_struct]):
        if wp.static(with_parameters and with_own and with_state):
            p = at(extension.parameters, instance, 0)
            function(instance, model, state, work, p, table(instance, 0, extension), extension.memory[instance, 0])
        elif wp.static(with_parameters and with_own):
            p = at(extension.parameters, instance, 0)
            function(instance, model, state, work, p, table(instance, 0, extension))
        elif wp.static(with_own and with_state):
            function(instance, model, state, work, table(instance, 0, extension), extension.memory[instance, 0])
        elif wp.static(with_own):
            function(instance, model, state, work, table(instance, 0, extension))
        elif wp.static(with_parameters and with_state):
            p = at(extension.parameters, instance, 0)
            function(instance, model, state, work, p, extension.memory[instance, 0])
        elif wp.static(with_parameters):
            function(instance, model, state, work, at(extension.parameters, instance, 0))
        elif wp.static(with_state):
            function(instance, model, state, work, extension.memory[instance, 0])
        else:
            function(instance, model, state, work)

    return call
