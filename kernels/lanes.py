"""Lanes that share an instance, and where the instance's working set lives.

On the GPU the lanes of an instance are neighbours in one warp and the working set is in shared memory; on the CPU
there is one lane, and the working set is a buffer of the calling thread. The capacity in bodies is all that is
compiled in, so that one kernel serves every model of a size class.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.structs import Work

CAPACITY_STEP = 5  # bodies; the 15 bodies of the SIMBICON biped fill a class exactly
FLOAT_BYTES = 4

# Members of Work and their size in floats: by body, by foot slot, and once. Those in `SHARED` live one after the
# other in the same place: sums of the kinematics, the controller's targets, the articulated inertia, accelerations.
BY_BODY = {
    "rotation": 9, "orientation": 4, "position": 3, "angular_velocity": 3, "velocity": 3, "bias": 3, "torque": 3,
    "stiffness": 6, "factor_a": 9, "factor_b": 9, "factor_c": 3, "shared": 27,
}  # fmt: skip
BY_SLOT = {"contact_b": 9, "contact_c": 6, "contact_force": 3}
ONCE = {"center": 6, "flags": 2}
SHARED = (
    {"moment": 3, "momentum": 3},
    {"target": 4, "strength": 1, "frame": 1},
    {"block_a": 6, "block_b": 9, "block_c": 6, "bias_moment": 3, "bias_force": 3},
    {"angular_acceleration": 3, "acceleration": 3},
)


def capacity_of(bodies: int) -> int:
    """Size class of a model: the number of bodies that its kernel has room for."""
    return -(-bodies // CAPACITY_STEP) * CAPACITY_STEP


def slots_of(capacity: int) -> int:
    """Foot slots in a size class: both feet and their children."""
    return max(4, capacity // 3)


def layout(capacity: int) -> tuple[dict[str, int], int]:
    """Byte offsets of the members of Work, and the size of the whole in floats."""
    offsets: dict[str, int] = {}
    floats = 0
    for sizes, count in ((BY_BODY, capacity), (BY_SLOT, slots_of(capacity)), (ONCE, 1)):
        for name, size in sizes.items():
            offsets[name] = FLOAT_BYTES * floats
            floats += size * count
    start = offsets.pop("shared")
    for group in SHARED:
        used = 0
        for name, size in group.items():
            offsets[name] = start + FLOAT_BYTES * used
            used += size * capacity
    return offsets, floats


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
__syncwarp();
#endif
"""
)
def synchronize(): ...


@cache
def work_function(capacity: int, instances_per_block: int) -> Any:
    """A Warp function (slot in the block, CPU buffer) -> Work for a size class."""
    offset, floats = layout(capacity)
    slots = slots_of(capacity)
    snippet = f"""
#if defined(__CUDA_ARCH__)
__shared__ float warpmuscle_work[{instances_per_block * floats}];
return (unsigned long long)(warpmuscle_work + slot * {floats});
#else
return buffer;
#endif
"""

    @wp.func_native(snippet=snippet)
    def address(slot: int, buffer: wp.uint64) -> wp.uint64: ...

    @wp.func
    def view(slot: int, buffer: wp.uint64) -> Work:
        base = address(slot, buffer)
        w = Work()
        w.rotation = wp.array(ptr=base + wp.uint64(wp.static(offset["rotation"])), shape=(capacity,), dtype=wp.mat33)
        w.orientation = wp.array(
            ptr=base + wp.uint64(wp.static(offset["orientation"])), shape=(capacity,), dtype=wp.quat
        )
        w.position = wp.array(ptr=base + wp.uint64(wp.static(offset["position"])), shape=(capacity,), dtype=wp.vec3)
        w.angular_velocity = wp.array(
            ptr=base + wp.uint64(wp.static(offset["angular_velocity"])), shape=(capacity,), dtype=wp.vec3
        )
        w.velocity = wp.array(ptr=base + wp.uint64(wp.static(offset["velocity"])), shape=(capacity,), dtype=wp.vec3)
        w.bias = wp.array(ptr=base + wp.uint64(wp.static(offset["bias"])), shape=(capacity,), dtype=wp.vec3)
        w.center = wp.array(ptr=base + wp.uint64(wp.static(offset["center"])), shape=(2,), dtype=wp.vec3)
        w.moment = wp.array(ptr=base + wp.uint64(wp.static(offset["moment"])), shape=(capacity,), dtype=wp.vec3)
        w.momentum = wp.array(ptr=base + wp.uint64(wp.static(offset["momentum"])), shape=(capacity,), dtype=wp.vec3)
        w.target = wp.array(ptr=base + wp.uint64(wp.static(offset["target"])), shape=(capacity,), dtype=wp.quat)
        w.strength = wp.array(ptr=base + wp.uint64(wp.static(offset["strength"])), shape=(capacity,), dtype=float)
        w.frame = wp.array(ptr=base + wp.uint64(wp.static(offset["frame"])), shape=(capacity,), dtype=int)
        w.torque = wp.array(ptr=base + wp.uint64(wp.static(offset["torque"])), shape=(capacity,), dtype=wp.vec3)
        w.stiffness = wp.array(ptr=base + wp.uint64(wp.static(offset["stiffness"])), shape=(capacity,), dtype=symmetric)
        w.block_a = wp.array(ptr=base + wp.uint64(wp.static(offset["block_a"])), shape=(capacity,), dtype=symmetric)
        w.block_b = wp.array(ptr=base + wp.uint64(wp.static(offset["block_b"])), shape=(capacity,), dtype=wp.mat33)
        w.block_c = wp.array(ptr=base + wp.uint64(wp.static(offset["block_c"])), shape=(capacity,), dtype=symmetric)
        w.bias_moment = wp.array(
            ptr=base + wp.uint64(wp.static(offset["bias_moment"])), shape=(capacity,), dtype=wp.vec3
        )
        w.bias_force = wp.array(ptr=base + wp.uint64(wp.static(offset["bias_force"])), shape=(capacity,), dtype=wp.vec3)
        w.factor_a = wp.array(ptr=base + wp.uint64(wp.static(offset["factor_a"])), shape=(capacity,), dtype=wp.mat33)
        w.factor_b = wp.array(ptr=base + wp.uint64(wp.static(offset["factor_b"])), shape=(capacity,), dtype=wp.mat33)
        w.factor_c = wp.array(ptr=base + wp.uint64(wp.static(offset["factor_c"])), shape=(capacity,), dtype=wp.vec3)
        w.angular_acceleration = wp.array(
            ptr=base + wp.uint64(wp.static(offset["angular_acceleration"])), shape=(capacity,), dtype=wp.vec3
        )
        w.acceleration = wp.array(
            ptr=base + wp.uint64(wp.static(offset["acceleration"])), shape=(capacity,), dtype=wp.vec3
        )
        w.contact_b = wp.array(ptr=base + wp.uint64(wp.static(offset["contact_b"])), shape=(slots,), dtype=wp.mat33)
        w.contact_c = wp.array(ptr=base + wp.uint64(wp.static(offset["contact_c"])), shape=(slots,), dtype=symmetric)
        w.contact_force = wp.array(
            ptr=base + wp.uint64(wp.static(offset["contact_force"])), shape=(slots,), dtype=wp.vec3
        )
        w.flags = wp.array(ptr=base + wp.uint64(wp.static(offset["flags"])), shape=(2,), dtype=int)
        return w

    return view
