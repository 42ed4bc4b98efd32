"""Parts of a scene's own: found, checked against what they declare, and placed on the device.

A part is a `declaration.Declaration` of a user's module, or a Warp function by itself. `parts.py` makes
plain functions of them; this says where the parameters and the memory of each lie.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.objective import parts as kernels
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.objective.desired_torques import term_of_desired
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.objective.term_functions import BODY_TERMS, INSTANCE_TERMS, MUSCLE_TERMS
from warpmuscle.kernels.recording.record import CustomQuantity
from warpmuscle.model.part_checks import (
    IN_STEP,
    INSTANCE,
    TERM_ARGUMENTS,
    Found,
    Kind,
    check_parameters,
    declared_arguments,
    found_part,
    takes,
)
from warpmuscle.model.task_parts import task_parts
from warpmuscle.model.user_functions import (
    FLOATS,
    Struct,
    arguments_of,
    check_arguments,
    check_result,
    custom_curves,
    name_of,
    placed,
    signature,
    undeclared,
)
from warpmuscle.scene import Character, CustomPart, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.scene.trusted_code import check_trusted
from warpmuscle.scene.validation.checks import known


class Placed(NamedTuple):
    """A part and where its numbers and memories begin; one set of them for each of its entries."""

    part: Found
    entries: tuple[str, ...]  # joints, with `root` first, or muscles; or one without a name
    plug: kernels.Plug


@dataclass(frozen=True)
class CustomParts:
    """All parts of a scene's own: those that a step has compiled in by entry, those of a task by key."""

    terms: dict[str, Placed]
    conditions: dict[str, Placed]
    task: dict[str, Placed]
    recorded: dict[str, Placed]

    @property
    def all(self) -> tuple[Placed, ...]:
        """In the order in which their numbers lie."""
        return (*self.terms.values(), *self.conditions.values(), *self.task.values(), *self.recorded.values())

    @property
    def recorded_names(self) -> tuple[str, ...]:
        """Of the numbers that are recorded of the scene's own quantities: `module:name`, and `.x` ... of vectors."""
        return tuple(f"{entry}{axis}" for entry, one in self.recorded.items() for axis in axes_of(one))

    @property
    def recorded_units(self) -> tuple[str, ...]:
        """Their units."""
        return tuple(one.part.declaration.unit or "1" for one in self.recorded.values() for _ in axes_of(one))

    @property
    def memory(self) -> tuple[int, int]:
        """Rows of memory of an instance, and floats of a row."""
        remembering = [one for one in self.all if one.plug.memory]
        rows_of_all = sum(len(one.entries) for one in remembering)
        return rows_of_all, max((one.part.declaration.memory for one in remembering), default=0)


def custom_parts(scene: Scene, muscles: tuple[str, ...], counted: Iterable[str] = ()) -> CustomParts:
    """The parts of a checked scene of its own, and shipped terms that have a memory.

    Args:
        muscles: that are simulated. counted: terms that count.

    Raises:
        SceneError: no such module, function or joint, or it is not as it must be; or the scene does not give its
            parameters.
    """
    terms, conditions = custom_terms(scene) | remembering_terms(counted), custom_conditions(scene)
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

    return CustomParts(
        {entry: place(part) for entry, part in terms.items()},
        {entry: place(part) for entry, part in conditions.items()},
        {key: place(part) for key, part in task_parts(scene).items()},
        {entry: place(part) for entry, part in custom_quantities(scene).items()},
    )


def plain_function(placed_: Placed, character: Character) -> Any:
    """The Warp function of a part that takes nothing of its own, see `kernels.objective.parts`."""
    kind, plug = placed_.part.kind, placed_.plug
    if kind == "desired":
        struct = arguments_of(plug.function)[-1]
        names = topology(character)
        return term_of_desired(plug.function, struct, tuple(names.body_of_joint(name) for name in struct.vars))
    if kind == "muscle":
        return kernels.of_muscle(plug)
    if kind == "body":
        return kernels.of_body(plug)
    return kernels.of_instance(plug, placed_.part.result)


def recorded_functions(parts: CustomParts, character: Character) -> tuple[CustomQuantity, ...]:
    """The recorded quantities of a scene's own, as a step writes them."""
    found, column = [], 0
    for one in parts.recorded.values():
        vector, accelerated = one.part.result is wp.vec3, one.part.declaration.stage == "accelerations"
        found.append(CustomQuantity(plain_function(one, character), column, vector, accelerated, one.plug.memory))
        column += len(axes_of(one))
    return tuple(found)


def axes_of(quantity: Placed) -> tuple[str, ...]:
    """What is put behind the name of a quantity for each of its numbers."""
    return (".x", ".y", ".z") if quantity.part.result is wp.vec3 else ("",)


