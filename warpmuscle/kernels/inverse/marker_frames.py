"""Recorded frames for `marker_fit` out of all that are recorded, and what was found in them back among all."""

import warp as wp

from warpmuscle.kernels.marker_fit_structs import FitFrames

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.func
def is_seen(place: wp.vec3d) -> bool:
    """Whether a marker has a place: a missing one is not a number."""
    return wp.isfinite(place[0]) and wp.isfinite(place[1]) and wp.isfinite(place[2])


@wp.kernel
def look_at_frames(
    positions: wp.array2d[wp.vec3d], column: wp.array[int], weights: wp.array[float], beyond: wp.float64,
    seen: wp.array[int], far: wp.array[int],
):  # fmt: skip
    """How many markers that count each frame shows, and whether one of them is farther away than that.

    Args:
        positions: (frames, columns) m, as recorded. column: (markers,) of each one. weights: (markers,). beyond: m,
            along an axis.
    """
    frame = wp.tid()
    count = wp.int32(0)
    away = wp.int32(0)
    for k in range(column.shape[0]):
        place = positions[frame, column[k]]
        if is_seen(place):
            if weights[k] > 0.0:
                count += 1
            if wp.max(wp.abs(place)) > beyond:
                away = 1
    seen[frame] = count
    far[frame] = away


@wp.kernel
def take_frames(
    positions: wp.array2d[wp.vec3d], turn: wp.mat33d, weights: wp.array[float], column: wp.array[int],
    frame: wp.array[int], base: wp.array[wp.vec3d], measured: wp.array2d[wp.vec3], weight: wp.array2d[float],
):  # fmt: skip
    """Places of markers from the frame's base, (rows, markers) in the order of the fit; 0 where one is missing.

    Args:
        positions: (frames, columns) m, as recorded. turn: of recorded places into the axes of the fit.
        weights, column: (markers,) in the order of the fit. frame: (rows,) the number of each row's frame.
        base: (rows,) m.
    """
    row, k = wp.tid()
    place = positions[frame[row], column[k]]
    if is_seen(place):
        measured[row, k] = wp.vec3(turn * place - base[row])
        weight[row, k] = weights[k]
    else:
        measured[row, k] = wp.vec3(0.0, 0.0, 0.0)
        weight[row, k] = 0.0


@wp.kernel
def start_rows(
    start: wp.array2d[wp.float64], first_shift: int, axis: wp.array[wp.vec3d], targets: wp.array2d[wp.float64],
    frame: wp.array[int], value: wp.array2d[float], base: wp.array[wp.vec3d], target: wp.array2d[float],
):  # fmt: skip
    """Coordinates of each row's start without the root's shifts, and where these bring it.

    What is left of the shifts is small, so that single precision tells it well.

    Args:
        start: (rows, coordinates). first_shift: number of the first of the root's shifts, along these axes.
        targets: (frames or 1, coordinates). frame: (rows,) the number of each row's frame.

    Returns:
        base: (rows,) m. target: (rows, coordinates), of `value`.
    """
    row = wp.tid()
    line = wp.min(frame[row], targets.shape[0] - 1)
    moved = wp.vec3d()
    for k in range(start.shape[1]):
        left_out = wp.float64(0.0)
        if k >= first_shift and k < first_shift + axis.shape[0]:
            left_out = start[row, k]
            moved += left_out * axis[k - first_shift]
        value[row, k] = float(start[row, k] - left_out)
        target[row, k] = float(targets[line, k] - left_out)
    base[row] = moved


@wp.kernel
def start_between(
    values: wp.array2d[wp.float64], left: wp.array[int], right: wp.array[int], part: wp.array[wp.float64],
    start: wp.array2d[wp.float64],
):  # fmt: skip
    """Coordinates (rows, C) between those of two frames, by that part of the way."""
    row, k = wp.tid()
    start[row, k] = (wp.float64(1.0) - part[row]) * values[left[row], k] + part[row] * values[right[row], k]


@wp.kernel
def align_frames(
    positions: wp.array2d[wp.vec3d], turn: wp.mat33d, weights: wp.array[float], column: wp.array[int],
    frame: wp.array[int], body: wp.array[wp.vec3d], turned: wp.array[wp.quatd], moved: wp.array[wp.vec3d],
):  # fmt: skip
    """Rotations and shifts (rows,) that bring the points of a rigid body closest to the markers of a frame.

    By singular values (Kabsch 1976; Umeyama 1991, eq. 40).

    Args:
        positions, turn, weights, column, frame: see `take_frames`. body: (markers,) in the order of the fit.
    """
    row = wp.tid()
    mass = wp.float64(1.0e-300)
    middle = wp.vec3d()
    own = wp.vec3d()
    for k in range(column.shape[0]):
        place = positions[frame[row], column[k]]
        if is_seen(place):
            w = wp.float64(weights[k])
            mass += w
            middle += w * (turn * place)
            own += w * body[k]
    middle /= mass
    own /= mass
    spread = wp.mat33d()
    for k in range(column.shape[0]):
        place = positions[frame[row], column[k]]
        if is_seen(place):
            spread += wp.float64(weights[k]) * wp.outer(turn * place - middle, body[k] - own)
    u = wp.mat33d()
    sigma = wp.vec3d()
    v = wp.mat33d()
    # Both are rotations: where the best is a mirror image, the least value is negative. Warp's stubs are of floats.
    wp.svd3(spread, u, sigma, v)  # type: ignore[call-overload]
    rotation = wp.normalize(wp.quat_from_matrix(u * wp.transpose(v)))  # type: ignore[arg-type]
    turned[row] = rotation
    moved[row] = middle - wp.quat_rotate(rotation, own)


