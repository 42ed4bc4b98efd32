"""What an instance keeps in a GPU's main memory where its whole working set would leave room for few others.

Numbers of SIDE neighbouring instances lie side by side there, as lanes of a warp read them. All places are known as a
kernel is compiled, but for the instance, so that one address leads to all views.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import FOLLOWED
from warpmuscle.kernels.structs import Scratch

SIDE = 32  # instances side by side
LEAN = 33  # floats of a body that `lean_at` places


def apart_floats(entries: int, bodies: int, lean: bool) -> int:
    """Numbers that an instance has in a GPU's main memory, see `apart_at` and `lean_at`."""
    return FOLLOWED * entries + (LEAN * bodies if lean else 0)


def apart_of(dtype: Any, name: str, width: int) -> Any:
    """A Warp function (buffer, first, count, instance, size) -> view of part of what an instance has in main memory.

    That is `size` numbers, of which `first` come before.
    """
    snippet = f"""
const unsigned group = unsigned(instance) / {SIDE}u, place = unsigned(instance) % {SIDE}u;
wp::array_t<{name}> part(
    reinterpret_cast<{name}*>(
        reinterpret_cast<wp::float32*>(buffer) + size_t(group) * ({SIDE} * size) + place * {width} + {SIDE} * first),
    count);
part.strides[0] = {4 * width * SIDE};
return part;
"""

    @wp.func_native(snippet=snippet)
    def part(buffer: wp.uint64, first: int, count: int, instance: int, size: int) -> wp.array[dtype]: ...

    return part


floats_apart = apart_of(float, "wp::float32", 1)
vectors_apart = apart_of(wp.vec3, "wp::vec3", 3)
matrices_apart = apart_of(wp.mat33, "wp::mat33", 9)


@func
def apart_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, entries: int, size: int):
    """Views of what so many entries of `followed.py` leave in a GPU's main memory.

    Only a few lanes read it, one body after the other; other numbers make more of the shared memory.

    Args:
        size: numbers of an instance there.
    """
    w.followed_moment = vectors_apart(buffer, 0, entries, instance, size)
    w.followed_force = vectors_apart(buffer, 3 * entries, entries, instance, size)
    w.followed_along = vectors_apart(buffer, 6 * entries, entries, instance, size)
    w.followed_response = vectors_apart(buffer, 9 * entries, entries, instance, size)
    w.followed_bias = floats_apart(buffer, 12 * entries, entries, instance, size)


@func
def lean_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, n: int, first: int, size: int):
    """Views of what passes over the tree read once or twice for each of n bodies, in main memory, too.

    There nothing takes another's place.

    Args:
        first, size: numbers that come before, and of an instance there.
    """
    w.coordinate_turning = vectors_apart(buffer, first, n, instance, size)
    w.coordinate_moving = vectors_apart(buffer, first + 3 * n, n, instance, size)
    w.coordinate_drift = vectors_apart(buffer, first + 6 * n, n, instance, size)
    w.coordinate_state = vectors_apart(buffer, first + 9 * n, n, instance, size)
    w.velocity = vectors_apart(buffer, first + 12 * n, n, instance, size)
    w.lag_angular = vectors_apart(buffer, first + 15 * n, n, instance, size)
    w.lag_velocity = vectors_apart(buffer, first + 18 * n, n, instance, size)
    w.bias_force = vectors_apart(buffer, first + 21 * n, n, instance, size)
    w.factor_a = matrices_apart(buffer, first + 24 * n, n, instance, size)


@cache
def main_memory_of(entries: int, bodies: int, lean: bool, behind: int) -> Any:
    """The Warp function (w, buffer, instance) that puts the views of both into a working set.

    Args:
        lean: whether there are those of `lean_at`.
        behind: numbers that a buffer has before: a thread of a CPU has its working set in the same one.
    """
    size, followed, put_lean = apart_floats(entries, bodies, lean), FOLLOWED * entries, lean_at if lean else None

    @func
    def in_main_memory(w: wp.ref[Scratch], buffer: wp.uint64, instance: int):
        own = buffer + wp.static(wp.uint64(4 * behind))
        apart_at(w, own, instance, entries, size)
        if wp.static(lean):
            put_lean(w, own, instance, bodies, followed, size)

    return in_main_memory