def part_values(scene: Scene, parts: CustomParts) -> Floats:
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
    """The terms that an objective names, by entry; raises SceneError as `custom_parts`.

    One that sees desired torques, a structure of them after what a term of the whole takes, is of the kind `desired`.
    """
    found = {}
    named = {entry: f"objective.custom.{entry}" for entry in scene.objective.custom}
    reported = {name: f"objective.reported.{k}" for k, name in enumerate(scene.objective.reported) if ":" in name}
    for entry, key in (reported | named).items():
        part = found_part(entry, key, IN_STEP)
        kind = _kind_of_term(part, scene.character.joints, entry, key)
        if kind == "desired":
            _check_desired(part, scene.character, entry, key)
        if kind == "muscle" and part.stage != "forces":
            raise SceneError(f"{entry!r} is a part of each muscle, so its stage must be 'forces'", key=key)
        check_result(part.function, (wp.float32,), key, entry)
        check_parameters(scene, entry, part, kind)
        found[entry] = Found(entry, kind, part)
    return found


def remembering_terms(names: Iterable[str]) -> dict[str, Found]:
    """Those of some terms that are shipped and have a memory."""
    found = {}
    for name in names:
        term = TERMS.get(name)
        if term is not None and term.memory:
            tables: dict[Kind, Any] = {"muscle": MUSCLE_TERMS, "body": BODY_TERMS, "instance": INSTANCE_TERMS}
            kind, table = next((kind, table) for kind, table in tables.items() if name in table)
            found[name] = Found(name, kind, replace(term, function=table[name]))
    return found


def _kind_of_term(part: Declaration, joints: Iterable[str], entry: str, key: str) -> Kind:
    """What a term's function is of, by its arguments; torques are a structure that names a joint or has no numbers."""
    arguments, own = arguments_of(part.function), declared_arguments(part)
    for kind, base in TERM_ARGUMENTS.items():
        if takes(arguments, base, own):
            if part.scope not in ("", kind):
                said = f"the scope of {entry!r} is {part.scope!r}, but its function takes what one of {kind!r} does"
                raise SceneError(said, key=key)
            return kind
    last = arguments[-1] if arguments[:-1] == INSTANCE else None
    if isinstance(last, Struct):
        numbers = all(field.type is wp.float32 for field in last.vars.values())
        if not numbers or not set(joints).isdisjoint(last.vars):
            return "desired"
    wanted = " or ".join(map(signature, TERM_ARGUMENTS.values()))
    more = "".join(f" [, {name_of(kind)}]" for kind in own)
    found = f"{placed(part.function, entry)} takes {signature(arguments)}{undeclared(arguments, own)}"
    raise SceneError(f"a term takes {wanted}{more}, but {found}", key=key)


def _check_desired(part: Declaration, character: Character, entry: str, key: str) -> None:
    """A term may see desired torques of the joints that its structure names; SceneError for others."""
    struct = arguments_of(part.function)[-1]
    if part.stage != "forces" or declared_arguments(part):
        raise SceneError(f"{entry!r} sees desired torques: it has no parameters, memory or other stage", key=key)
    for name, field in struct.vars.items():
        if field.type != wp.vec3:
            raise SceneError(f"{struct.key}.{name} must be wp.vec3, a torque; it is {name_of(field.type)}", key=key)
        known(name, character.joints, "joint", key, f"for {struct.key}")


def custom_conditions(scene: Scene) -> dict[str, Found]:
    """The failing conditions that a scene names, by entry; raises SceneError as `custom_parts`."""
    found = {}
    for entry in scene.failure.custom:
        key = f"failure.custom.{entry}"
        part = found_part(entry, key, ("forces",))
        check_arguments(part.function, INSTANCE, key, entry, declared_arguments(part))
        check_result(part.function, (bool,), key, entry)
        check_parameters(scene, entry, part, "condition")
        found[entry] = Found(entry, "condition", part, result=bool)
    return found


def custom_quantities(scene: Scene) -> dict[str, Found]:
    """The recorded quantities that a scene names, by entry; raises SceneError as `custom_parts`."""
    found = {}
    for index, entry in enumerate(scene.recorded):
        key = f"recorded.{index}"
        part = found_part(entry, key, IN_STEP)
        check_arguments(part.function, INSTANCE, key, entry, declared_arguments(part))
        result = check_result(part.function, (wp.float32, wp.vec3), key, entry)
        check_parameters(scene, entry, part, "quantity")
        found[entry] = Found(entry, "quantity", part, result=float if result is wp.float32 else result)
    return found


def check_custom(scene: Scene) -> None:
    """SceneError if a scene names code that is not trusted, or parts or curves that cannot be used."""
    check_trusted(scene)
    custom_terms(scene)
    custom_conditions(scene)
    task_parts(scene)
    custom_quantities(scene)
    custom_curves(scene.muscle_model)
