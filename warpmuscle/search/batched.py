"""Many searches that share one batch of evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.search.search import Search, checked_costs


@dataclass(frozen=True)
class Batch:
    """What several searches want evaluated."""

    candidates: Floats  # (n, P), those of a search one after the other
    owner: NDArray[np.intp]  # (n,) index of the search that each is for, among all that were asked


def ask_all(searches: Sequence[Search]) -> Batch:
    """The candidates of all searches that have not finished.

    Raises:
        Error: all have finished.
    """
    parts = [(i, search.ask()) for i, search in enumerate(searches) if not search.finished()]
    if not parts:
        raise Error("all searches have finished")
    return Batch(
        candidates=np.concatenate([candidates for _, candidates in parts]),
        owner=np.repeat([i for i, _ in parts], [len(candidates) for _, candidates in parts]),
    )


def tell_all(searches: Sequence[Search], batch: Batch, costs: ArrayLike) -> None:
    """Tell the same searches the costs (n,) of the candidates that `ask_all` gave.

    Raises:
        Error: another number of costs, or one that is not finite; then no search has been told any.
    """
    values = checked_costs(costs, len(batch.candidates))
    for i in np.unique(batch.owner):
        searches[i].tell(values[batch.owner == i])
