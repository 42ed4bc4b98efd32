"""The sizes of pushes that close loops, from the equations of `body.followed`, which may have them more than once.

With their rows J and the mass matrix M, -J M^-1 J^T stands between pushes. Rows that push as others together do share
what there is to push, since each gives way by a little, E x, and one along which nothing can move is left out. What
the pushes give way is taken back (iterated regularisation, Riley 1955, Math. Tables Aids Comput. 9:96-101),

    x = d_0 + d_1 + ...,    (J M^-1 J^T + E) d_0 = r,    (J M^-1 J^T + E) d_n = E d_(n-1),

until it is less than GIVING. Where nothing moves, all d_n are d_0, which is of rounding alone: where the sum ends at
its greatest length N, the last term counts 1 - N times, so that they add up to one d_0.
"""

import warp as wp

from warpmuscle.kernels.constraint.constraints import QUICKEST, STIFFNESS
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import any_lane, synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at, nonnegative

YIELDING = 2.0e-5  # of the greatest mobility along rows that hold one point or one turn, by which each gives way
GIVING = 3.0e-7  # m or rad, that the last pushes may give way by, where more are not added
REFINEMENTS = 8  # times that pushes are added, at most
IMMOBILE = 1.0e-8  # of what bodies may move by, below which nothing can move along a row


@func
def free_mobility(instance: int, row: int, model: ModelRef, work: ScratchRef) -> float:
    """Along a row at the most, if no joint held its two bodies; of a force without what it turns."""
    one = at(model.skeleton.row, instance, nonnegative(model.constraints.body[row]))
    other = at(model.skeleton.row, instance, nonnegative(model.constraints.other[row]))
    if wp.length(work.push_force[row]) > 0.0:
        return 1.0 / one.mass + 1.0 / other.mass
    return 1.0 / wp.min(one.inertia) + 1.0 / wp.min(other.inertia)


@func
def mobilities(instance: int, count: int, first: int, model: ModelRef, work: ScratchRef):
    """The greatest one of the rows that hold one thing, such as a point, together with each row; 0: nothing moves.

    What is rounded off the way of a push to the root and back is a share of what moves most along any row, or of what
    moves if no joint holds the bodies, whichever is less: so light parts say nothing of heavy ones.
    """
    largest = wp.float32(0.0)
    for row in range(first, count):
        largest = wp.max(largest, wp.abs(work.followed_matrix[row * count + row]))
    for row in range(first, count):
        greatest = wp.float32(0.0)
        for beside in range(first, count):
            if model.constraints.held[beside - first] == model.constraints.held[row - first]:
                greatest = wp.max(greatest, wp.abs(work.followed_matrix[beside * count + beside]))
        least = IMMOBILE * wp.min(largest, free_mobility(instance, row - first, model, work))
        work.push_mobility[row - first] = wp.where(greatest > least, greatest, 0.0)


@func
def eliminate(lane: int, lanes: int, k: int, count: int, work: ScratchRef):
    """Take an unknown out of the equations behind it. What stands below the pivot stays there, for later right sides.

    Each lane takes other rows. Ends with a barrier.
    """
    pivot = work.followed_matrix[k * count + k]
    if pivot != 0.0:
        for i in range(k + 1 + lane, count, lanes):
            factor = work.followed_matrix[i * count + k] / pivot
            for l in range(k + 1, count):  # noqa: E741
                taken = factor * work.followed_matrix[k * count + l]
                work.followed_matrix[i * count + l] = work.followed_matrix[i * count + l] - taken
            work.followed_acceleration[i] = work.followed_acceleration[i] - factor * work.followed_acceleration[k]
    synchronize()


@func
def eliminate_right(lane: int, lanes: int, count: int, first: int, work: ScratchRef):
    """Do to a new right side of the pushes, in `push_wanted`, what has been done to the first one. With barriers."""
    for k in range(first, count):
        pivot = work.followed_matrix[k * count + k]
        if pivot != 0.0:
            share = work.push_wanted[k - first] / pivot
            for i in range(k + 1 + lane, count, lanes):
                taken = work.followed_matrix[i * count + k] * share
                work.push_wanted[i - first] = work.push_wanted[i - first] - taken
        synchronize()


