"""Parts of a scene's own: found, checked against what they declare, and placed on the device.

A part is a `kernels.declaration.Declaration` of a user's module, or a Warp function by itself. `kernels/parts.py` makes
plain functions of them; this says where the parameters and the memory of each lie.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.kernels import parts as kernels
from warpmuscle.kernels.declaration import STAGES, Declaration
from warpmuscle.kernels.desired_torques import term_of_desired
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.kernels.term_functions import MuscleWork
from warpmuscle.model.user_functions import (
    FLOATS,
    Struct,
    arguments_of,
    check_arguments,
    check_result,
    checked_function,
    custom_curves,
    declared,
    name_of,
    placed,
    signature,
)
from warpmuscle.scene import Character, CustomPart, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import topology
from warpmuscle.scene.trusted_code import check_trusted
from warpmuscle.scene.validation.checks import Checks, known, near

Kind = Literal["muscle", "body", "whole", "desired", "condition"]

WHOLE = (wp.int32, Model, State, Scratch)
TERM_ARGUMENTS: dict[Kind, tuple[Any, ...]] = {
    "muscle": (wp.int32, wp.int32, MuscleWork, Model),
    "body": (wp.int32, wp.int32, Model, State, Scratch),
    "whole": WHOLE,
}
IN_STEP = ("forces", "accelerations")


class Found(NamedTuple):
    """A part as its module declares it, and what its function is of."""

    entry: str  # `module:name`
    kind: Kind
    declaration: Declaration


class Placed(NamedTuple):
    """A part and where its numbers and memories begin; one set of them for each of its entries."""

    part: Found
    entries: tuple[str, ...]  # joints, with `root` first, or muscles; or one without a name
    plug: kernels.Plug


@dataclass(frozen=True)
class OwnParts:
    """All parts of a scene's own that a step has compiled in, by entry."""

    terms: dict[str, Placed]
    conditions: dict[str, Placed]

    @property
    def all(self) -> tuple[Placed, ...]:
        """In the order in which their numbers lie."""
        return (*self.terms.values(), *self.conditions.values())

    @property
    def memory(self) -> tuple[int, int]:
        """Rows of memory of an instance, and floats of a row."""
        remembering = [one for one in self.all if one.plug.memory]
        rows_of_all = sum(len(one.entries) for one in remembering)
        return rows_of_all, max((one.part.declaration.memory for one in remembering), default=0)


def own_parts(scene: Scene, muscles: tuple[str, ...]) -> OwnParts:
    """The parts of a checked scene that a step has compiled in.

    Args:
        muscles: that are simulated.

    Raises:
        SceneError: no such module, function or joint, or it is not as it must be; or the scene does not give its
            parameters.
    """
    terms, conditions = custom_terms(scene), custom_conditions(scene)
    joints = ("root", *topology(scene.character).joints)
    values = memories = 0

    def place(part: Found) -> Placed:
        nonlocal values, memories
        entries = {"body": joints, "muscle": muscles}.get(part.kind, ("",))
        taken = arguments_of(part.declaration.function)
        parameters = part.declaration.parameters if part.declaration.parameters in taken else None
        plug = kernels.Plug(part.declaration.function, parameters, FLOATS in taken, values, memories)
        values += 0 if parameters is None else len(parameters.vars) * len(entries)
        memories += len(entries) if plug.memory else 0
        return Placed(part, entries, plug)

    return OwnParts(
        {entry: place(part) for entry, part in terms.items()},
        {entry: place(part) for entry, part in conditions.items()},
    )


def plain_function(placed_: Placed, character: Character) -> Any:
    """The Warp function of a part that takes nothing of its own, see `kernels.parts`."""
    kind, plug = placed_.part.kind, placed_.plug
    if kind == "desired":
        struct = arguments_of(plug.function)[-1]
        names = topology(character)
        return term_of_desired(plug.function, struct, tuple(names.body_of_joint(name) for name in struct.vars))
    if kind == "muscle":
        return kernels.of_muscle(plug)
    if kind == "body":
        return kernels.of_body(plug)
    return kernels.of_instance(plug, bool if kind == "condition" else float)


def part_values(scene: Scene, parts: OwnParts) -> Floats:
    """Parameters of all parts, (rows, values), of a scene whose numbers are floats or (n,) arrays."""
    columns = []
    for part in parts.all:
        if part.plug.parameters is None:
            continue
        given = scene.custom.get(part.part.entry, CustomPart())
        for entry in part.entries:
            of_entry = {**part.part.declaration.defaults, **given.parameters, **given.each.get(entry, {})}
            columns += [of_entry[name] for name in part.plug.parameters.vars]
    return np.asarray(rows(columns)) if columns else np.zeros((1, 0))


def custom_terms(scene: Scene) -> dict[str, Found]:
    """The terms that an objective names, by entry; raises SceneError as `own_parts`.

    One that sees desired torques, a structure of them after what a term of the whole takes, is of the kind `desired`.
    """
    found = {}
    for entry in scene.objective.custom:
        key = f"objective.custom.{entry}"
        part = found_part(entry, key, IN_STEP)
        kind = _kind_of_term(part, entry, key)
        if kind == "desired":
            _check_desired(part, scene.character, entry, key)
        check_result(part.function, (wp.float32,), key, entry)
        check_parameters(scene, entry, part, kind)
        found[entry] = Found(entry, kind, part)
    return found


