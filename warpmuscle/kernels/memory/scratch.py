"""Lanes that share an instance, and where the instance's working set lives.

On the GPU the lanes of an instance are neighbours in one warp and the working set is in shared memory; where muscles'
paths are long, neighbours are the same lane of up to 32 instances instead. On the CPU there is one lane, and the
working set is a buffer of the calling thread. The capacity in bodies is all that is compiled into the fused step, so
that one kernel serves every model of a size class.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import Scratch

CAPACITY_STEP = 5  # bodies; the 15 bodies of the SIMBICON biped fill a class exactly
FIRST, SECOND, CONTROL = 44, 24, 12  # floats a body in the two blocks of `work_at`; of the controller in the second
SLOT_FLOATS = 18
COORDINATE = 9  # floats a body, of joints of one coordinate where there are some
FOLLOWED = 13  # floats of a body and a followed coordinate that acts on it, see `followed.py`
PUSH = 11  # floats a row of a constraint, see `constraints.py`
OTHER_FLOATS = 9
POSE = 8  # floats a body of what `main_memory.poses_near` keeps, one of them unused
LEAN_FIRST = 32  # floats a body in the first block where the last ones are elsewhere, see `main_memory.lean_at`
NEAR, ENTRIES, LEAN, LEANER, LEANEST, ALL = range(6)  # how much is in main memory: each has all of the one before
SHAPES_A_BODY = 4  # that may collide, on average
PULLS_A_BODY = 4  # crossings of muscles, on average; those of more are kept in the state


# Parts of a step that use the working set, in their order.
PHASES = (
    "joints", "poses", "sums", "failure", "collision", "control", "effort", "muscles", "objective", "record", "motion",
    "inertia", "backward", "forward", "acted", "integration", "feet",
)  # fmt: skip


class Life(NamedTuple):
    """From when to when something in the working set is needed; then its place may be taken."""

    first: str  # phase that writes it
    last: str  # phase that reads it for the last time; whoever takes its place then reads what it needs before
    root: str = ""  # the same of the root's, where it lives longer; what takes the place has nothing of the root


LIVES = {
    **dict.fromkeys(("turned", "rate", "gain", "parent_rate", "parent_gain", "anchor"), Life("joints", "poses")),
    "orientation": Life("poses", "record", root="integration"),
    **dict.fromkeys(("rotation", "bias", "position", "angular_velocity"), Life("poses", "acted")),
    **dict.fromkeys(("velocity", "lag_angular", "lag_velocity"), Life("poses", "inertia")),
    **dict.fromkeys(("moment", "momentum"), Life("sums", "sums")),
    "center": Life("sums", "record"),
    "flags": Life("failure", "feet"),
    "near": Life(PHASES[0], PHASES[-1]),  # kept from step to step
    **dict.fromkeys(("shape_middle", "shape_half"), Life("collision", "collision")),
    **dict.fromkeys(("torque", "stiffness"), Life("control", "backward")),
    **dict.fromkeys(("strength", "frame"), Life("control", "control")),
    "target": Life("control", "effort"),
    **dict.fromkeys(("joint_velocity", "pull", "monomial"), Life("muscles", "muscles")),
    **dict.fromkeys(("price", "lack", "softness", "dearest", "share"), Life("muscles", "muscles")),
    **dict.fromkeys(("block_a", "block_b", "block_c", "bias_moment"), Life("inertia", "forward")),
    "bias_force": Life("inertia", "forward"),
    **dict.fromkeys(("contact_b", "contact_c"), Life("inertia", "forward")),
    "contact_force": Life("inertia", "feet"),
    **dict.fromkeys(("factor_a", "factor_b"), Life("backward", "forward")),
    "factor_c": Life("backward", "integration"),
    **dict.fromkeys(("angular_acceleration", "acceleration"), Life("forward", "integration")),
    "coordinate_turning_drift": Life("joints", "poses"),
    **dict.fromkeys(("turn_rates", "move_rates"), Life("joints", "joints")),
    "coordinate_state": Life("joints", "muscles"),
    **dict.fromkeys(("coordinate_turning", "coordinate_moving", "coordinate_drift"), Life("joints", "forward")),
    **dict.fromkeys(
        ("followed_moment", "followed_force", "followed_along", "followed_response", "followed_bias"),
        Life("backward", "forward"),
    ),
    **dict.fromkeys(("followed_matrix", "followed_acceleration"), Life("backward", "forward")),
    **dict.fromkeys(("push_force", "push_moment", "push_other_moment", "push_wanted"), Life("motion", "forward")),
    "push_mobility": Life("forward", "forward"),
}
APART = ("center", "flags", "near")  # whose places nothing else takes


def capacity_of(bodies: int) -> int:
    """Size class of a model: the number of bodies that its kernel has room for."""
    return -(-bodies // CAPACITY_STEP) * CAPACITY_STEP


def slots_of(capacity: int) -> int:
    """Foot slots in a size class: both feet and their children."""
    return max(4, capacity // 3)


def slots_for(capacity: int, floats: int, least: int) -> int:
    """Foot slots, at least so many, that make room for so many numbers of muscles: contacts are not needed yet."""
    return max(least, -(-(floats - (SECOND - CONTROL) * capacity) // SLOT_FLOATS))


def first_of(main: int) -> int:
    """Floats a body in the first block of `work_at`, with so much in main memory."""
    return FIRST if main < LEAN else LEAN_FIRST


def second_of(main: int) -> int:
    """The same in the second block."""
    return SECOND if main < LEANER else 0


def coordinate_of(main: int) -> int:
    """The same in the block of joints of one coordinate."""
    return COORDINATE if main < LEAN else 0


def floats_a_body(main: int) -> int:
    """The same of all three blocks."""
    return first_of(main) + second_of(main) + coordinate_of(main)


def followed_floats(followed: int, entries: int, pushes: int = 0) -> int:
    """Numbers of so many followed coordinates: of bodies that they act on, and their equations; some are pushes.

    Args:
        entries: pairs of a body and one of them. pushes: those of them that are rows of constraints.
    """
    return FOLLOWED * entries + followed * (followed + 1) + PUSH * pushes


def work_floats(
    capacity: int, coordinate_joints: bool = False, monomials: int = 0, slots: int | None = None, followed: int = 0,
    pushes: int = 0, entries: int | None = None, main: int = NEAR,
) -> int:  # fmt: skip
    """Size of the working set of one instance in floats (4 bytes each): an odd multiple of 8.

    So lanes of two instances that read the same thing of the same body find it in different banks of shared memory.
    Where joints are of one coordinate it is an odd multiple of 4, and so are those of eight neighbours.

    Args:
        coordinate_joints: whether there are joints as in `coordinate_joint.py`.
        monomials: of paths that are polynomials. slots: of feet, see `slots_for`; None for those of the size class, in
            which there need not be room for monomials, so that they come last.
        followed: coordinates that stay open to the root. pushes: those of them that are rows of constraints.
        entries: pairs of a body and one of them that acts on it; None for all pairs.
        main: how much of it is in main memory, see `main_memory.py`; only with coordinate joints.
    """
    if main >= LEANEST:
        floats = POSE * capacity if main == LEANEST else 0
        return floats + (4 - floats) % 8
    entries = followed * capacity if entries is None else entries
    floats = (first_of(main) + second_of(main)) * capacity + OTHER_FLOATS
    floats += SLOT_FLOATS * slots_of(capacity) + monomials if slots is None else SLOT_FLOATS * slots
    if coordinate_joints:
        floats += coordinate_of(main) * capacity + followed_floats(followed, entries, pushes)
        return floats + (4 - floats) % 8
    return floats + (8 - floats) % 16


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
#if WP_TILE_BLOCK_DIM > 32
__syncthreads();
#else
__syncwarp();
#endif
#endif
"""
)
def synchronize(): ...  # the lanes of an instance, and of those that share a block with it


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
#if WP_TILE_BLOCK_DIM > 32
return __syncthreads_or(flag);
#else
return __any_sync(0xffffffffu, flag);
#endif
#else
return flag;
#endif
"""
)
def any_lane(flag: bool) -> bool: ...  # of those that `synchronize` waits for


def part_of(dtype: Any, name: str) -> Any:
    """A Warp function (memory, first, stride, count) -> view of part of a working set as an array of a type.

    First and stride are counted in floats. Made from the pointer itself: from a number, the compiler would not know
    that it points to shared memory.
    """
    snippet = f"""
