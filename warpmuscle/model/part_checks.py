"""Parts of a scene's own by what they declare: found, sound in themselves, and given the parameters that they take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import STAGES, Declaration, Stage
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.model.extensions import check_count, check_fields, check_number, check_texts
from warpmuscle.model.extensions import check_parameters as check_struct
from warpmuscle.model.user_functions import (
    FLOATS,
    arguments_of,
    check_known,
    check_memory,
    checked_function,
    declared,
    name_of,
    placed,
    signature,
)
from warpmuscle.scene import CustomPart, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.checks import Checks, known, near

Kind = Literal["muscle", "body", "instance", "desired", "condition", "decision", "quantity"]

INSTANCE = (wp.int32, Model, State, Scratch)
TERM_ARGUMENTS: dict[Kind, tuple[Any, ...]] = {
    "muscle": (wp.int32, wp.int32, MuscleWork, Model),
    "body": (wp.int32, wp.int32, Model, State, Scratch),
    "instance": INSTANCE,
}
IN_STEP: tuple[Stage, ...] = ("forces", "accelerations")
PHASE_OF: dict[Stage, str] = {"forces": "objective", "accelerations": "acted", "decision": "sums"}  # of the working set


class Found(NamedTuple):
    """A part as its module declares it, and what its function is of."""

    entry: str  # `module:name`
    kind: Kind
    declaration: Declaration
    base: str = "instance"  # what a part of a task takes, see `kernels.learning.decision_parts`
    result: Any = float  # what its function returns


_known: dict[str, Declaration] = {}  # parts whose modules have been imported, by entry


def known_part(entry: str) -> Declaration | None:
    """What a part declares, if its module has been imported."""
    return _known.get(entry)


def found_part(entry: str, key: str, stages: tuple[Stage, ...]) -> Declaration:
    """The declaration of a part of one's own, sound in itself.

    Args:
        entry: `module:name` of a `Declaration`, or of a Warp function, which then is one by itself.
        stages: at one of which it must be called; the first is that of a function by itself.

    Raises:
        SceneError: there is no such thing, or it is not as it must be.
    """
    thing = declared(entry, key, Declaration)
    if isinstance(thing, Declaration):
        part = thing
    else:
        at_decision = "decision" in stages and Decision in arguments_of(thing)
        part = Declaration(function=thing, stage="decision" if at_decision else stages[0])
    if part.function is None:
        hint = ": write function=" + part.name.func.__name__ if isinstance(part.name, wp.Function) else ""
        raise SceneError(f"{entry!r} declares no function{hint}", key=key)
    check_fields(part, ("weight", "models"), entry, key)
    check_texts({"unit": part.unit, "description": part.description}, entry, key)
    checked_function(part.function, entry, key)
    if part.parameters is not None:
        check_struct(part.parameters, f"the parameters of {entry!r}", key)
    check_count(part.memory, f"the memory of {entry!r}", key)
    if part.sign not in ("", "cost", "earned"):
        raise SceneError(f"the sign of {entry!r} is 'cost' or 'earned', not {part.sign!r}", key=key)
    taken = arguments_of(part.function)
    if Decision in taken and "decision" in stages and part.stage != "decision":
        raise SceneError(f"{placed(part.function, entry)} takes a Decision: declare stage='decision'", key=key)
    if part.stage not in stages:
        asked = f"the stage of {entry!r} is {' or '.join(map(repr, stages))} here, not {part.stage!r}"
        raise SceneError(asked + near(str(part.stage), [one for one in STAGES if one in stages]), key=key)
    _check_numbers(part, entry, key)
    for what, given in (("parameters", part.parameters), ("memory", FLOATS if part.memory else None)):
        if given is not None and given not in taken:
            said = f"{placed(part.function, entry)} takes {signature(taken)}"
            raise SceneError(f"{said}, without {name_of(given)}, the {what} that {entry!r} declares", key=key)
    if FLOATS in taken and not part.memory:
        raise SceneError(f"{placed(part.function, entry)} takes a memory: declare how many floats, memory=1", key=key)
    later = "; declare stage='accelerations'" if "accelerations" in stages else ""
    check_known(part.function, PHASE_OF[part.stage], key, entry, f"at the stage {part.stage!r}", later)
    if part.memory:
        check_memory(part.function, part.memory, key, entry)
    _known[entry] = part
    return part


def _check_numbers(part: Declaration, entry: str, key: str) -> None:
    """SceneError unless defaults and limits are numbers, of parameters that there are."""
    names = [] if part.parameters is None else list(part.parameters.vars)
    for what, sizes in (("defaults", 1), ("limits", 2)):
        given = getattr(part, what)
        if not isinstance(given, Mapping):
            raise SceneError(f"{what} of {entry!r} are not a table by parameter", key=key)
        for name, value in given.items():
            known(name, names, "parameter", key, f"in {what} of {entry!r}")
            numbers = value if isinstance(value, tuple | list) and sizes == 2 else (value,)
            if len(numbers) != sizes:
                raise SceneError(f"limits of {entry!r} have no lowest and highest value of {name!r}", key=key)
            for number in numbers:
                check_number(number, f"{name!r} in {what} of {entry!r}", key, infinite=sizes == 2)
            if numbers[0] > numbers[-1]:
                raise SceneError(f"limits of {entry!r}: the lowest {name!r} is above its highest value", key=key)
    for name, value in part.defaults.items():
        least, most = part.limits.get(name, (-np.inf, np.inf))
        if not least <= value <= most:
            said = f"the default of {name!r} in {entry!r} must be within {least:g} and {most:g}, is {value:g}"
            raise SceneError(said, key=key)


def declared_arguments(part: Declaration) -> tuple[Any, ...]:
    """What a function of a part may take last: its parameters, then its memory."""
    return (*([] if part.parameters is None else [part.parameters]), *([FLOATS] if part.memory else []))


def takes(arguments: tuple[Any, ...], base: tuple[Any, ...], own: tuple[Any, ...]) -> bool:
    """Whether arguments are those of a base, and then, in their order, of a part's own those that it wants."""
    rest = arguments[len(base) :]
    return arguments[: len(base)] == base and rest == tuple(one for one in own if one in rest)


