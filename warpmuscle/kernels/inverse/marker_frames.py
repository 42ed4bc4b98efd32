"""Recorded frames for `marker_fit` out of all that are recorded, and what was found in them back among all."""

import warp as wp

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.func
def is_seen(place: wp.vec3d) -> bool:
    """Whether a marker has a place: a missing one is not a number."""
    return wp.isfinite(place[0]) and wp.isfinite(place[1]) and wp.isfinite(place[2])


@wp.kernel
def look_at_frames(
    positions: wp.array2d[wp.vec3d], weights: wp.array[float], beyond: wp.float64, seen: wp.array[int],
    far: wp.array[int],
):  # fmt: skip
    """How many markers that count each frame shows, and whether one of all that it shows is farther away than that.

    Args:
        weights: (markers,) as recorded. beyond: m, along an axis.
    """
    frame = wp.tid()
    count = wp.int32(0)
    away = wp.int32(0)
    for k in range(positions.shape[1]):
        place = positions[frame, k]
        if is_seen(place):
            if weights[k] > 0.0:
                count += 1
            if wp.max(wp.abs(place)) > beyond:
                away = 1
    seen[frame] = count
    far[frame] = away


@wp.kernel
def take_frames(
    positions: wp.array2d[wp.vec3d], turn: wp.mat33d, weights: wp.array[float], order: wp.array[int],
    frame: wp.array[int], base: wp.array[wp.vec3d], measured: wp.array2d[wp.vec3], weight: wp.array2d[float],
):  # fmt: skip
    """Places of markers from the frame's base, (rows, markers) in the order of the fit; 0 where one is missing.

    Args:
        positions: (frames, markers) m, as recorded. turn: of recorded places into the axes of the fit.
        weights: (markers,) in the order of the fit, as `order` is. frame: (rows,) the number of each row's frame.
        base: (rows,) m.
    """
    row, k = wp.tid()
    place = positions[frame[row], order[k]]
    if is_seen(place):
        measured[row, k] = wp.vec3(turn * place - base[row])
        weight[row, k] = weights[k]
    else:
        measured[row, k] = wp.vec3(0.0, 0.0, 0.0)
        weight[row, k] = 0.0


@wp.kernel
def mean_squares(error: wp.array2d[wp.vec3], weight: wp.array2d[float], found: wp.array[wp.float64]):
    """Weighted mean square of the errors of each row, m^2; 0 of one without markers."""
    row = wp.tid()
    total, mass = wp.float64(0.0), wp.float64(0.0)
    for k in range(weight.shape[1]):
        own = wp.float64(weight[row, k])
        off = error[row, k]
        for axis in range(3):
            along = wp.float64(off[axis])
            total += own * along * along
        mass += own
    found[row] = total / wp.max(mass, wp.float64(1.0e-12))


@wp.kernel
def put_errors(
    error: wp.array2d[wp.vec3], positions: wp.array2d[wp.vec3d], turn: wp.mat33d, order: wp.array[int],
    frame: wp.array[int], chosen: wp.array[int], errors: wp.array2d[wp.vec3d],
):  # fmt: skip
    """Errors of chosen rows among those of all frames, in the order and axes recorded; NaN where a marker is missing.

    Args:
        turn: of places in the axes of the fit into those recorded.
    """
    n, k = wp.tid()
    row = chosen[n]
    off = turn * wp.vec3d(error[row, k])
    if not is_seen(positions[frame[row], order[k]]):
        off = wp.vec3d(wp.float64(wp.nan), wp.float64(wp.nan), wp.float64(wp.nan))
    errors[frame[row], order[k]] = off


@wp.kernel
def sum_markers(
    positions: wp.array2d[wp.vec3d], errors: wp.array2d[wp.vec3d], starts: wp.array[int],
    squares: wp.array2d[wp.float64], height: wp.array2d[wp.float64], seen: wp.array2d[int],
):  # fmt: skip
    """Sums over the frames of each recording, (recordings, markers), in which a marker is seen.

    Args:
        starts: (recordings + 1,) first frames, and the number of all.

    Returns:
        squares: of the errors, m^2. height: along the recorded y axis, m. seen: how many frames.
    """
    recording, k = wp.tid()
    total, up, count = wp.float64(0.0), wp.float64(0.0), wp.int32(0)
    for frame in range(starts[recording], starts[recording + 1]):
        place = positions[frame, k]
        if is_seen(place):
            off = errors[frame, k]
            total += wp.dot(off, off)
            up += place[1]
            count += 1
    squares[recording, k] = total
    height[recording, k] = up
    seen[recording, k] = count