wp::array_t<{name}> part(reinterpret_cast<{name}*>(memory.data + first), count);
part.strides[0] = 4 * stride;
return part;
"""

    @wp.func_native(snippet=snippet)
    def part(memory: wp.array[float], first: int, stride: int, count: int) -> wp.array[dtype]: ...

    return part


floats_at = part_of(float, "wp::float32")
integers_at = part_of(int, "wp::int32")
vectors_at = part_of(wp.vec3, "wp::vec3")
quaternions_at = part_of(wp.quat, "wp::quat")
matrices_at = part_of(wp.mat33, "wp::mat33")
symmetric_at = part_of(symmetric, "wp::vec_t<6, wp::float32>")


@cache
def work_at_of(main: int) -> Any:
    """The Warp function `work_at`, where `main_memory.py` then puts so much of it into main memory."""
    first, other = first_of(main), second_of(main)

    @func
    def work_at(memory: wp.array[float], n: int, slots: int) -> Scratch:
        """Views on the working set in some memory, with room for n bodies.

        What belongs to a body lies together, so that one address leads to all of it, in two blocks of multiples of four
        numbers, which a lane fetches at once.
        What a step no longer needs gives its place to what it needs then: `LIVES` says from when to when that is.
        In the second block six groups live one after the other: motions of the joints, sums of the kinematics, shapes
        that may collide, the controller's targets with joint velocities and the muscles' pulls, the articulated
        inertia, and accelerations. Where torques are shared out, prices and shares take the places of targets and
        contacts.
        The joint factors of the backward pass take the places of the velocities and their lags, of the same
        joint's torque and stiffness, and of the same body's orientation; the root, which keeps its own, has no joint.
        """
        w = Scratch()
        w.orientation = quaternions_at(memory, 0, first, n)
        w.factor_c = vectors_at(memory, 0, first, n)
        w.rotation = matrices_at(memory, 4, first, n)
        w.position = vectors_at(memory, 13, first, n)
        w.angular_velocity = vectors_at(memory, 16, first, n)
        w.bias = vectors_at(memory, 19, first, n)
        w.torque = vectors_at(memory, 22, first, n)
        w.stiffness = symmetric_at(memory, 25, first, n)
        w.factor_b = matrices_at(memory, 22, first, n)
        w.velocity = vectors_at(memory, 31, first, n)
        w.lag_angular = vectors_at(memory, 34, first, n)
        w.lag_velocity = vectors_at(memory, 37, first, n)
        w.factor_a = matrices_at(memory, 31, first, n)
        w.bias_force = vectors_at(memory, 40, first, n)
        second = first * n
        w.turned = quaternions_at(memory, second, SECOND, n)
        w.rate = vectors_at(memory, second + 4, SECOND, n)
        w.gain = vectors_at(memory, second + 7, SECOND, n)
        w.parent_rate = vectors_at(memory, second + 10, SECOND, n)
        w.parent_gain = vectors_at(memory, second + 13, SECOND, n)
        w.anchor = vectors_at(memory, second + 16, SECOND, n)
        w.moment = vectors_at(memory, second, SECOND, n)
        w.momentum = vectors_at(memory, second + 3, SECOND, n)
        w.shape_middle = vectors_at(memory, second, 6, SHAPES_A_BODY * n)
        w.shape_half = vectors_at(memory, second + 3, 6, SHAPES_A_BODY * n)
        w.block_a = symmetric_at(memory, second, SECOND, n)
        w.block_b = matrices_at(memory, second + 6, SECOND, n)
        w.block_c = symmetric_at(memory, second + 15, SECOND, n)
        w.bias_moment = vectors_at(memory, second + 21, SECOND, n)
        w.angular_acceleration = vectors_at(memory, second, SECOND, n)
        w.acceleration = vectors_at(memory, second + 3, SECOND, n)
        w.target = quaternions_at(memory, second, CONTROL, n)
        w.strength = floats_at(memory, second + 4, CONTROL, n)
        w.frame = integers_at(memory, second + 5, CONTROL, n)
        w.joint_velocity = vectors_at(memory, second + 6, CONTROL, n)
        w.price = vectors_at(memory, second, CONTROL, n)
        w.lack = vectors_at(memory, second + 3, CONTROL, n)
        w.softness = floats_at(memory, second + 9, CONTROL, n)
        w.dearest = floats_at(memory, second + 10, CONTROL, n)
        w.pull = vectors_at(memory, second + CONTROL * n, 3, PULLS_A_BODY * n)
        feet = second + other * n
        w.share = floats_at(memory, feet, 1, SLOT_FLOATS * slots)
        w.contact_b = matrices_at(memory, feet, SLOT_FLOATS, slots)
        w.contact_c = symmetric_at(memory, feet + 9, SLOT_FLOATS, slots)
        w.contact_force = vectors_at(memory, feet + 15, SLOT_FLOATS, slots)
        rest = feet + SLOT_FLOATS * slots
        w.center = vectors_at(memory, rest, 3, 2)
        w.flags = integers_at(memory, rest + 6, 1, 2)
        w.near = integers_at(memory, rest + 8, 1, 1)
        return w

    return work_at


work_at = work_at_of(NEAR)


@cache
def coordinate_work_at_of(main: int) -> Any:
    """The Warp function `coordinate_work_at`; see above."""
    first, own, any_work_at = first_of(main), COORDINATE, work_at_of(main)
    two_blocks = first + second_of(main)

    @func
    def coordinate_work_at(memory: wp.array[float], n: int, slots: int) -> Scratch:
        """The same where there are joints of one coordinate, which have a block of their own behind all others."""
        w = any_work_at(memory, n, slots)
        block = two_blocks * n + SLOT_FLOATS * slots + OTHER_FLOATS
        w.coordinate_turning = vectors_at(memory, block, own, n)
        w.coordinate_moving = vectors_at(memory, block + 3, own, n)
        w.coordinate_drift = vectors_at(memory, block + 6, own, n)
        w.coordinate_turning_drift = vectors_at(memory, 22, first, n)
        w.coordinate_state = vectors_at(memory, 40, first, n)
        w.turn_rates = matrices_at(memory, 4, first, n)
        w.move_rates = matrices_at(memory, 13, first, n)
        return w

    return coordinate_work_at


coordinate_work_at = coordinate_work_at_of(NEAR)


@cache
def followed_work_at_of(followed: int, entries: int, main: int = NEAR) -> Any:
    """`coordinate_work_at` where so many coordinates stay open to the root, in a block behind that.

    Args:
        entries: pairs of a body and one of them that acts on it.
    """
    a_body, any_work_at = floats_a_body(main), coordinate_work_at_of(main)

    @wp.func
    def followed_work_at(memory: wp.array[float], n: int, slots: int) -> Scratch:
        w = any_work_at(memory, n, slots)
        block = a_body * n + SLOT_FLOATS * slots + OTHER_FLOATS
        w.followed_moment = vectors_at(memory, block, FOLLOWED, entries)
        w.followed_force = vectors_at(memory, block + 3, FOLLOWED, entries)
        w.followed_along = vectors_at(memory, block + 6, FOLLOWED, entries)
        w.followed_response = vectors_at(memory, block + 9, FOLLOWED, entries)
        w.followed_bias = floats_at(memory, block + 12, FOLLOWED, entries)
        end = block + FOLLOWED * entries
        w.followed_matrix = floats_at(memory, end, 1, followed * followed)
        w.followed_acceleration = floats_at(memory, end + followed * followed, 1, followed)
        return w

    return followed_work_at


@cache
def pushed_work_at_of(followed: int, entries: int, pushes: int, main: int = NEAR) -> Any:
    """The same where so many of these are rows of constraints, which have a block behind that."""
    a_body, followed_work_at = floats_a_body(main), followed_work_at_of(followed, entries, main)

    @wp.func
    def pushed_work_at(memory: wp.array[float], n: int, slots: int) -> Scratch:
        w = followed_work_at(memory, n, slots)
        before = a_body * n + SLOT_FLOATS * slots + OTHER_FLOATS
        last = before + FOLLOWED * entries + followed * (followed + 1)
        w.push_force = vectors_at(memory, last, PUSH, pushes)
        w.push_moment = vectors_at(memory, last + 3, PUSH, pushes)
        w.push_other_moment = vectors_at(memory, last + 6, PUSH, pushes)
        w.push_wanted = floats_at(memory, last + 9, PUSH, pushes)
        w.push_mobility = floats_at(memory, last + 10, PUSH, pushes)
        return w

    return pushed_work_at


@func
def monomials_at(memory: wp.array[float], count: int) -> wp.array[float]:
    """Where the monomials of paths are, behind all else in some memory."""
    return floats_at(memory, memory.shape[0] - count, 1, count)


@func
def monomials_before_contacts(memory: wp.array[float], n: int, slots: int, count: int) -> wp.array[float]:
    """The same where feet have as many slots as `slots_for` says: the last in the places of contacts."""
    return floats_at(memory, (FIRST + SECOND) * n + SLOT_FLOATS * slots - count, 1, count)


@cache
def work_memory(floats: int, instances_per_block: int, asked: bool = False) -> Any:
    """A Warp function (place in the block, CPU buffer) -> memory of an instance's working set of so many floats.

    Args:
        asked: whether a GPU's block has been given the memory as it was launched, and need not declare it.
    """
    declared = f"__shared__ float warpmuscle_work[{instances_per_block * floats}];"
    if asked:
        declared = "extern __shared__ char dynamic_smem_base[]; auto warpmuscle_work = (float*)dynamic_smem_base;"

    snippet = f"""
#if defined(__CUDA_ARCH__)
{declared}
return wp::array_t<float>(warpmuscle_work + place * {floats}, {floats});
#else
return wp::array_t<float>(reinterpret_cast<float*>(buffer), {floats});
#endif
"""

    @wp.func_native(snippet=snippet)
    def memory(place: int, buffer: wp.uint64) -> wp.array[float]: ...

    return memory