def check_parameters(scene: Scene, entry: str, part: Declaration, kind: Kind) -> None:
    """SceneError unless a scene gives the parameters of a part, within their limits, and no others."""
    given, key = scene.custom.get(entry, CustomPart()), f"custom.{entry}"
    names = [] if part.parameters is None else list(part.parameters.vars)
    of_bodies, of_muscles = list(scene.character.joints), list(scene.character.muscles)
    owners = {"body": of_bodies, "muscle": of_muscles}.get(kind, [])
    for owner in given.each:
        if not owners:
            raise SceneError(f"{entry!r} is one of the whole body: it has no numbers for each", key=f"{key}.each")
        known(owner, owners, "joint" if kind == "body" else "muscle", f"{key}.each.{owner}")
    checks = Checks(scene) if any(isinstance(number, Free) for _, _, number in _numbers(given)) else None
    for place, name, number in _numbers(given):
        if name not in names:
            takes = f"takes {', '.join(names)}" if names else "takes none"
            raise SceneError(f"no parameter is called {name!r}{near(name, names)}; it {takes}", key=f"{key}.{place}")
        low, high = checks.interval(number) if checks is not None else (number, number)
        least, most = part.limits.get(name, (-np.inf, np.inf))
        if not least <= low <= high <= most:
            wrong = low if low < least else high
            raise SceneError(f"must be within {least:g} and {most:g}, is {wrong:g}", key=f"{key}.{place}")
    missing = [name for name in names if name not in given.parameters and name not in part.defaults]
    if missing:
        raise SceneError(f"there is no value of {', '.join(map(repr, missing))}", key=f"{key}.parameters")


def _numbers(given: CustomPart) -> Iterator[tuple[str, str, Any]]:
    """Place, name and value of all parameters that a scene gives a part."""
    tables: Mapping[str, Mapping[str, Any]] = {"parameters": given.parameters} | {
        f"each.{owner}": table for owner, table in given.each.items()
    }
    for place, table in tables.items():
        for name, number in table.items():
            yield f"{place}.{name}", name, number