@func
def add_pushes(weight: float, lane: int, lanes: int, count: int, first: int, work: ScratchRef):
    """Pushes of a right side in `push_wanted`, in its place; so many times they are added to those of before.

    With barriers.
    """
    for step in range(count - first):
        k = count - 1 - step
        pivot = work.followed_matrix[k * count + k]
        push = wp.float32(0.0)
        if pivot != 0.0:
            push = work.push_wanted[k - first] / pivot
        for i in range(first + lane, k, lanes):
            taken = work.followed_matrix[i * count + k] * push
            work.push_wanted[i - first] = work.push_wanted[i - first] - taken
        synchronize()
        if lane == 0:
            work.push_wanted[k - first] = push
            work.followed_acceleration[k] = work.followed_acceleration[k] + weight * push
    synchronize()


@func
def gives(count: int, first: int, model: ModelRef, work: ScratchRef) -> bool:
    """Whether constraints give way by more than they may by the pushes that were added last."""
    pace = wp.max(model.time_step, QUICKEST)
    largest = wp.float32(0.0)
    for row in range(count - first):
        largest = wp.max(largest, wp.abs(work.push_mobility[row] * work.push_wanted[row]))
    return YIELDING * largest * pace * pace > STIFFNESS * GIVING


@func
def refine(lane: int, lanes: int, count: int, first: int, model: ModelRef, work: ScratchRef):
    """Add pushes that take back what the last ones, in `push_wanted`, give way. With barriers.

    Instances of one block go on together; those that are done add 0.
    """
    turn = wp.int32(0)  # a variable, for the loop
    again = gives(count, first, model, work)
    while any_lane(again) and turn < REFINEMENTS:
        for k in range(first + lane, count, lanes):
            yielding = wp.where(again, YIELDING * work.push_mobility[k - first], 0.0)
            work.push_wanted[k - first] = -yielding * work.push_wanted[k - first]
        synchronize()
        eliminate_right(lane, lanes, count, first, work)
        turn += 1
        weight = wp.where(turn == REFINEMENTS, 1.0 - wp.float32(REFINEMENTS), 1.0)
        add_pushes(weight, lane, lanes, count, first, work)
        again = again and gives(count, first, model, work)


@func
def substitute_back(open_yet: int, count: int, work: ScratchRef):
    """Find the unknowns before this one, the last first, from eliminated equations; those behind it are known."""
    for step in range(open_yet):
        k = open_yet - 1 - step
        right = work.followed_acceleration[k]
        for l in range(k + 1, count):  # noqa: E741
            right -= work.followed_matrix[k * count + l] * work.followed_acceleration[l]
        work.followed_acceleration[k] = right / work.followed_matrix[k * count + k]


@func
def solve_constrained(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
    """`followed.solve_followed` where rows from the first on are of pushes: D is negative there."""
    count = nonnegative(model.couplings.followed)
    first = nonnegative(model.constraints.first)
    for k in range(first):
        eliminate(lane, lanes, k, count, work)
    if lane == 0:
        mobilities(instance, count, first, model, work)
        for k in range(first, count):
            work.followed_matrix[k * count + k] -= YIELDING * work.push_mobility[k - first]
    synchronize()
    for k in range(first, count):
        if lane == 0 and work.push_mobility[k - first] == 0.0:
            work.followed_matrix[k * count + k] = 0.0
        synchronize()
        eliminate(lane, lanes, k, count, work)
    for k in range(first + lane, count, lanes):
        work.push_wanted[k - first] = work.followed_acceleration[k]
        work.followed_acceleration[k] = 0.0
    synchronize()
    add_pushes(1.0, lane, lanes, count, first, work)
    refine(lane, lanes, count, first, model, work)
    if lane == 0:
        substitute_back(first, count, work)
