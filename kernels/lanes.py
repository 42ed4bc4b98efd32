"""Lanes that share an instance, and where the instance's working set lives.

On the GPU the lanes of an instance are neighbours in one warp and the working set is in shared memory; on the CPU
there is one lane, and the working set is a buffer of the calling thread. The capacity in bodies is all that is
compiled into the fused step, so that one kernel serves every model of a size class.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.structs import Work

CAPACITY_STEP = 5  # bodies; the 15 bodies of the SIMBICON biped fill a class exactly
BODY_FLOATS = 82
SLOT_FLOATS = 18
OTHER_FLOATS = 8
SHAPES_A_BODY = 4  # that may collide, on average


def capacity_of(bodies: int) -> int:
    """Size class of a model: the number of bodies that its kernel has room for."""
    return -(-bodies // CAPACITY_STEP) * CAPACITY_STEP


def slots_of(capacity: int) -> int:
    """Foot slots in a size class: both feet and their children."""
    return max(4, capacity // 3)


def work_floats(capacity: int) -> int:
    """Size of the working set of one instance in floats (4 bytes each)."""
    return BODY_FLOATS * capacity + SLOT_FLOATS * slots_of(capacity) + OTHER_FLOATS


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
__syncwarp();
#endif
"""
)
def synchronize(): ...


@wp.func
def after(address: wp.uint64, floats: int) -> wp.uint64:
    """The address so many floats further on."""
    return address + wp.uint64(4 * floats)


@wp.func
def work_at(address: wp.uint64, n: int, slots: int) -> Work:
    """Views on the working set at an address, with room for n bodies.

    Five groups live one after the other in the same 27 floats a body, as a step needs them: sums of the kinematics,
    shapes that may collide, the controller's targets with the joint velocities, the articulated inertia, and
    accelerations. The joint factors of the backward pass take the place of the velocities' lags.
    """
    w = Work()
    w.rotation = wp.array(ptr=address, shape=(n,), dtype=wp.mat33)
    w.orientation = wp.array(ptr=after(address, 9 * n), shape=(n,), dtype=wp.quat)
    w.position = wp.array(ptr=after(address, 13 * n), shape=(n,), dtype=wp.vec3)
    w.angular_velocity = wp.array(ptr=after(address, 16 * n), shape=(n,), dtype=wp.vec3)
    w.velocity = wp.array(ptr=after(address, 19 * n), shape=(n,), dtype=wp.vec3)
    w.bias = wp.array(ptr=after(address, 22 * n), shape=(n,), dtype=wp.vec3)
    w.torque = wp.array(ptr=after(address, 25 * n), shape=(n,), dtype=wp.vec3)
    w.stiffness = wp.array(ptr=after(address, 28 * n), shape=(n,), dtype=symmetric)
    w.factor_a = wp.array(ptr=after(address, 34 * n), shape=(n,), dtype=wp.mat33)
    w.lag_angular = wp.array(ptr=after(address, 34 * n), shape=(n,), dtype=wp.vec3)
    w.lag_velocity = wp.array(ptr=after(address, 37 * n), shape=(n,), dtype=wp.vec3)
    w.factor_b = wp.array(ptr=after(address, 43 * n), shape=(n,), dtype=wp.mat33)
    w.factor_c = wp.array(ptr=after(address, 52 * n), shape=(n,), dtype=wp.vec3)
    shared = after(address, 55 * n)
    w.moment = wp.array(ptr=shared, shape=(n,), dtype=wp.vec3)
    w.momentum = wp.array(ptr=after(shared, 3 * n), shape=(n,), dtype=wp.vec3)
    w.shape_middle = wp.array(ptr=shared, shape=(SHAPES_A_BODY * n,), dtype=wp.vec3)
    w.shape_half = wp.array(ptr=after(shared, 3 * SHAPES_A_BODY * n), shape=(SHAPES_A_BODY * n,), dtype=wp.vec3)
    w.target = wp.array(ptr=shared, shape=(n,), dtype=wp.quat)
    w.strength = wp.array(ptr=after(shared, 4 * n), shape=(n,), dtype=float)
    w.frame = wp.array(ptr=after(shared, 5 * n), shape=(n,), dtype=int)
    w.joint_velocity = wp.array(ptr=after(shared, 6 * n), shape=(n,), dtype=wp.vec3)
    w.block_a = wp.array(ptr=shared, shape=(n,), dtype=symmetric)
    w.block_b = wp.array(ptr=after(shared, 6 * n), shape=(n,), dtype=wp.mat33)
    w.block_c = wp.array(ptr=after(shared, 15 * n), shape=(n,), dtype=symmetric)
    w.bias_moment = wp.array(ptr=after(shared, 21 * n), shape=(n,), dtype=wp.vec3)
    w.bias_force = wp.array(ptr=after(shared, 24 * n), shape=(n,), dtype=wp.vec3)
    w.angular_acceleration = wp.array(ptr=shared, shape=(n,), dtype=wp.vec3)
    w.acceleration = wp.array(ptr=after(shared, 3 * n), shape=(n,), dtype=wp.vec3)
    feet = after(shared, 27 * n)
    w.contact_b = wp.array(ptr=feet, shape=(slots,), dtype=wp.mat33)
    w.contact_c = wp.array(ptr=after(feet, 9 * slots), shape=(slots,), dtype=symmetric)
    w.contact_force = wp.array(ptr=after(feet, 15 * slots), shape=(slots,), dtype=wp.vec3)
    w.center = wp.array(ptr=after(feet, 18 * slots), shape=(2,), dtype=wp.vec3)
    w.flags = wp.array(ptr=after(feet, 18 * slots + 6), shape=(2,), dtype=int)
    return w


@cache
def work_address(capacity: int, instances_per_block: int) -> Any:
    """A Warp function (place in the block, CPU buffer) -> address of an instance's working set, for a size class."""
    floats = work_floats(capacity)

    snippet = f"""
#if defined(__CUDA_ARCH__)
__shared__ float warpmuscle_work[{instances_per_block * floats}];
return (unsigned long long)(warpmuscle_work + place * {floats});
#else
return buffer;
#endif
"""

    @wp.func_native(snippet=snippet)
    def address(place: int, buffer: wp.uint64) -> wp.uint64: ...

    return address
