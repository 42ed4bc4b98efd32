"""Free parameters that a simulation does not depend on."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import arrays_of
from warpmuscle.core.errors import Error
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.model.build import build_model, start_of
from warpmuscle.model.extension_arrays import extensions_struct, put_parameters
from warpmuscle.model.parts import check_custom
from warpmuscle.model.structure import Structure, structure_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, pinned, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene

SHOWN = 4  # names in a message


def unused_parameters(scene: Scene) -> list[str]:
    """Names of the free parameters that change nothing on the device at either end of their interval.

    Such are properties of muscles that act on no joint that muscles drive, or gains of a joint with a fixed child.
    """
    objective = msgspec.structs.replace(scene.objective, tracking=0.0)
    scene = msgspec.structs.replace(scene, objective=objective, tracking=None, stages=[])  # of no effect on the others
    check_scene(scene)
    check_custom(scene)
    parameters, start, structure = free_parameters(scene), start_values(scene), structure_of(scene)
    count = 2 * len(parameters) + 1
    taken = {len(array) for array in _used(scene, structure, start)}
    while count in taken:  # so that arrays of this length are those with a row an instance
        count += 1
    values = np.tile(start, (count, 1))
    for index, parameter in enumerate(parameters):
        values[1 + 2 * index, index], values[2 + 2 * index, index] = parameter.min, parameter.max
    differs = np.zeros(count, dtype=bool)
    for array in _used(scene, structure, values):
        if len(array) == count:
            flat = np.ascontiguousarray(array).reshape(count, -1).view(np.uint8)
            differs |= np.any(flat != flat[0], axis=1)
    used = differs[1 : 2 * len(parameters) : 2] | differs[2 : 2 * len(parameters) + 1 : 2]
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


def without_unused(scene: Scene) -> tuple[Scene, list[str]]:
    """The scene with numbers in place of the free parameters that nothing uses, and the names of these.

    A search would move them at random. They have the values that they would start from.

    Raises:
        Error: nothing uses any of its free parameters.
    """
    names = unused_parameters(scene)
    if not names:
        return scene, names
    used = [parameter.name for parameter in free_parameters(scene) if parameter.name not in names]
    if not used:
        raise Error(f"nothing uses what is free, so that there is nothing to search for: {in_short(names)}")
    return pinned(scene, start_values(scene), used), names


def in_short(names: list[str]) -> str:
    """Some names, and how many more there are."""
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"{', '.join(names[:SHOWN])}{more}"


def _is_weight(name: str) -> bool:
    """Whether a parameter weighs a term of the objective, which happens on the host."""
    return name.startswith("objective.") and name.split(".")[1] in (*TERMS, "custom", "torque_by_joint")
