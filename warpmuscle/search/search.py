"""What all searches have in common: candidates in the unit cube are asked for, and their costs are told."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of

DEFAULT_SIGMA = 0.25  # of the cube's edge: four standard deviations span it


class Search(Protocol):
    """A search in the unit cube that asks for candidates and is told their costs.

    It is deterministic for a seed on equal machines, so that it can be brought back by telling a fresh one the same
    costs again; see `follow` for others.
    """

    def ask(self) -> Floats:
        """Candidates wanted now, (n, P) with n >= 1, read-only; the same until `tell`.

        Raises:
            Error: the search has finished.
        """

    def tell(self, costs: ArrayLike) -> None:
        """Costs (n,) of what was asked, finite: a candidate that failed has a finite worst cost.

        Raises:
            Error: another number of costs than of candidates, a cost that is not finite, or the search has finished.
        """

    def follow(self, candidates: Floats) -> bool:
        """Take these candidates, (n, P), for those asked for, whose costs are told next; False if it cannot.

        It serves a search that goes on on another machine, where what it asks for differs in the last bits, and after
        some generations visibly.
        """

    def finished(self) -> str:
        """Empty while the search goes on, else why it ended, such as `tolfun`."""

    def step_size(self) -> float:
        """Its step size as a part of the cube's edge, not a number if it has none."""

    def state(self) -> dict[str, Floats]:
        """What describes the search now, for storage and plots.

        Of every search: `mean` (P,), where it is; `sigma` (), its step size, not a number if it has none; `best` (P,)
        and `best_cost` (), the best candidate so far, infinite before the first; `evaluations` (), costs told.
        """


class BestSoFar:
    """The best candidate so far and how many there were."""

    def __init__(self, start: Floats) -> None:
        """Begin at a start (P,)."""
        self.best, self.cost, self.evaluations = start.copy(), np.inf, 0

    def add(self, candidates: Floats, costs: Floats) -> None:
        """Count candidates (n, P) with their costs (n,); of equal ones the first remains the best."""
        index = int(np.argmin(costs))
        if costs[index] < self.cost:
            self.best, self.cost = candidates[index].copy(), float(costs[index])
        self.evaluations += len(costs)

    def state(self, mean: Floats, sigma: float) -> dict[str, Floats]:
        """What every search's state has."""
        return {
            "mean": np.array(mean, dtype=np.float64),
            "sigma": np.array(sigma, dtype=np.float64),
            "best": self.best.copy(),
            "best_cost": np.array(self.cost),
            "evaluations": np.array(self.evaluations, dtype=np.float64),
        }


def frozen(candidates: Floats) -> Floats:
    """The same candidates, which nobody may change any more: they are needed again when their costs are told."""
    candidates.flags.writeable = False
    return candidates


def checked_start(start: ArrayLike) -> Floats:
    """A start as (P,), copied.

    Raises:
        Error: it has no coordinates, or lies outside the cube.
    """
    point = np.array(start, dtype=np.float64)
    if point.ndim != 1 or point.size == 0:
        raise Error(f"a search starts from a vector of at least one number, not from an array of shape {point.shape}")
    outside = np.flatnonzero(~((point >= 0.0) & (point <= 1.0)))
    if len(outside) > 0:
        raise Error(f"a search starts within [0, 1]: coordinate {outside[0]} of its start is {point[outside[0]]}")
    return point


def checked_costs(costs: ArrayLike, count: int) -> Floats:
    """Costs as (count,).

    Raises:
        Error: there are more or fewer of them, or one is not finite.
    """
    values = np.asarray(costs, dtype=np.float64)
    if values.shape != (count,):
        raise Error(f"{number_of(count, 'candidate', 'were')} asked for, but the costs told have shape {values.shape}")
    if not np.all(np.isfinite(values)):
        index = int(np.flatnonzero(~np.isfinite(values))[0])
        raise Error(f"the cost of candidate {index} is {values[index]}: give a candidate that failed a finite cost")
    return values


def checked_sigma(sigma: float | None) -> float:
    """An initial step size, by default `DEFAULT_SIGMA`.

    Raises:
        Error: it is not positive, or larger than the cube.
    """
    if sigma is None:
        return DEFAULT_SIGMA
    if not 0.0 < sigma <= 1.0:
        raise Error(f"sigma must be above 0 and at most 1, of each parameter's interval, not {sigma:g}")
    return float(sigma)


def checked_population(population: int | None, default: int, least: int) -> int:
    """How many candidates a generation has.

    Raises:
        Error: fewer than the strategy needs.
    """
    if population is None:
        return default
    if population < least:
        raise Error(f"the population must be at least {least}, not {population}")
    return int(population)
