"""Coordinates that fit markers best: weighted least squares, one thread a frame.

Each frame minimises sum w |e|^2 of its markers' errors e, and of what coordinates are off their targets. Steps are
those of Levenberg and Marquardt at first, and of Newton near the solution, where large errors would make the former
slow, or damped where those have failed. The matrix J' W J is that of a tree of mass points, one of mass w at each
marker, so that it comes of composite inertias (Featherstone 2008, table 6.2) without J itself; Newton's takes off it
what the errors do with the turning of J. It is factorised as L' D L from the last coordinate on, which keeps the zeros
between branches (ibid., section 6.5). Limits are held by taking out coordinates that would leave them, and by clipping.
"""

import warp as wp

from warpmuscle.kernels.body.joint_motion import cubic_rates
from warpmuscle.kernels.marker_fit_structs import FitFrames, FitModel, FitScratch
from warpmuscle.kernels.structs import CubicPiece

wp.set_module_options({"enable_backward": False})

MOST_ITERATIONS = wp.constant(60)
LONGEST_STEP = wp.constant(0.5)  # rad, of any coordinate that turns something
CONVERGED = wp.constant(5.0e-6)  # rad or m, of the last step; the error left is a small part of it
LOOSE = wp.constant(3.0e-5)  # of its diagonal entry: a pivot below it comes of rounding
FLAT = wp.constant(1.0e-3)  # of its entry of J' W J: a pivot of Newton's below it leads too far, or to no minimum
NEAR = wp.constant(0.2)  # rad, of a step, after which Newton's are taken
OFTEN = wp.constant(4)  # steps that are of no use, after which Newton's are taken anywhere, damped
FIRST_DAMPING = wp.constant(1.0e-3)  # of the diagonal, once a step has made things worse
WORSE = wp.constant(1.0e-5)  # part by which the sum of squares may grow through rounding


@wp.func
def function_rates(piece: wp.array[CubicPiece], first: int, end: int, q: float) -> wp.vec3:
    """Value and derivatives of a piecewise cubic function."""
    low = int(first)
    high = int(end)
    while high - low > 1:
        middle = (low + high) // 2
        if piece[middle].start <= q:
            low = middle
        else:
            high = middle
    return cubic_rates(piece[low].c, q - piece[low].start)


@wp.func
def place_elements(frame: int, row: int, model: FitModel, value: wp.array2d[float], work: FitScratch):
    """Orientation and origin of all elements, and how each moves with its coordinate."""
    for k in range(model.element.shape[0]):
        own = model.element[k]
        turn = wp.quat(0.0, 0.0, 0.0, 1.0)
        origin = own.offset
        if own.parent >= 0:
            turn = work.orientation[row, own.parent]
            origin = work.origin[row, own.parent] + wp.quat_rotate(turn, own.offset)
        axis = wp.quat_rotate(turn, own.axis)
        q = wp.float32(0.0)
        if own.coordinate >= 0:
            q = value[frame, own.coordinate]
        f = function_rates(model.piece, own.first_piece, own.end_piece, q)
        if own.turns == 1:
            half = 0.5 * f[0]
            sine = wp.sin(half)
            turn = turn * wp.quat(sine * own.axis[0], sine * own.axis[1], sine * own.axis[2], wp.cos(half))
            work.turning[row, k] = axis * f[1]
            work.moving[row, k] = wp.cross(origin, axis) * f[1]
        else:
            origin += axis * f[0]
            work.turning[row, k] = wp.vec3(0.0)
            work.moving[row, k] = axis * f[1]
        work.orientation[row, k] = turn
        work.origin[row, k] = origin


@wp.func
def marker_place(marker: int, row: int, model: FitModel, work: FitScratch) -> wp.vec3:
    """Where the model has a marker, m."""
    own = model.marker[marker]
    place = own.point
    if own.element >= 0:
        place = work.origin[row, own.element] + wp.quat_rotate(work.orientation[row, own.element], own.point)
    return place


@wp.func
def gather_markers(frame: int, row: int, model: FitModel, frames: FitFrames, work: FitScratch) -> float:
    """Mass points and pulls of the markers, each at the element that carries it; the sum of weighted squares."""
    for k in range(model.element.shape[0]):
        work.mass[row, k] = 0.0
        work.first_moment[row, k] = wp.vec3(0.0)
        work.second_moment[row, k] = wp.mat33(0.0)
        work.pull[row, k] = wp.vec3(0.0)
        work.twist[row, k] = wp.vec3(0.0)
        work.spread[row, k] = wp.mat33(0.0)
    total = wp.float32(0.0)
    for m in range(model.marker.shape[0]):
        w = frames.weight[frame, m]
        if w > 0.0:
            p = marker_place(m, row, model, work)
            e = frames.measured[frame, m] - p
            total += w * wp.dot(e, e)
            k = model.marker[m].element
            if k >= 0:
                work.mass[row, k] += w
                work.first_moment[row, k] += w * p
                square = wp.dot(p, p)
                work.second_moment[row, k] += w * (wp.diag(wp.vec3(square)) - wp.outer(p, p))
                work.pull[row, k] += w * e
                work.twist[row, k] += w * wp.cross(p, e)
                work.spread[row, k] += w * wp.outer(p, e)
    return total


