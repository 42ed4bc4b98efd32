"""Parameters and states that controllers of a batch have beside its model and state."""

from __future__ import annotations

from typing import Any

import warp as wp

from warpmuscle.core.arrays import arrays_of
from warpmuscle.kernels.memory.restart import put_rows
from warpmuscle.kernels.object_structs import ObjectExtension
from warpmuscle.model.extension_arrays import extensions_struct, put_of_controller, put_parameters
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene


class Extensions:
    """The last argument of a batch's kernel, see `kernels.force.extensions`.

    Attributes:
        struct: it. memories: the arrays of states in it, (instances, entries, floats) each.
    """

    def __init__(self, structure: Structure, instances: int, device: Any) -> None:
        """Make room for the states, which are zero."""
        self._structure, self._device = structure, device
        self.struct = extensions_struct(structure, instances, device)
        self.memories: list[wp.array] = [array for array in arrays_of(self.struct) if array.ndim == 3]

    def use(self, numeric: Scene) -> None:
        """Take the parameters from a scene of numbers, see `parameters.substitute`."""
        put_parameters(self.struct, numeric, self._structure, self._device)

    @property
    def of_controller(self) -> bool:
        """Whether there are parameters of the controller."""
        custom = self._structure.controller.custom
        places = (custom.parameters, custom.by_joint, custom.by_body, custom.by_muscle)
        return any(struct is not None for struct in places)

    @property
    def objects(self) -> Any:
        """Those beside the bodies; without any where there are none."""
        part = self.struct.rest
        for entries in self._structure.forces:
            if entries.objects is not None:
                return part.first
            part = part.rest
        return ObjectExtension()

    def use_controller(self, numeric: Scene) -> None:
        """Take those of the controller, which are all that differs from the present ones."""
        put_of_controller(self.struct, numeric, self._structure, self._device)

    def restart(self, chosen: wp.array | None = None) -> None:
        """Put the states of all instances, or of chosen ones, back to zero."""
        for memory in self.memories:
            if chosen is None:
                memory.zero_()
            else:
                target = words(memory)
                zeros = wp.zeros((1, words_a_row(memory)), dtype=int, device=self._device)
                wp.launch(put_rows, (len(chosen), *target.shape[1:]), [chosen, zeros, target], device=self._device)


def words(array: wp.array) -> wp.array:
    """The memory of an array of `core.arrays.instance_zeros` as 4-byte words, (instances, elements, words of each)."""
    size = wp.types.type_size_in_bytes(array.dtype) // 4
    shape = (len(array), array.size // len(array), size)
    near = array.strides[-1] if array.ndim > 1 else 4 * size
    return wp.array(ptr=array.ptr, shape=shape, strides=(array.strides[0], near, 4), dtype=int, device=array.device)


def words_a_row(array: wp.array) -> int:
    """4-byte words of each instance in such an array."""
    return int(array.size // len(array) * wp.types.type_size_in_bytes(array.dtype) // 4)
