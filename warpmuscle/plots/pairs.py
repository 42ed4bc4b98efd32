"""Names of left and right parts that belong together."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

_SWAPS = (
    ("l", "r", r"^{}(?=[A-Z_])"),
    ("left", "right", r"{}"),
    ("l", "r", r"(?<=_){}$"),
    ("L", "R", r"^{}(?=[A-Z_])"),
)


class Pair(NamedTuple):
    """A part on both sides, or in the middle, where both names are the same."""

    label: str
    left: str
    right: str


def pairs(names: Sequence[str]) -> list[Pair]:
    """The names as pairs of left and right where both sides are among them, in the order of their first part."""
    found: dict[str, Pair] = {}
    for name in names:
        pair = _pair(name, names)
        found.setdefault(pair.left, pair)
    return list(found.values())


def _pair(name: str, names: Sequence[str]) -> Pair:
    for left, right, place in _SWAPS:
        for own, other in ((left, right), (right, left)):
            swapped = re.sub(place.format(own), other, name, count=1)
            if swapped != name and swapped in names:
                label = re.sub(place.format(own), "", name, count=1).strip("_. ")
                return Pair(label or name, *((name, swapped) if own == left else (swapped, name)))
    return Pair(name, name, name)
