"""What a sweep file says of points that follow from results: how many at first, how many at a time, between what."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.sweep.samples import Sample, Sampled, rounds_of

WITHOUT_POINTS = {
    "training": "trainings have no costs that points could follow from",
    "study": "a study names its conditions before any has run",
    "prune": "costs of runs that are stopped early say nothing of their points; leave [prune] out",
}  # tables that do not go with them, and why


@dataclass(frozen=True)
class Refinement:
    """How points of a sweep follow from the results of those before.

    Attributes:
        count: of points in the end. batch: so many at a time. seed: of what is looked at.
        axes: (d,) names. first: (n, d) points of the unit cube that it begins with.
        grown: the plan (`sweep.plan.Plan`) with these points (n, d) after the first ones.
    """

    count: int
    batch: int
    seed: int
    axes: tuple[str, ...]
    first: Floats
    grown: Callable[[Floats], Any]

    @property
    def dimensions(self) -> int:
        """How many axes there are."""
        return len(self.axes)

    def with_chosen(self, chosen: Floats) -> Floats:
        """The first points and these."""
        return np.concatenate([self.first, chosen])


def refinement_of(
    sample: Sample, found: Sampled, grown: Callable[[Floats], Any], there: Mapping[str, bool]
) -> Refinement | None:
    """How the points of an adaptive sample are chosen; None of another one.

    Args:
        there: by name of `WITHOUT_POINTS`, whether the file has such a table.

    Raises:
        SceneError: it has one.
    """
    if sample.method != "adaptive":
        return None
    for name, why in WITHOUT_POINTS.items():
        if there[name]:
            raise SceneError(why, key="sample.method")
    first, batch = rounds_of(sample, len(found.axes))
    return Refinement(sample.points, batch, sample.seed, found.axes, found.units[:first], grown)
