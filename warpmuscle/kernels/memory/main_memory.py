"""What an instance keeps in a GPU's main memory where its whole working set would leave room for few others.

Numbers of SIDE neighbouring instances lie side by side there, as lanes of a warp read them: records, one behind the
other. All places are known as a kernel is compiled, but for the instance, so that one address leads to all views, and
so that the compiler knows which numbers a lane can fetch two or four at once: those of a record of two or four, or a
multiple. What is read together shares a record; more than that would be fetched in vain. There only what is alike takes
another's place, at the times that `scratch.LIVES` says.
"""

from functools import cache
from itertools import accumulate
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.spatial import rotation_matrix, symmetric
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import (
    ALL,
    ENTRIES,
    FOLLOWED,
    LEAN,
    LEANER,
    LEANEST,
    OTHER_FLOATS,
    POSE,
    PUSH,
    SLOT_FLOATS,
    quaternions_at,
    vectors_at,
)
from warpmuscle.kernels.structs import Scratch, ScratchRef

SIDE = 32  # instances side by side
LEAN_FLOATS, LEANER_FLOATS, FIRST_FLOATS, POSE_FLOATS = 36, 48, 36, 8  # of a body that `lean_at` and so on place
ROTATION = 12  # numbers of the record of a rotation
ALIGNED = 16  # bytes, of all records of a multiple of four numbers


class Apart(NamedTuple):
    """What of a working set is in main memory."""

    main: int  # how much of it, see `scratch.NEAR`
    entries: int  # of `followed.py`
    bodies: int
    slots: int  # of feet
    unknowns: int  # that stay open to the root
    pushes: int  # rows of constraints among these

    @property
    def starts(self) -> tuple[int, ...]:
        """Numbers of an instance with so much in main memory, for each of `scratch.NEAR` to `ALL`."""
        n = self.bodies
        equations = SLOT_FLOATS * self.slots + OTHER_FLOATS + self.unknowns * (self.unknowns + 1) + PUSH * self.pushes
        sizes = (
            0, FOLLOWED * self.entries, LEAN_FLOATS * n, LEANER_FLOATS * n, FIRST_FLOATS * n + equations,
            POSE_FLOATS * n,
        )  # fmt: skip
        return tuple(accumulate(sizes))

    @property
    def floats(self) -> int:
        """Numbers that an instance has there."""
        return self.starts[self.main]


def apart_of(dtype: Any, name: str) -> Any:
    """A Warp function (buffer, first, record, offset, count, instance, size) -> view of part of what is in main memory.

    An instance has `size` numbers there, of which `first` come before so many records of `record` numbers, in each of
    which `offset` come before what is looked at.
    """
    snippet = f"""
const unsigned group = unsigned(instance) / {SIDE}u, place = unsigned(instance) % {SIDE}u;
wp::array_t<{name}> part(
    reinterpret_cast<{name}*>(
        reinterpret_cast<wp::float32*>(buffer & ~wp::uint64({ALIGNED - 1})) + size_t(group) * ({SIDE} * size)
        + place * record + {SIDE} * first + offset),
    count);
part.strides[0] = {4 * SIDE} * record;
return part;
"""

    @wp.func_native(snippet=snippet)
    def part(
        buffer: wp.uint64, first: int, record: int, offset: int, count: int, instance: int, size: int
    ) -> wp.array[dtype]: ...

    return part


floats_apart = apart_of(float, "wp::float32")
integers_apart = apart_of(int, "wp::int32")
vectors_apart = apart_of(wp.vec3, "wp::vec3")
quaternions_apart = apart_of(wp.quat, "wp::quat")
matrices_apart = apart_of(wp.mat33, "wp::mat33")
symmetric_apart = apart_of(symmetric, "wp::vec_t<6, wp::float32>")


@func
def poses_near(memory: wp.array[float], n: int, slots: int) -> Scratch:
    """What `scratch.work_at` says where only places of bodies are near: paths read these more than all else."""
    w = Scratch()
    w.orientation = quaternions_at(memory, 0, POSE, n)
    w.position = vectors_at(memory, 4, POSE, n)
    return w


@func
def nothing_near(memory: wp.array[float], n: int, slots: int) -> Scratch:
    """The same where all of it is in main memory."""
    return Scratch()


@wp.func_native(snippet=f"return rotation.strides[0] == {4 * SIDE * ROTATION};")
def is_apart(rotation: wp.array[wp.mat33]) -> bool: ...  # known as a kernel is compiled


@func
def rotation_of(body: int, work: ScratchRef) -> wp.mat33:
    """The rotation of a body, anew from its orientation where it is in main memory: the same bits of four numbers."""
    if is_apart(work.rotation):
        return rotation_matrix(work.orientation[body])
    return work.rotation[body]