def _kind_of_term(part: Declaration, entry: str, key: str) -> Kind:
    """What a term's function is of, by its arguments."""
    arguments, own = arguments_of(part.function), own_arguments(part)
    for kind, base in TERM_ARGUMENTS.items():
        taken = arguments[len(base) :]
        if arguments[: len(base)] == base and taken == tuple(one for one in own if one in taken):
            return kind
    if arguments[:-1] == WHOLE and isinstance(arguments[-1], Struct):
        return "desired"
    wanted = " or ".join(map(signature, TERM_ARGUMENTS.values()))
    more = "".join(f" [, {name_of(kind)}]" for kind in own)
    found = f"{placed(part.function, entry)} takes {signature(arguments)}"
    raise SceneError(f"a term takes {wanted}{more}, but {found}", key=key)


def _check_desired(part: Declaration, character: Character, entry: str, key: str) -> None:
    """A term may see desired torques of the joints that its structure names; SceneError for others."""
    struct = arguments_of(part.function)[-1]
    if part.stage != "forces" or own_arguments(part):
        raise SceneError(f"{entry!r} sees desired torques: it has no parameters, memory or other stage", key=key)
    for name, field in struct.vars.items():
        if field.type != wp.vec3:
            raise SceneError(f"{struct.key}.{name} must be wp.vec3, a torque; it is {name_of(field.type)}", key=key)
        known(name, character.joints, "joint", key, f"for {struct.key}")


def custom_conditions(scene: Scene) -> dict[str, Found]:
    """The failing conditions that a scene names, by entry; raises SceneError as `own_parts`."""
    found = {}
    for entry in scene.failure.custom:
        key = f"failure.custom.{entry}"
        part = found_part(entry, key, ("forces",))
        check_arguments(part.function, WHOLE, key, entry, own_arguments(part))
        check_result(part.function, (bool,), key, entry)
        check_parameters(scene, entry, part, "condition")
        found[entry] = Found(entry, "condition", part)
    return found


_known: dict[str, Declaration] = {}  # parts whose modules have been imported, by entry


def known_part(entry: str) -> Declaration | None:
    """What a part declares, if its module has been imported."""
    return _known.get(entry)


def found_part(entry: str, key: str, stages: tuple[str, ...]) -> Declaration:
    """The declaration of a part of one's own, sound in itself.

    Args:
        entry: `module:name` of a `Declaration`, or of a Warp function, which then is one by itself.
        stages: at one of which it must be called; the first is that of a function by itself.

    Raises:
        SceneError: there is no such thing, or it is not as it must be.
    """
    thing = declared(entry, key, Declaration)
    part = thing if isinstance(thing, Declaration) else Declaration(function=thing, stage=stages[0])
    checked_function(part.function, entry, key)
    if part.parameters is not None:
        fields = getattr(part.parameters, "vars", None)
        if not fields or any(field.type is not wp.float32 for field in fields.values()):
            raise SceneError(f"the parameters of {entry!r} are no @wp.struct of floats", key=key)
    if not isinstance(part.memory, int) or isinstance(part.memory, bool) or part.memory < 0:
        raise SceneError(f"the memory of {entry!r} is not a number of floats, but {part.memory!r}", key=key)
    check_size("values", part.memory, lambda message: SceneError(message, key=key))
    if part.sign not in ("cost", "earned"):
        raise SceneError(f"the sign of {entry!r} is 'cost' or 'earned', not {part.sign!r}", key=key)
    if part.stage not in stages:
        asked = f"the stage of {entry!r} is {' or '.join(map(repr, stages))} here, not {part.stage!r}"
        raise SceneError(asked + near(str(part.stage), [one for one in STAGES if one in stages]), key=key)
    names = [] if part.parameters is None else list(part.parameters.vars)
    for what in ("defaults", "limits"):
        for name in getattr(part, what):
            known(name, names, "parameter", key, f"in {what} of {entry!r}")
    taken = arguments_of(part.function)
    for what, given in (("parameters", part.parameters), ("memory", FLOATS if part.memory else None)):
        if given is not None and given not in taken:
            raise SceneError(f"{placed(part.function, entry)} takes no {what}, which {entry!r} declares", key=key)
    if FLOATS in taken and not part.memory:
        raise SceneError(f"{placed(part.function, entry)} takes a memory: declare how many floats, memory=1", key=key)
    _known[entry] = part
    return part


def own_arguments(part: Declaration) -> tuple[Any, ...]:
    """What a function of a part may take last: its parameters, then its memory."""
    return (*([] if part.parameters is None else [part.parameters]), *([FLOATS] if part.memory else []))


def check_parameters(scene: Scene, entry: str, part: Declaration, kind: Kind) -> None:
    """SceneError unless a scene gives the parameters of a part, within their limits, and no others."""
    given, key = scene.custom.get(entry, CustomPart()), f"custom.{entry}"
    names = [] if part.parameters is None else list(part.parameters.vars)
    of_bodies, of_muscles = list(scene.character.joints), list(scene.character.muscles)
    owners = {"body": of_bodies, "muscle": of_muscles}.get(kind, [])
    missing = [name for name in names if name not in given.parameters and name not in part.defaults]
    if missing:
        raise SceneError(f"there is no value of {', '.join(map(repr, missing))}", key=f"{key}.parameters")
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


def _numbers(given: CustomPart) -> Iterator[tuple[str, str, Any]]:
    """Place, name and value of all parameters that a scene gives a part."""
    tables: Mapping[str, Mapping[str, Any]] = {"parameters": given.parameters} | {
        f"each.{owner}": table for owner, table in given.each.items()
    }
    for place, table in tables.items():
        for name, number in table.items():
            yield f"{place}.{name}", name, number


def check_custom(scene: Scene) -> None:
    """SceneError if a scene names code that is not trusted, or parts or curves that cannot be used."""
    check_trusted(scene)
    custom_terms(scene)
    custom_conditions(scene)
    custom_curves(scene.muscle_model)