@wp.func
def normal_equations(row: int, newton: float, model: FitModel, work: FitScratch):
    """J' W J below its diagonal and on it, and J' W e, from the last element inwards.

    If `newton` is 1, less sum w e d2p, where the places p of markers turn with each element that carries another one:
    d2p = w_i x (w_k x p + v_k), so that sum w e d2p = w_i . ((M - tr M) w_k + v_k x sum w e) with M = sum w p e'.
    """
    count = model.coordinate.shape[0]
    for i in range(count):
        work.slope[row, i] = 0.0
        work.diagonal[row, i] = 0.0
        for j in range(i + 1):
            work.matrix[row, i, j] = 0.0
    for r in range(model.element.shape[0]):
        k = model.element.shape[0] - 1 - r
        own = model.element[k]
        mass = work.mass[row, k]
        if mass > 0.0:
            h = work.first_moment[row, k]
            inertia = work.second_moment[row, k]
            pull = work.pull[row, k]
            twist = work.twist[row, k]
            spread = work.spread[row, k]
            if own.parent >= 0:
                work.mass[row, own.parent] += mass
                work.first_moment[row, own.parent] += h
                work.second_moment[row, own.parent] += inertia
                work.pull[row, own.parent] += pull
                work.twist[row, own.parent] += twist
                work.spread[row, own.parent] += spread
            if own.coordinate >= 0:
                turning = work.turning[row, k]
                moving = work.moving[row, k]
                work.slope[row, own.coordinate] += wp.dot(turning, twist) + wp.dot(moving, pull)
                force = mass * moving + wp.cross(turning, h)
                moment = wp.cross(h, moving) + inertia * turning
                diagonal = wp.dot(turning, moment) + wp.dot(moving, force)
                bent = newton * (spread * turning - wp.trace(spread) * turning + wp.cross(moving, pull))
                moment -= bent
                work.diagonal[row, own.coordinate] += diagonal
                work.matrix[row, own.coordinate, own.coordinate] += diagonal - wp.dot(turning, bent)
                carrier = int(own.parent)
                while carrier >= 0:
                    other = model.element[carrier]
                    if other.coordinate >= 0:
                        entry = wp.dot(work.turning[row, carrier], moment) + wp.dot(work.moving[row, carrier], force)
                        if other.coordinate == own.coordinate:
                            entry *= 2.0
                            work.diagonal[row, own.coordinate] += entry
                        i = wp.max(own.coordinate, other.coordinate)
                        work.matrix[row, i, wp.min(own.coordinate, other.coordinate)] += entry
                    carrier = other.parent


@wp.func
def seen_weight(frame: int, model: FitModel, frames: FitFrames) -> float:
    """The sum of the weights of the markers that a frame shows."""
    total = wp.float32(0.0)
    for m in range(model.marker.shape[0]):
        total += frames.weight[frame, m]
    return total


@wp.func
def target_squares(frame: int, share: float, model: FitModel, frames: FitFrames) -> float:
    """The sum of weighted squares of the distances of coordinates from their targets.

    Args:
        share: by which weights are multiplied. Simbody takes the mean of the markers' squares, not their sum, so that
            weights of coordinates count beside one marker of weight 1.
    """
    total = wp.float32(0.0)
    line = wp.min(frame, frames.target.shape[0] - 1)
    for i in range(model.coordinate.shape[0]):
        missing = frames.target[line, i] - frames.value[frame, i]
        total += share * model.coordinate[i].weight * missing * missing
    return total


@wp.func
def add_targets(frame: int, row: int, share: float, model: FitModel, frames: FitFrames, work: FitScratch):
    """What the distances of coordinates from their targets add to the equations; see `target_squares`."""
    line = wp.min(frame, frames.target.shape[0] - 1)
    for i in range(model.coordinate.shape[0]):
        w = share * model.coordinate[i].weight
        if w > 0.0:
            work.matrix[row, i, i] += w
            work.diagonal[row, i] += w
            work.slope[row, i] += w * (frames.target[line, i] - frames.value[frame, i])


@wp.func
def hold_at_limits(frame: int, row: int, model: FitModel, frames: FitFrames, work: FitScratch):
    """Mark coordinates that are at a limit and pulled beyond it (Bertsekas 1982, eq. 32), before elimination."""
    for k in range(model.coordinate.shape[0]):
        own = model.coordinate[k]
        value = frames.value[frame, k]
        slope = work.slope[row, k]
        outward = (value <= own.low and slope < 0.0) or (value >= own.high and slope > 0.0)
        work.held[row, k] = wp.where(outward, 1, 0)