def ahead_of(fields: tuple[str, ...]) -> Any:
    """A Warp function (k, work) that lets the second cache fetch what fields have of body k, if in main memory.

    No lane waits for that, and no number depends on it: who goes from body to body asks so for the one behind.

    Args:
        fields: one of each record.
    """
    asked = "\n".join(
        f'asm volatile("prefetch.global.L2 [%0];" :: "l"(wp::address(work.{name}, k)));' for name in fields
    )
    snippet = f"""
#if defined(__CUDA_ARCH__)
if (work.rotation.strides[0] == {4 * SIDE * ROTATION}) {{
{asked}
}}
#endif
"""

    @wp.func_native(snippet=snippet)
    def ahead(k: int, work: ScratchRef): ...

    return ahead


PLACED = (
    "turned", "anchor", "rate", "parent_rate", "coordinate_turning", "coordinate_drift", "coordinate_turning_drift",
)  # fmt: skip
REDUCED = (
    "block_b", "block_a", "block_c", "bias_force", "rotation", "angular_velocity", "coordinate_turning",
    "coordinate_drift", "stiffness", "torque",
)  # fmt: skip
ACCELERATED = "rotation", "angular_velocity", "factor_a", "coordinate_turning", "coordinate_drift"
ahead_of_placing, ahead_of_reducing, ahead_of_accelerating = map(ahead_of, (PLACED, REDUCED, ACCELERATED))
ahead_of_inertia = ahead_of(("angular_velocity",))


@func
def apart_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, entries: int, size: int):
    """Views of what so many entries of `followed.py` leave in a GPU's main memory.

    Only a few lanes read it, one body after the other; other numbers make more of the shared memory.

    Args:
        size: numbers of an instance there.
    """
    w.followed_moment = vectors_apart(buffer, 0, 3, 0, entries, instance, size)
    w.followed_force = vectors_apart(buffer, 3 * entries, 3, 0, entries, instance, size)
    w.followed_along = vectors_apart(buffer, 6 * entries, 3, 0, entries, instance, size)
    w.followed_response = vectors_apart(buffer, 9 * entries, 3, 0, entries, instance, size)
    w.followed_bias = floats_apart(buffer, 12 * entries, 1, 0, entries, instance, size)


@func
def lean_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, n: int, first: int, size: int):
    """Views of what passes over the tree read once or twice for each of n bodies, in main memory, too.

    There nothing takes another's place.

    Args:
        first, size: numbers that come before, and of an instance there.
    """
    w.coordinate_turning = vectors_apart(buffer, first, 6, 0, n, instance, size)
    w.coordinate_moving = vectors_apart(buffer, first, 6, 3, n, instance, size)
    w.coordinate_drift = vectors_apart(buffer, first + 6 * n, 6, 0, n, instance, size)
    w.coordinate_state = vectors_apart(buffer, first + 6 * n, 6, 3, n, instance, size)
    w.velocity = vectors_apart(buffer, first + 12 * n, 6, 0, n, instance, size)
    w.lag_velocity = vectors_apart(buffer, first + 12 * n, 6, 3, n, instance, size)
    w.lag_angular = vectors_apart(buffer, first + 18 * n, 3, 0, n, instance, size)
    w.bias_force = vectors_apart(buffer, first + 21 * n, 3, 0, n, instance, size)
    w.factor_a = matrices_apart(buffer, first + 24 * n, 12, 0, n, instance, size)


@func
def leaner_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, n: int, first: int, size: int):
    """Views of the second block of `scratch.work_at` but for shapes and shares, which such models do without."""
    w.turned = quaternions_apart(buffer, first, 4, 0, n, instance, size)
    w.target = quaternions_apart(buffer, first, 4, 0, n, instance, size)
    w.block_b = matrices_apart(buffer, first + 4 * n, 12, 0, n, instance, size)
    w.bias_moment = vectors_apart(buffer, first + 4 * n, 12, 9, n, instance, size)
    w.block_a = symmetric_apart(buffer, first + 16 * n, 6, 0, n, instance, size)
    w.block_c = symmetric_apart(buffer, first + 22 * n, 6, 0, n, instance, size)
    w.anchor = vectors_apart(buffer, first + 28 * n, 3, 0, n, instance, size)
    w.rate = vectors_apart(buffer, first + 31 * n, 6, 0, n, instance, size)
    w.moment = vectors_apart(buffer, first + 31 * n, 6, 0, n, instance, size)
    w.angular_acceleration = vectors_apart(buffer, first + 31 * n, 6, 0, n, instance, size)
    w.gain = vectors_apart(buffer, first + 31 * n, 6, 3, n, instance, size)
    w.momentum = vectors_apart(buffer, first + 31 * n, 6, 3, n, instance, size)
    w.acceleration = vectors_apart(buffer, first + 31 * n, 6, 3, n, instance, size)
    w.parent_rate = vectors_apart(buffer, first + 37 * n, 6, 0, n, instance, size)
    w.parent_gain = vectors_apart(buffer, first + 37 * n, 6, 3, n, instance, size)
    w.joint_velocity = vectors_apart(buffer, first + 43 * n, 3, 0, n, instance, size)
    w.strength = floats_apart(buffer, first + 46 * n, 1, 0, n, instance, size)
    w.frame = integers_apart(buffer, first + 47 * n, 1, 0, n, instance, size)


