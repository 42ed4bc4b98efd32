"""What declares parameters and a state: controllers and forces of one's own, checked as a scene is read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from typing import Any

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.model.user_functions import (
    FLOATS,
    arguments_of,
    check_arguments,
    check_known,
    check_memory,
    check_result,
    checked_function,
    name_of,
    placed,
)

BODY = (wp.int32, wp.int32, Model, State, Scratch)


def check_declaration(
    part: Any,
    functions: Mapping[str, tuple[tuple[Any, ...], Any]],
    entry: str,
    key: str,
    phases: Mapping[str, str],
    own: Mapping[str, tuple[Any, ...]] | None = None,
) -> None:
    """SceneError unless a controller or force has functions that take its parameters and state, and both are sound.

    Args:
        functions: what each takes, and returns. phases: of a step, in which each is called.
        own: what each may take between parameters and state.
    """
    given = {name: getattr(part, name) for name in functions if getattr(part, name) is not None}
    if not given:
        raise SceneError(f"{entry!r} has no function: give it one of {', '.join(functions)}", key=key)
    if part.parameters is not None:
        check_parameters(part.parameters, f"the parameters of {entry!r}", key)
    check_count(part.state, f"the state of {entry!r}", key)
    first = () if part.parameters is None else (part.parameters,)
    last = (FLOATS,) if part.state or getattr(part, "state_a_body", 0) else ()
    for name, function in given.items():
        arguments, result = functions[name]
        what = checked_function(function, entry, key).key.rpartition(".")[2]
        if FLOATS in arguments_of(function) and not last:
            raise SceneError(f"{placed(function, what)} takes a state: declare how many floats, state=1", key=key)
        between = () if own is None else own[name]
        check_arguments(function, arguments, key, what, (*first, *between, *last))
        if name in phases:
            check_known(function, phases[name], key, what, f"when a{'n' * (name[0] in 'aeiou')} {name} is asked for")
        if last and not getattr(part, "state_a_body", 0):
            check_memory(function, part.state, key, what)
        if result is not None:
            check_result(function, (result,), key, what)
    taken = {kind for function in given.values() for kind in arguments_of(function)}
    for kind, what in [*((kind, "parameters") for kind in first), *((kind, "state") for kind in last)]:
        if kind not in taken:
            raise SceneError(f"no function of {entry!r} takes {name_of(kind)}, the {what} that it declares", key=key)


def check_parameters(struct: Any, what: str, key: str) -> None:
    """SceneError unless parameters are a structure of floats."""
    fields = getattr(struct, "vars", None)
    if fields is None or not fields or any(field.type is not wp.float32 for field in fields.values()):
        raise SceneError(f"{what} are not a @wp.struct of floats", key=key)


def check_texts(texts: Mapping[str, Any], entry: str, key: str) -> None:
    """SceneError unless what is said of a part is text of one line."""
    for name, text in texts.items():
        if not isinstance(text, str) or text.splitlines() not in ([], [text]):
            raise SceneError(f"the {name} of {entry!r} is not a line of text, but {text!r}", key=key)


def check_fields(part: Any, others: Sequence[str], entry: str, key: str) -> None:
    """SceneError if a part of one's own sets fields that only shipped parts have, which would do nothing or harm."""
    kind = type(part)
    usual = kind() if is_dataclass(kind) else kind._make(kind._field_defaults[name] for name in kind._fields)
    for name in others:
        if getattr(part, name) != getattr(usual, name):
            raise SceneError(f"{entry!r} sets {name!r}, which is for parts of warpmuscle: leave it out", key=key)


def check_number(number: Any, what: str, key: str, infinite: bool = False) -> None:
    """SceneError unless this is a number, and finite where it is not said that it may be infinite."""
    if not isinstance(number, float | int) or isinstance(number, bool):
        raise SceneError(f"{what} is not a number, but {number!r}", key=key)
    if math.isnan(number) or (math.isinf(number) and not infinite):
        raise SceneError(f"{what} is {number}, which is not a finite number", key=key)


def check_count(count: Any, what: str, key: str) -> None:
    """SceneError unless this is a number of floats."""
    if not isinstance(count, int) or isinstance(count, bool) or count < 0:
        raise SceneError(f"{what} is not a number of floats, but {count!r}", key=key)
    check_size("values", count, lambda message: SceneError(message, key=key))
