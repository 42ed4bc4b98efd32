"""Memory that the instances of a batch take on a device, and whether there is as much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.arrays import arrays_of
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.model.build import build_model
from warpmuscle.model.state import state_struct
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.devices import free_memory
from warpmuscle.simulation.extensions import Extensions

FEW = 8192  # instances, some 0.3 GiB, for which there always is memory, so that nobody has to find out about it
USABLE = 0.95  # of the free memory; kernels and the list of running instances need some of it
GIB = 1024.0**3


@dataclass(frozen=True)
class InstanceBytes:
    """Bytes that one more instance takes on the device."""

    state: int
    model: int  # if it has free parameters for itself; nothing if all instances share them

    @property
    def total(self) -> int:
        """With free parameters for itself."""
        return self.state + self.model


def struct_bytes(*structs: Any) -> int:
    """Bytes of all arrays of device structures."""
    return sum(array.capacity for struct in structs for array in arrays_of(struct))


def instance_bytes(scene: Scene, structure: Structure, apart: bool = False) -> InstanceBytes:
    """Bytes that a further instance of a scene takes; `apart`: where a kernel of its own finds paths of muscles."""
    start = start_values(scene)

    def states(count: int) -> tuple[Any, ...]:
        return state_struct(scene, structure, count, "cpu", apart=apart), Extensions(structure, count, "cpu").struct

    def models(count: int) -> tuple[Any, ...]:
        numeric, extensions = substitute(scene, np.tile(start, (count, 1))), Extensions(structure, 0, "cpu")
        extensions.use(numeric)
        return build_model(numeric, structure, "cpu"), extensions.struct

    return InstanceBytes(*(struct_bytes(*make(3)) - struct_bytes(*make(2)) for make in (states, models)))


def instances_that_fit(bytes_an_instance: int, device: Any, held: int = 0) -> int | None:
    """How many instances a device has memory for, `held` bytes of which are theirs; None where it does not tell."""
    free = free_memory(device)
    return None if free is None else int((USABLE * free + held) // max(bytes_an_instance, 1))


def check_memory(instances: int, bytes_an_instance: int, device: Any, held: int = 0) -> None:
    """Raise RolloutError if so many instances do not fit into a device's memory.

    Args:
        bytes_an_instance: what each of them takes. held: bytes of it that have been allocated.
    """
    fitting = instances_that_fit(bytes_an_instance, device, held)
    if fitting is not None and fitting < instances:
        raise RolloutError(
            f"{number_of(instances, 'instance', 'need')} {instances * bytes_an_instance / GIB:.3g} GiB on "
            f"{device}, which has memory "
            f"left for {fitting} of {bytes_an_instance / 1024.0:.3g} KiB each: simulate so many at a time"
        )
