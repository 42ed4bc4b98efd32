"""Numbers of a scene as arrays for the device: one row for all instances, or one row an instance."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from itertools import accumulate
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.number_rows import orthogonal as orthogonal
from warpmuscle.core.number_rows import rows as rows
from warpmuscle.core.warp_start import start_warp


def starts(counts: Iterable[int]) -> list[int]:
    """Where each group starts when all are put one behind the other, and where the last one ends, from their sizes."""
    return [0, *accumulate(counts)]


def to_device(values: Any, dtype: Any, device: Any) -> wp.array:
    """A Warp array of a scalar, vector or quaternion type; the last axis of `values` holds a vector's components."""
    start_warp()
    is_int = dtype is int
    array = np.ascontiguousarray(values, dtype=np.int32 if is_int else np.float32)
    return wp.array(array, dtype=dtype, device=device)


def instance_zeros(shape: tuple[int, ...], dtype: Any, device: Any, side_by_side: bool = False) -> wp.array:
    """An array of zeros of so many instances, the first number of its shape.

    Args:
        side_by_side: whether the same number of neighbouring instances lie next to one another in memory, as lanes that
            belong to these instances fetch them at once; else all numbers of an instance do.
    """
    start_warp()
    if not side_by_side or len(shape) == 1 or 0 in shape:
        return wp.zeros(shape, dtype=dtype, device=device)
    last = len(shape) - 1
    return wp.zeros((*shape[1:], shape[0]), dtype=dtype, device=device).transpose([last, *range(last)])


def structs_to_device(struct: Any, columns: Mapping[str, Any], device: Any) -> wp.array:
    """A Warp array of structures, from the values of each of their fields.

    Args:
        columns: by field, arrays of one shape, or of one row where others have many; a vector's components are last.
    """
    start_warp()
    dtype = np.dtype(struct.numpy_dtype())
    width = {name: dtype[name].ndim for name in columns}
    shapes = [np.shape(v)[: np.ndim(v) - width[name]] for name, v in columns.items()]
    table = np.zeros(np.broadcast_shapes(*shapes), dtype=dtype)
    for name, values in columns.items():
        table[name] = values
    # By address: given the table itself, Warp compares types anew, which has failed while other threads did the same.
    on_host = wp.array(ptr=table.ctypes.data, dtype=struct, shape=table.shape, device="cpu")
    return wp.clone(on_host, device=device)


def records_to_device(struct: Any, device: Any, **columns: Sequence[float]) -> wp.array:
    """The same of numbers in lists, one structure of zeros if the lists are empty."""
    filled = {name: values if len(values) else [0] for name, values in columns.items()}
    return structs_to_device(struct, filled, device)


def named_arrays(struct: Any) -> Iterator[tuple[str, wp.array]]:
    """All arrays of a device structure, and of the structures within it, each by the name of its own field."""
    for name in struct._cls.vars:
        member = getattr(struct, name)
        if isinstance(member, wp.array):
            yield name, member
        elif hasattr(member, "_cls"):
            yield from named_arrays(member)


def arrays_of(struct: Any) -> Iterator[wp.array]:
    """Those of them that hold anything."""
    return (array for _, array in named_arrays(struct) if array.size)


def put(struct: Any, place: str, value: Any) -> None:
    """Give a field of a device structure, such as `contacts.normal`, another value."""
    *outer, field = place.split(".")
    setattr(reduce(getattr, outer, struct), field, value)


def repeat_rows(value: Any, rows: int, times: int) -> Any:
    """An array of so many rows with each of them several times, one behind the other; in a structure all such arrays.

    Arrays of one dimension, and those with another number of rows, stay as they are: every array that has a row an
    instance has a second dimension.
    """
    if isinstance(value, wp.array):
        return _repeated(value, times) if value.ndim > 1 and len(value) == rows and value.size else value
    for name in value._cls.vars if hasattr(value, "_cls") else ():
        member = getattr(value, name)
        other = repeat_rows(member, rows, times)
        if other is not member:
            setattr(value, name, other)
    return value


def _repeated(array: wp.array, times: int) -> wp.array:
    count, device = len(array), array.device
    found = wp.empty((count * times, *array.shape[1:]), dtype=array.dtype, device=device)
    width = array.size // count * wp.types.type_size_in_bytes(array.dtype) // 4
    source, target = (
        wp.array(ptr=one.ptr, shape=(len(one), width), dtype=int, device=device) for one in (array, found)
    )
    if device.is_cpu:
        target.numpy()[:] = np.repeat(source.numpy(), times, axis=0)
        return found
    index = wp.array(np.repeat(np.arange(count, dtype=np.int32), times), dtype=int, device=device)
    wp.copy(target, wp.indexedarray2d(source, [index, None]))
    return found


def times_repeated(values: np.ndarray) -> int:
    """How often each row of an array (n, ...) stands in it, one behind the other, if equally often; else 1."""
    if not values.size:
        return 1
    others = np.flatnonzero((values != values[:1]).reshape(len(values), -1).any(axis=1))
    times = int(others[0]) if len(others) else len(values)
    if times == 1 or len(values) % times:
        return 1
    groups = values.reshape(-1, times, *values.shape[1:])
    return times if bool((groups == groups[:, :1]).all()) else 1
