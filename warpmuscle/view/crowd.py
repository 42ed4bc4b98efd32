"""What is known of each of many motions: what they cost, how they rank, and which of them failed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

WIDE = 20.0  # the greatest cost in the least one, from which on a scale of costs shows two colours only: good and bad
SHADES = ("activation", "cost", "rank", "condition")  # what bodies can be coloured by


class Facts(NamedTuple):
    """What is known of one motion."""

    cost: float | None = None
    ended: str = ""  # how and when it failed, such as "fell at 2.1 s"; empty: it did not
    until: float | None = None  # s, when it failed


def facts_content(facts: Sequence[Facts]) -> list[dict[str, Any]]:
    """What the page is sent about motions, in their order: numbers that there are, and ranks from 1, the best."""
    costs = np.array([np.nan if one.cost is None else one.cost for one in facts])
    ranks = {int(k): rank for rank, k in enumerate(np.argsort(costs, kind="stable"), 1) if np.isfinite(costs[k])}
    found = []
    for number, one in enumerate(facts):
        content: dict[str, Any] = {"ended": one.ended}
        if number in ranks:
            content |= {"cost": float(f"{one.cost:.6g}"), "rank": ranks[number]}
        if one.until is not None:
            content["until"] = round(one.until, 3)
        found.append(content)
    return found


def shades_of(facts: Sequence[Facts], muscles: bool, few: int) -> dict[str, Any]:
    """By what these motions can be coloured, and by what they are at first.

    Args:
        muscles: whether there are any. few: motions up to which activations are what is looked at.
    """
    known = {
        "activation": muscles,
        "cost": len({one.cost for one in facts if one.cost is not None}) > 1,
        "condition": any(one.ended for one in facts),
    }
    known["rank"] = known["cost"]
    there = [name for name in SHADES if known[name]]
    costs = [one.cost for one in facts if one.cost is not None and not one.ended]
    priced = "rank" if costs and 0.0 < WIDE * min(costs) < max(costs) else "cost"
    order = (priced, "condition", "activation") if len(facts) > few else ("activation",)
    return {"known": there, "first": next((name for name in order if known[name]), "")}