@wp.func
def solve(
    frame: int, row: int, newton: float, damping: float, model: FitModel, frames: FitFrames, work: FitScratch
) -> float:
    """The step of all coordinates, in `slope`; 0 for those that are held or not told.

    Returns the longest turn, or -1 where Newton's matrix leads to no minimum, damped or not; then there is no step.
    """
    count = model.coordinate.shape[0]
    for r in range(count):
        k = count - 1 - r
        whole_entry = work.diagonal[row, k]
        pivot = work.matrix[row, k, k]
        if newton > 0.0 and frames.loose[frame, k] == 0 and pivot + damping * whole_entry <= FLAT * whole_entry:
            return -1.0
        frames.loose[frame, k] = wp.where(pivot <= LOOSE * whole_entry, 1, 0)
        if frames.loose[frame, k] == 1 or work.held[row, k] == 1:
            for i in range(k):
                work.matrix[row, k, i] = 0.0
            work.matrix[row, k, k] = 0.0
        else:
            inverse = 1.0 / (pivot + damping * whole_entry)
            work.matrix[row, k, k] = inverse
            for i in range(k):
                entry = work.matrix[row, k, i]
                if entry != 0.0:
                    ratio = entry * inverse
                    for j in range(i + 1):
                        work.matrix[row, i, j] -= ratio * work.matrix[row, k, j]
                    work.slope[row, i] -= ratio * work.slope[row, k]
    longest = wp.float32(0.0)
    for k in range(count):
        total = work.slope[row, k]
        for i in range(k):
            total -= work.matrix[row, k, i] * work.slope[row, i]
        step = total * work.matrix[row, k, k]
        work.slope[row, k] = step
        if model.coordinate[k].turns == 1:
            longest = wp.max(longest, wp.abs(step))
    return longest


@wp.func
def take_step(frame: int, row: int, longest: float, model: FitModel, frames: FitFrames, work: FitScratch) -> float:
    """Move all coordinates by their steps, shortened if one is too long, within limits; the greatest change."""
    factor = wp.min(1.0, LONGEST_STEP / wp.max(longest, 1.0e-6))
    changed = wp.float32(0.0)
    for k in range(model.coordinate.shape[0]):
        before = frames.value[frame, k]
        own = model.coordinate[k]
        after = wp.clamp(before + factor * work.slope[row, k], own.low, own.high)
        work.last[row, k] = before
        frames.value[frame, k] = after
        changed = wp.max(changed, wp.abs(after - before))
    return changed


@wp.kernel
def fit_markers(first: int, model: FitModel, frames: FitFrames, work: FitScratch):
    """Fit the frames from `first` on, each by one thread."""
    row = wp.tid()
    frame = first + row
    share = seen_weight(frame, model, frames)
    damping = wp.float32(0.0)
    least = wp.float32(0.0)
    newton = wp.float32(0.0)
    lost = wp.int32(0)  # how many steps were of no use
    back = wp.bool(True)  # whether there is nothing to compare with
    changed = wp.float32(1.0)
    count = wp.int32(0)
    while count < MOST_ITERATIONS and changed > CONVERGED:
        place_elements(frame, row, model, frames.value, work)
        total = gather_markers(frame, row, model, frames, work) + target_squares(frame, share, model, frames)
        if not back and total > least * (1.0 + WORSE):
            damping = wp.max(10.0 * damping, FIRST_DAMPING)
            lost += 1
            newton = wp.where(lost < OFTEN, 0.0, 1.0)
            for k in range(model.coordinate.shape[0]):
                frames.value[frame, k] = work.last[row, k]
            back = True
        else:
            if not back:
                damping = wp.where(damping > FIRST_DAMPING, 0.1 * damping, 0.0)
            normal_equations(row, newton, model, work)
            add_targets(frame, row, share, model, frames, work)
            hold_at_limits(frame, row, model, frames, work)
            longest = solve(frame, row, newton, damping, model, frames, work)
            if longest < 0.0:
                lost += 1
                if lost < OFTEN:
                    newton = 0.0
                else:
                    damping = wp.max(10.0 * damping, FIRST_DAMPING)
                back = True
            else:
                least = total
                back = False
                changed = take_step(frame, row, longest, model, frames, work)
                newton = wp.where((longest < NEAR and damping == 0.0) or lost >= OFTEN, 1.0, 0.0)
        count += 1
    frames.iterations[frame] = wp.where(changed > CONVERGED, -count, count)
    place_elements(frame, row, model, frames.value, work)
    for m in range(model.marker.shape[0]):
        frames.error[frame, m] = frames.measured[frame, m] - marker_place(m, row, model, work)