@wp.kernel
def mean_squares(rows: FitFrames, task_weights: wp.array[wp.float64], found: wp.array[wp.float64]):
    """What the fit of each row has made least: the weighted mean square of its errors, m^2, 0 of one without markers.

    Args:
        task_weights: (coordinates,) of squared distances from their targets, which are added.
    """
    row = wp.tid()
    total, mass = wp.float64(0.0), wp.float64(0.0)
    for k in range(rows.weight.shape[1]):
        own = wp.float64(rows.weight[row, k])
        off = rows.error[row, k]
        for axis in range(3):
            along = wp.float64(off[axis])
            total += own * along * along
        mass += own
    mean = total / wp.max(mass, wp.float64(1.0e-12))
    for k in range(task_weights.shape[0]):
        off_target = wp.float64(rows.target[row, k]) - wp.float64(rows.value[row, k])
        mean += task_weights[k] * off_target * off_target
    found[row] = mean


@wp.kernel
def put_rows(
    frame: wp.array[int], better: bool, square: wp.array[wp.float64], start: wp.array2d[wp.float64], first_shift: int,
    shifts: int, rows: FitFrames, squares: wp.array[wp.float64], values: wp.array2d[wp.float64],
    iterations: wp.array[int], loose: wp.array2d[wp.uint8], kept: wp.array[int],
):  # fmt: skip
    """What was found in each row among all frames; if `better`, only where it fits better than what is there.

    Args:
        square: (rows,) what comes of `mean_squares`. start, first_shift: see `start_rows`. shifts: of the root.

    Returns:
        kept: (rows,) 1 where it was put.
    """
    row = wp.tid()
    own = frame[row]
    if better and not square[row] < squares[own]:
        kept[row] = 0
        return
    kept[row] = 1
    squares[own] = square[row]
    iterations[own] = rows.iterations[row]
    for k in range(values.shape[1]):
        found = wp.float64(rows.value[row, k])
        if k >= first_shift and k < first_shift + shifts:
            found += start[row, k]
        values[own, k] = found
        loose[own, k] = wp.uint8(rows.loose[row, k])


@wp.kernel
def find_jumps(values: wp.array2d[wp.float64], first: int, turns: wp.array[int], found: wp.array[float]):
    """By how much the coordinate that turns most does so from the frame before to each, rad; 0 in the first one.

    Args:
        first: coordinate, after those of the root. turns: (coordinates,) 1 of one that turns something.
    """
    frame = wp.tid()
    most = wp.float32(0.0)
    if frame > 0:
        for k in range(first, values.shape[1]):
            if turns[k] == 1:
                most = wp.max(most, wp.float32(wp.abs(values[frame, k] - values[frame - 1, k])))
    found[frame] = most


@wp.kernel
def put_errors(
    error: wp.array2d[wp.vec3], positions: wp.array2d[wp.vec3d], turn: wp.mat33d, column: wp.array[int],
    order: wp.array[int], frame: wp.array[int], kept: wp.array[int], errors: wp.array2d[wp.vec3],
):  # fmt: skip
    """Errors of the rows that are kept among those of all frames, in the order and axes recorded; NaN without a marker.

    Args:
        turn: of places in the axes of the fit into those recorded. column: (markers,) of `positions`, and order:
            of `errors`, in the order of the fit.
    """
    row, k = wp.tid()
    if kept[row] == 0:
        return
    off = wp.vec3(turn * wp.vec3d(error[row, k]))
    if not is_seen(positions[frame[row], column[k]]):
        off = wp.vec3(wp.nan, wp.nan, wp.nan)
    errors[frame[row], order[k]] = off


@wp.func
def squared(v: wp.vec3d) -> wp.float64:
    """Sum of the squares of its components."""
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


@wp.kernel
def sum_markers(
    positions: wp.array2d[wp.vec3d], column: wp.array[int], errors: wp.array2d[wp.vec3], starts: wp.array[int],
    squares: wp.array2d[wp.float64], height: wp.array2d[wp.float64], seen: wp.array2d[int],
    most: wp.array2d[wp.float64],
):  # fmt: skip
    """Sums over the frames of each piece of a recording, (pieces, markers), in which a marker is seen.

    Args:
        column: (markers,) of `positions`. starts: (pieces + 1,) first frames, and the number of all.

    Returns:
        squares: of the errors, m^2. height: along the recorded y axis, m. seen: how many frames. most: the greatest
            square.
    """
    piece, k = wp.tid()
    total, up, count = wp.float64(0.0), wp.float64(0.0), wp.int32(0)
    greatest = wp.float64(0.0)
    for frame in range(starts[piece], starts[piece + 1]):
        place = positions[frame, column[k]]
        if is_seen(place):
            off = wp.vec3d(errors[frame, k])
            missed = squared(off)
            total += missed
            greatest = wp.max(greatest, missed)
            up += place[1]
            count += 1
    squares[piece, k] = total
    height[piece, k] = up
    seen[piece, k] = count
    most[piece, k] = greatest


@wp.kernel
def count_near(
    positions: wp.array2d[wp.vec3d], column: wp.array[int], errors: wp.array2d[wp.vec3], starts: wp.array[int],
    times: wp.float64, most: wp.array2d[wp.float64], near: wp.array2d[int],
):  # fmt: skip
    """How many frames of each piece, (pieces, markers), miss by less than the worst one of the recording does.

    Args:
        column, starts: see `sum_markers`. times: by which they may miss more and still do. most: (pieces, markers)
            m^2, the greatest square in the recording that a piece is of.
    """
    piece, k = wp.tid()
    close = wp.int32(0)
    for frame in range(starts[piece], starts[piece + 1]):
        if is_seen(positions[frame, column[k]]):
            off = wp.vec3d(errors[frame, k])
            if not times * times * squared(off) >= most[piece, k]:
                close += 1
    near[piece, k] = close
