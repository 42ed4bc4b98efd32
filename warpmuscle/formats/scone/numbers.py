"""The notation of SCONE's free numbers: `1.5`, `~1.5<0,2>`, `1.5~0.1<0,2>` for a number, its spread and its bounds."""

from __future__ import annotations

import re
from typing import NamedTuple

from warpmuscle.formats.scone.zml import Node
from warpmuscle.scene.number import Free, Number

FREE = re.compile(r"(?P<mean>[^~<>\[]*)~(?P<std>[^~<>\[]*)(?:[<\[](?P<low>[^,<>]*),(?P<high>[^,<>\]]*)[>\]])?")
AUTO_FACTOR, LEAST_SPREAD = 0.1, 0.01  # of a spread that is not given: factor of the mean, and the least one
UNBOUNDED = 10.0  # spreads to either side, of a number without bounds


class FreeNumber(NamedTuple):
    """A number that SCONE searches for."""

    mean: float
    std: float
    low: float
    high: float


def read_number(node: Node, std_factor: float = AUTO_FACTOR) -> float | FreeNumber:
    """The value of a node: a plain number or a free one.

    Args:
        std_factor: of the mean, for a spread that is not given: `auto_std_factor`.
    """
    if node.value is None and (middle := node.find("mean", "init_mean")) is not None:
        return _of_block(node, middle.number(), std_factor)
    text = "".join(node.text().split())
    if "~" not in text:
        return node.number_in(text)
    found = FREE.fullmatch(text)
    if found is None:
        node.fail(f"{text!r} is not a free number such as ~1.5<0,2> or 1.5~0.1<0,2>")
    given, spread = found["mean"], found["std"]
    if given:
        mean, std = node.number_in(given), node.number_in(spread)
    else:
        mean = node.number_in(spread)
        std = max(std_factor * abs(mean), LEAST_SPREAD)
    low, high = mean - UNBOUNDED * std, mean + UNBOUNDED * std
    if found["low"] is not None:
        low, high = node.number_in(found["low"]), node.number_in(found["high"])
    return _checked(node, FreeNumber(mean, std, low, high))


def _of_block(node: Node, mean: float, std_factor: float) -> FreeNumber:
    """A free number as versions before 2017 have it: `{ mean = 0.3 std = 0.01 min = 0 max = 1 }`."""
    given = node.find("std", "init_std")
    std = max(std_factor * abs(mean), LEAST_SPREAD) if given is None else given.number()
    low, high = (node.number_of(key, mean + way * UNBOUNDED * std) for key, way in (("min", -1.0), ("max", 1.0)))
    node.tell_unused("a free number has mean, std, min and max")
    return _checked(node, FreeNumber(mean, std, low, high))


def _checked(node: Node, number: FreeNumber) -> FreeNumber:
    """A number whose spread and bounds fit together."""
    mean, std, low, high = number
    if std <= 0.0:
        node.fail(f"its spread must be greater than 0, is {std:g}")
    if not low < high:
        node.fail(f"its bounds run down from {low:g} to {high:g}")
    if not low <= mean <= high:
        node.fail(f"{mean:g} is outside of its bounds from {low:g} to {high:g}")
    return number


def as_scene_number(number: float | FreeNumber, value: float | None = None) -> Number:
    """A number of a scene; a free one starts from its mean, or from another value within its bounds."""
    if not isinstance(number, FreeNumber):
        return number
    start = number.mean if value is None else min(max(value, number.low), number.high)
    return Free(start, min=number.low, max=number.high)
