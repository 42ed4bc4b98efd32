"""What an instance keeps in a GPU's main memory where its whole working set would leave room for few others.

Numbers of SIDE neighbouring instances lie side by side there, as lanes of a warp read them. All places are known as a
kernel is compiled, but for the instance, so that one address leads to all views.
"""

from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import FOLLOWED, LEAN_FIRST, matrices_at, symmetric_at, vectors_at
from warpmuscle.kernels.structs import Scratch

SIDE = 32  # instances side by side
LEAN = 37  # floats of a body that `lean_at` places


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
quaternions_apart = apart_of(wp.quat, "wp::quat", 4)
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
def lean_at(
    w: wp.ref[Scratch], memory: wp.array[float], buffer: wp.uint64, instance: int, n: int, first: int, size: int
):
    """Views of the first block of `scratch.work_at` and of joints of one coordinate, of which only part is at hand.

    That is what muscles read, many times, and with it what takes its places. Passes over the tree read the rest once
    or twice for each body. There nothing takes another's place.

    Args:
        memory: what is at hand. first, size: numbers that come before in main memory, and of an instance there.
    """
    w.rotation = matrices_at(memory, 0, LEAN_FIRST, n)
    w.turn_rates = matrices_at(memory, 0, LEAN_FIRST, n)
    w.position = vectors_at(memory, 9, LEAN_FIRST, n)
    w.move_rates = matrices_at(memory, 9, LEAN_FIRST, n)
    w.angular_velocity = vectors_at(memory, 12, LEAN_FIRST, n)
    w.torque = vectors_at(memory, 15, LEAN_FIRST, n)
    w.factor_b = matrices_at(memory, 15, LEAN_FIRST, n)
    w.stiffness = symmetric_at(memory, 18, LEAN_FIRST, n)
    w.coordinate_turning_drift = vectors_at(memory, 18, LEAN_FIRST, n)
    w.coordinate_turning = vectors_at(memory, 24, LEAN_FIRST, n)
    w.coordinate_moving = vectors_at(memory, 27, LEAN_FIRST, n)
    w.orientation = quaternions_apart(buffer, first, n, instance, size)
    w.factor_c = vectors_apart(buffer, first + 4 * n, n, instance, size)
    w.bias = vectors_apart(buffer, first + 7 * n, n, instance, size)
    w.velocity = vectors_apart(buffer, first + 10 * n, n, instance, size)
    w.lag_angular = vectors_apart(buffer, first + 13 * n, n, instance, size)
    w.lag_velocity = vectors_apart(buffer, first + 16 * n, n, instance, size)
    w.factor_a = matrices_apart(buffer, first + 19 * n, n, instance, size)
    w.bias_force = vectors_apart(buffer, first + 28 * n, n, instance, size)
    w.coordinate_drift = vectors_apart(buffer, first + 31 * n, n, instance, size)
    w.coordinate_state = vectors_apart(buffer, first + 34 * n, n, instance, size)
