"""Where functions are within a range."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.formats.osim.functions.function import Function

ROUNDED, SEARCHED = 1.0e-9, 301  # rad or m; places on each side, at which a range may be left
ENDLESS = 1.0e6  # rad or m, for a range that has no end


def span_within(
    function: Function, span: tuple[float, float], domain: tuple[float, float] = (-math.pi, math.pi)
) -> list[float]:
    """The span of its argument in which a function is within a range, as OpenSim clamps what moves a point to it.

    None where the range has no ends. Of a function that is no line, it is the one about the middle of its argument's
    range, looked for as far beyond that as it is wide; an end that the function does not reach there is far away.
    """
    if function.constant or not any(map(math.isfinite, span)):
        return []
    if function.line is None:
        return _around_middle(function, span, domain)
    offset, slope = function.line
    low, high = sorted((max(min(end, ENDLESS), -ENDLESS) - offset) / slope for end in span)
    return [low, high] if low < high else []


def spans_within(
    function: Function, span: tuple[float, float], domain: tuple[float, float]
) -> list[tuple[float, float]]:  # fmt: skip
    """The spans of its argument in which a function is within a range, over its domain and half as far beyond."""
    width = 0.5 * (domain[1] - domain[0])
    places = np.linspace(domain[0] - width, domain[1] + width, 10 * SEARCHED)
    inside = [bool(one) for one in (span[0] <= function.values(places)) & (function.values(places) <= span[1])]
    ends = [
        _crossing(function, span, float(places[k]), float(places[k + 1]))
        for k in range(len(inside) - 1)
        if inside[k] != inside[k + 1]
    ]
    if inside[0]:
        ends = [-ENDLESS, *ends]
    if inside[-1]:
        ends = [*ends, ENDLESS]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _crossing(function: Function, span: tuple[float, float], low: float, high: float) -> float:
    """Where a function enters a range, or leaves it, between two places."""
    first = span[0] <= function.at(low) <= span[1]
    while high - low > 1e-12 * (1.0 + abs(low)):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        inside = span[0] <= function.at(middle) <= span[1]
        low, high = (middle, high) if inside == first else (low, middle)
    return 0.5 * (low + high)


def _around_middle(function: Function, span: tuple[float, float], domain: tuple[float, float]) -> list[float]:
    """What `span_within` says of a function that is no line."""

    def inside(q: float) -> bool:
        return bool(span[0] - ROUNDED <= function.at(q) <= span[1] + ROUNDED)

    middle, width = 0.5 * (domain[0] + domain[1]), domain[1] - domain[0]
    if not inside(middle):
        return []
    ends = []
    for way, far in ((-1.5 * width, -ENDLESS), (1.5 * width, ENDLESS)):
        places = middle + way * np.linspace(0.0, 1.0, SEARCHED)
        out = next((k for k, q in enumerate(places) if not inside(float(q))), 0)
        if not out:
            ends.append(far)
            continue
        kept, left = float(places[out - 1]), float(places[out])
        for _ in range(50):
            half = 0.5 * (kept + left)
            kept, left = (half, left) if inside(half) else (kept, half)
        ends.append(kept)
    return ends if ends != [-ENDLESS, ENDLESS] else []