@func
def first_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, n: int, first: int, size: int):
    """Views of what is left of the first block but for places of bodies."""
    w.rotation = matrices_apart(buffer, first, ROTATION, 0, n, instance, size)
    w.turn_rates = matrices_apart(buffer, first, ROTATION, 0, n, instance, size)
    w.bias = vectors_apart(buffer, first, ROTATION, 9, n, instance, size)
    w.factor_b = matrices_apart(buffer, first + 12 * n, 12, 0, n, instance, size)
    w.move_rates = matrices_apart(buffer, first + 12 * n, 12, 0, n, instance, size)
    w.factor_c = vectors_apart(buffer, first + 12 * n, 12, 9, n, instance, size)
    w.stiffness = symmetric_apart(buffer, first + 24 * n, 6, 0, n, instance, size)
    w.angular_velocity = vectors_apart(buffer, first + 30 * n, 3, 0, n, instance, size)
    w.torque = vectors_apart(buffer, first + 33 * n, 3, 0, n, instance, size)
    w.coordinate_turning_drift = vectors_apart(buffer, first + 33 * n, 3, 0, n, instance, size)


@func
def poses_at(w: wp.ref[Scratch], buffer: wp.uint64, instance: int, n: int, first: int, size: int):
    """Views of places of bodies."""
    w.orientation = quaternions_apart(buffer, first, POSE, 0, n, instance, size)
    w.position = vectors_apart(buffer, first, POSE, 4, n, instance, size)


@func
def rest_at(
    w: wp.ref[Scratch], buffer: wp.uint64, i: int, slots: int, unknowns: int, pushes: int, first: int, size: int
):
    """Views of feet, of what the whole body has, and of the equations of what stays open to the root."""
    w.contact_b = matrices_apart(buffer, first, 9, 0, slots, i, size)
    w.contact_c = symmetric_apart(buffer, first + 9 * slots, 6, 0, slots, i, size)
    w.contact_force = vectors_apart(buffer, first + 15 * slots, 3, 0, slots, i, size)
    rest = first + SLOT_FLOATS * slots
    w.center = vectors_apart(buffer, rest, 3, 0, 2, i, size)
    w.flags = integers_apart(buffer, rest + 6, 1, 0, 2, i, size)
    w.near = integers_apart(buffer, rest + 8, 1, 0, 1, i, size)
    equations = rest + OTHER_FLOATS
    w.followed_matrix = floats_apart(buffer, equations, 1, 0, unknowns * unknowns, i, size)
    w.followed_acceleration = floats_apart(buffer, equations + unknowns * unknowns, 1, 0, unknowns, i, size)
    last = equations + unknowns * (unknowns + 1)
    w.push_force = vectors_apart(buffer, last, 3, 0, pushes, i, size)
    w.push_moment = vectors_apart(buffer, last + 3 * pushes, 3, 0, pushes, i, size)
    w.push_other_moment = vectors_apart(buffer, last + 6 * pushes, 3, 0, pushes, i, size)
    w.push_wanted = floats_apart(buffer, last + 9 * pushes, 1, 0, pushes, i, size)
    w.push_mobility = floats_apart(buffer, last + 10 * pushes, 1, 0, pushes, i, size)


@cache
def main_memory_of(apart: Apart, behind: int) -> Any:
    """The Warp function (w, buffer, instance) that puts the views of all that is apart into a working set.

    Args:
        behind: numbers that a buffer has before: a thread of a CPU has its working set in the same one.
    """
    main, entries, n, slots, unknowns, pushes = apart
    size, starts = apart.floats, apart.starts
    lean, leaner, leanest, whole = main >= LEAN, main >= LEANER, main >= LEANEST, main >= ALL
    put_lean, put_leaner = lean_at if lean else None, leaner_at if leaner else None
    put_first, put_rest = (first_at, rest_at) if leanest else (None, None)
    put_poses = poses_at if whole else None
    to_lean, to_leaner, to_first = starts[ENTRIES], starts[LEAN], starts[LEANER]
    to_rest, to_poses = to_first + FIRST_FLOATS * n, starts[LEANEST]

    @func
    def in_main_memory(w: wp.ref[Scratch], buffer: wp.uint64, instance: int):
        own = buffer + wp.static(wp.uint64(4 * behind))
        apart_at(w, own, instance, entries, size)
        if wp.static(lean):
            put_lean(w, own, instance, n, to_lean, size)
        if wp.static(leaner):
            put_leaner(w, own, instance, n, to_leaner, size)
        if wp.static(leanest):
            put_first(w, own, instance, n, to_first, size)
            put_rest(w, own, instance, slots, unknowns, pushes, to_rest, size)
        if wp.static(whole):
            put_poses(w, own, instance, n, to_poses, size)

    return in_main_memory
