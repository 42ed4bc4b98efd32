"""Free parameters that a simulation does not depend on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import arrays_of
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import few_of
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.model.build import build_model, start_of
from warpmuscle.model.extension_arrays import extensions_struct, put_parameters
from warpmuscle.model.parts import check_custom
from warpmuscle.model.structure import Structure, structure_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import Parameter, free_parameters, pinned, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene

SHOWN = 4  # names in a message


def unused_parameters(scene: Scene) -> list[str]:
    """Names of the free parameters that change nothing on the device at either end of their interval.

    Such are properties of muscles that act on no joint that muscles drive, or gains of a joint with a fixed child.
    """
    scene = of_the_body(scene)
    check_scene(scene)
    return unused_in(scene, [(free_parameters(scene), start_values(scene))], lambda _, values: values)[0]


def of_the_body(scene: Scene) -> Scene:
    """The scene without what has no effect on whether other numbers are used; itself if there is nothing such."""
    if scene.tracking is None and not scene.stages and scene.objective.tracking == 0.0:
        return scene
    objective = msgspec.structs.replace(scene.objective, tracking=0.0)
    return msgspec.structs.replace(scene, objective=objective, tracking=None, stages=[])


def unused_in(
    scene: Scene, several: Sequence[tuple[list[Parameter], Floats]], values_of: Callable[[int, Floats], Floats]
) -> list[list[str]]:
    """The same of several scenes that one stands for, each by its parameters and their start values.

    Args:
        scene: the one, checked, as of `of_the_body`. values_of: its values (n, P) of those (n, own) of a scene, by its
            number.
    """
    check_custom(scene)
    structure, rows = structure_of(scene), []
    for parameters, start in several:
        values = np.tile(start, (2 * len(parameters) + 1, 1))
        for index, parameter in enumerate(parameters):
            values[1 + 2 * index, index], values[2 + 2 * index, index] = parameter.min, parameter.max
        rows.append(values)
    own = [values_of(number, values) for number, values in enumerate(rows)]
    count = sum(map(len, own))
    taken = {len(array) for array in _used(scene, structure, own[0][0])}
    filling = 0
    while count + filling in taken:  # so that arrays of this length are those with a row an instance
        filling += 1
    joint = np.concatenate([*own, *[own[-1][-1:]] * filling])
    first = np.repeat(np.cumsum([0, *map(len, own[:-1])]), list(map(len, own)))
    differs = np.zeros(count, dtype=bool)
    for array in _used(scene, structure, joint):
        if len(array) == len(joint):
            flat = np.ascontiguousarray(array).reshape(len(joint), -1).view(np.uint8)[:count]
            differs |= np.any(flat != flat[first], axis=1)
    parts = np.split(differs, np.cumsum(list(map(len, own)))[:-1])
    return [_unused(parameters, part) for (parameters, _), part in zip(several, parts, strict=True)]


def _unused(parameters: list[Parameter], differs: NDArray[np.bool_]) -> list[str]:
    """Names of those that make no difference at their ends, (1 + 2 P,) in turn."""
    used = differs[1::2] | differs[2::2]
    return [
        parameter.name
        for index, parameter in enumerate(parameters)
        if not used[index] and parameter.max > parameter.min and not _is_weight(parameter.name)
    ]


def _used(scene: Scene, structure: Structure, values: Floats) -> list[NDArray[Any]]:
    """What simulations with values (P,) or (n, P) of the free parameters depend on: their model and their start."""
    asked = {
        name: max(one.min, one.max, key=lambda end: abs(end - one.reference)) for name, one in scene.commands.items()
    }
    numeric = substitute(scene, values, asked)  # away from the references, where what is added per command counts
    start, model = start_of(numeric, structure.names), build_model(numeric, structure, "cpu")
    extensions = extensions_struct(structure, 0, "cpu")
    put_parameters(extensions, numeric, structure, "cpu")
    arrays: list[NDArray[Any]] = [start.coordinates, start.speeds, start.activation]
    parts = [array.astype(np.float32) for array in arrays]
    return parts + [array.numpy() for part in (model, extensions) for array in arrays_of(part)]


def without(scene: Scene, names: list[str]) -> Scene:
    """The scene with numbers in place of the free parameters of these names, which nothing uses.

    A search would move them at random. They have the values that they would start from.

    Raises:
        Error: nothing uses any of its free parameters.
    """
    if not names:
        return scene
    used = [parameter.name for parameter in free_parameters(scene) if parameter.name not in names]
    if not used:
        raise Error(
            f"no free parameter changes anything in this scene, so there is nothing to search for: {in_short(names)}"
        )
    return pinned(scene, start_values(scene), used)


def in_short(names: list[str]) -> str:
    """Some names, and how many more there are."""
    return few_of(names, SHOWN)


def _is_weight(name: str) -> bool:
    """Whether a parameter weighs a term of the objective, which happens on the host."""
    return name.startswith("objective.") and name.split(".")[1] in (*TERMS, "custom", "torque_by_joint")
