"""Many small CMA-ES at once, the worst of which give way to copies of the best: made for thousands of evaluations."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.search.bounds import scattered
from warpmuscle.search.cma import CmaSearch, usual_population
from warpmuscle.search.search import (
    BestSoFar,
    checked_costs,
    checked_population,
    checked_sigma,
    checked_start,
    frozen,
)

ISLANDS = 40  # where nobody says how many candidates a generation has
SMALLEST_SPREAD = 0.1  # of the step size that was asked for, among the islands
EXCHANGE = 10  # generations between two exchanges
REPLACED = 0.25  # of the islands at an exchange
STRETCH = 2.0  # of a copy's step size, at most, in either direction


class IslandSearch:
    """Islands of CMA-ES with copies of the best in the place of the worst.

    A machine that evaluates thousands of candidates in the time of one does not find more by one population of
    thousands: its steps are no more, only surer. Islands take many paths at once, with step sizes of their own. Every
    so many generations, those whose latest generations came to the least of all are given up, and copies of the best
    ones go on in their place, with another step size and random numbers of their own. Such selection among whole
    strategies is that of population based training (Jaderberg et al., arXiv:1711.09846), with CMA-ES as what is
    trained.
    """

    def __init__(
        self,
        start: ArrayLike,
        seed: int,
        *,
        population: int | None = None,
        sigma: float | None = None,
        island: int | None = None,
    ) -> None:
        """Search from a start (P,).

        Args:
            population: candidates of a generation, of all islands together.
            sigma: initial step size of the first island; the others have smaller ones, down to a tenth.
            island: candidates of a generation of an island, by default as CMA-ES recommends.

        Raises:
            Error: the start lies outside the cube or has one coordinate only, or a setting cannot be used.
        """
        self._start = checked_start(start)
        least = usual_population(len(self._start)) if island is None else island
        population = checked_population(population, ISLANDS * least, least)
        count = population // least
        sizes = [len(part) for part in np.array_split(np.arange(population), count)]
        self._generator = np.random.default_rng(seed)
        spread = checked_sigma(sigma)
        self._islands = [self._island(size, spread, first=index == 0) for index, size in enumerate(sizes)]
        self._latest = np.full((EXCHANGE, count), np.inf)  # least cost of each island in the latest generations
        self._generation = 0
        self._progress = BestSoFar(self._start)
        self._asked: Floats | None = None

    def ask(self) -> Floats:
        """See `Search`."""
        if reason := self.finished():
            raise Error(f"the search has finished: {reason}")
        if self._asked is None:
            self._asked = frozen(np.concatenate([island.ask() for island in self._islands]))
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`; every so often the worst islands give way."""
        asked = self.ask()
        values = checked_costs(costs, len(asked))
        self._progress.add(asked, values)
        begin, row = 0, self._latest[self._generation % EXCHANGE]
        for index, island in enumerate(self._islands):
            part = values[begin : begin + len(island.ask())]
            begin += len(part)
            row[index] = part.min()
            island.tell(part)
        self._asked = None
        self._generation += 1
        if self._generation % EXCHANGE == 0 or any(island.finished() for island in self._islands):
            self._exchange()

    def follow(self, candidates: Floats) -> bool:
        """See `Search`."""
        begin = 0
        for island in self._islands:
            end = begin + len(island.ask())
            island.follow(candidates[begin:end])
            begin = end
        self._asked = frozen(candidates)
        return True

    def finished(self) -> str:
        """See `Search`; an island that has converged gives way, so that this search goes on."""
        return self._islands[0].finished() if len(self._islands) == 1 else ""

    def step_size(self) -> float:
        """See `Search`: that of the best island."""
        return self._islands[self._ranks()[0]].step_size()

    def state(self) -> dict[str, Floats]:
        """See `Search`; mean, step size and covariance are those of the best island, the rest of all."""
        state = self._islands[self._ranks()[0]].state()
        whole = self._progress.state(state["mean"], float(state["sigma"]))
        return state | whole | {"population": np.array(float(sum(len(one.ask()) for one in self._islands)))}

    def _island(self, size: int, spread: float, first: bool) -> CmaSearch:
        """An island at the start, or at a point about it with a step size of its own."""
        if first:
            return CmaSearch(self._start, int(self._generator.integers(2**63)), population=size, sigma=spread)
        step = spread * SMALLEST_SPREAD ** self._generator.uniform()
        point = scattered(self._start, step * self._generator.uniform(), self._generator)
        return CmaSearch(point, int(self._generator.integers(2**63)), population=size, sigma=step)

    def _merits(self) -> Floats:
        """Least cost of each island in its latest generations, (islands,), infinite of those that have finished."""
        over = [bool(island.finished()) for island in self._islands]
        return np.where(over, np.inf, self._latest.min(axis=0))

    def _ranks(self) -> list[int]:
        """Islands, the best first; of equal ones the first."""
        return [int(index) for index in np.argsort(self._merits(), kind="stable")]

    def _exchange(self) -> None:
        """Let copies of the best islands take the place of the worst, and of all that have converged."""
        if len(self._islands) == 1:
            return
        ranks = self._ranks()
        count = max(int(REPLACED * len(ranks)), 1)
        over = [index for index in ranks if self._islands[index].finished()]
        worst = list(dict.fromkeys([*over, *ranks[len(ranks) - count :]]))
        best = [index for index in ranks[:count] if index not in worst] or ranks[:1]
        for place, index in enumerate(worst):
            source = best[place % len(best)]
            factor = STRETCH ** self._generator.uniform(-1.0, 1.0)
            self._islands[index] = self._islands[source].branch(factor, int(self._generator.integers(2**63)))
            self._latest[:, index] = self._latest[:, source]
