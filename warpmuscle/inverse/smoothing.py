"""Low-pass filters and splines over recordings as OpenSim's tools have them.

OpenSim's filter is Butterworth's of third order, forwards and backwards, over rows that were mirrored at both ends; its
`GCVSpline` without an error variance is the natural spline through all values: of fifth degree through coordinates,
whose rates inverse dynamics takes, of third degree through loads. Both agree with OpenSim 4.6 to rounding.
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.sequences import are_even, mirrored

ORDER = 3  # of the filter, one way
SLOWEST = 5.0  # Hz, below which nobody records
LEAST = {5: 6, 3: 4, 1: 2}  # values that a natural spline of a degree is made of


def low_pass(times: Floats, values: Floats, cutoff: float) -> tuple[Floats, Floats]:
    """Values without what is faster than a frequency, as OpenSim's inverse dynamics filters coordinates.

    Rows are mirrored at both ends, half as many as there are, and stay there: the spline goes through them, too. Times
    that are uneven are made even first, by a spline.

    Args:
        times: (F,) s. values: (F, ...). cutoff: Hz.

    Returns:
        Times, also before the first and after the last given one, and values at them.

    Raises:
        ArgumentError: a cut-off that is no frequency below half the rate, or fewer than four frames.
    """
    from scipy.signal import butter, lfilter  # takes a while, which only filters cost

    if len(times) < 4:
        raise ArgumentError(f"a low-pass filter needs 4 frames at least, not {len(times)}")
    even = are_even(times)
    rate = (len(times) - 1) / (times[-1] - times[0]) if even else 1.0 / np.diff(times).min()
    if not 0.0 < cutoff < 0.5 * rate:
        slow = "; are its times in seconds?" if rate < SLOWEST else ""
        raise ArgumentError(f"the filter's cut-off, {cutoff:g} Hz, must lie between 0 and {0.5 * rate:g} Hz, "
                            f"half the rate of the motion{slow}")  # fmt: skip
    at = times if even else np.linspace(times[0], times[-1], round((times[-1] - times[0]) * rate) + 1)
    x = values if even else spline(times, values, at)[0]
    pad = len(x) // 2
    x, at = mirrored(x, pad), mirrored(at, pad)
    b, a = butter(ORDER, cutoff / (0.5 * rate))
    flat = x.reshape(len(x), -1)
    for _ in range(2):  # the first values of each way are left as they are
        start = _filter_state(b, a, flat[2::-1])
        flat = np.concatenate([flat[:3], lfilter(b, a, flat[3:], axis=0, zi=start)[0]])[::-1]
    return at, flat.reshape(x.shape)


def _filter_state(b: Floats, a: Floats, before: Floats) -> Floats:
    """State (ORDER, K) of a filter whose last ORDER values in and out (ORDER, K) were these, the latest first.

    It is that of `scipy.signal.lfiltic` in each column.
    """
    way_in, way_out = (
        np.array([(c[k + 1 :, None] * before[: ORDER - k]).sum(axis=0) for k in range(ORDER)]) for c in (b, a)
    )
    return np.asarray(way_in - way_out)


def spline(times: Floats, values: Floats, at: Floats, degree: int = 5, orders: int = 1) -> list[Floats]:
    """The natural spline through values (F, ...), and its first derivatives, at other times.

    Where there are too few frames for a degree, it is the next lower odd one.

    Args:
        times: (F,) s, increasing. at: (n,) s. orders: how many arrays (n, ...) are wanted, derivatives after the value.
    """
    from scipy.interpolate import make_interp_spline

    degree = next((one for one in (5, 3, 1) if one <= degree and len(times) >= LEAST[one]), 0)
    if degree == 0:
        return [np.repeat(values[:1], len(at), axis=0) * (order == 0) for order in range(orders)]
    ends = [(order, np.zeros(values.shape[1:])) for order in range((degree + 1) // 2, degree)]
    found = make_interp_spline(times, values, k=degree, bc_type=(ends, ends) if ends else None, axis=0)
    return [np.asarray(found(at, nu=order)) for order in range(orders)]
