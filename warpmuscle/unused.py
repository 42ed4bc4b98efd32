"""Free parameters that a simulation does not depend on."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.arrays import arrays_of
from warpmuscle.errors import Error
from warpmuscle.objective import TERMS
from warpmuscle.parameters import free_parameters, start_values
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Scene

SHOWN = 4  # names in a message


def unused_parameters(scene: Scene) -> list[str]:
    """Names of the free parameters that change nothing on the device at either end of their interval.

    Such are properties of muscles that act on no joint that muscles drive, or gains of a joint with a fixed child.
    """
    objective = msgspec.structs.replace(scene.objective, tracking=0.0)
    scene = msgspec.structs.replace(scene, objective=objective, tracking=None, stages=[])  # of no effect on the others
    parameters, start = free_parameters(scene), start_values(scene)
    count = 2 * len(parameters) + 1
    taken = {len(array) for array in arrays_of(Rollout(scene, 1, "cpu", threads=1).model)}
    while count in taken:  # so that arrays of this length are those with a row an instance
        count += 1
    values = np.tile(start, (count, 1))
    for index, parameter in enumerate(parameters):
        values[1 + 2 * index, index], values[2 + 2 * index, index] = parameter.min, parameter.max
    batch = Rollout(scene, count, "cpu", threads=1)
    batch.set_parameters(values)
    differs = np.zeros(count, dtype=bool)
    for array in (*arrays_of(batch.model), *arrays_of(batch.state)):
        if len(array) == count:
            flat = np.ascontiguousarray(array.numpy()).reshape(count, -1).view(np.uint8)
            differs |= np.any(flat != flat[0], axis=1)
    used = differs[1 : 2 * len(parameters) : 2] | differs[2 : 2 * len(parameters) + 1 : 2]
    return [
        parameter.name
        for index, parameter in enumerate(parameters)
        if not used[index] and parameter.max > parameter.min and not _is_weight(parameter.name)
    ]


def check_used(scene: Scene) -> None:
    """Raise Error if the scene has a free parameter that nothing uses: a search would move it at random."""
    names = unused_parameters(scene)
    if names:
        more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
        raise Error(
            f"free, but nothing uses it: {', '.join(names[:SHOWN])}{more}; write a number in place of its interval"
        )


def _is_weight(name: str) -> bool:
    """Whether a parameter weighs a term of the objective, which happens on the host."""
    return name.startswith("objective.") and name.split(".")[1] in TERMS
