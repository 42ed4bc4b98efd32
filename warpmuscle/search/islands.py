"""Islands of CMA-ES, the worst of which give way to copies of the best: made for thousands of evaluations at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.search.bounds import into_cube, out_of_cube
from warpmuscle.search.many_cma import ManyCma, usual_size
from warpmuscle.search.search import BestSoFar, checked_costs, checked_population, checked_sigma, checked_start, frozen

ISLANDS = 5  # where nobody says how many candidates a generation has, and on a GPU at most
ENLARGED = 7  # an island has so many times the candidates of a generation of CMA-ES alone
LEAST_POPULATION = 4
SMALLEST_SPREAD = 0.04  # of the step size that was asked for, among the islands
EXCHANGE = 5  # generations between two exchanges
REPLACED = 0.25  # of the islands at an exchange
STRETCH = 2.0  # of a copy's step size, at most, in either direction
CONVERGED = 1e-7  # standard deviation along the longest axis of an island, as a part of the cube's edge
GREATEST_RESTART = 1e-2  # step size of a copy in the place of a converged island, as a part of the cube's edge


class IslandSearch:
    """Islands of CMA-ES with copies of the best in the place of the worst.

    On a machine that evaluates thousands of candidates in the time of one, a single population of thousands takes no
    more steps, only surer ones, and many small populations take many small steps. Islands of a middling size take
    several paths at once, each with a step size of its own: all begin at the start, the first with the step size that
    was asked for, the others with smaller ones. Every so many generations the islands whose latest generations found
    the least are given up, and copies of the best ones go on in their place with other step sizes. Such selection among
    whole strategies is that of population based training (Jaderberg et al., arXiv:1711.09846), with CMA-ES as what is
    trained.

    Bounds are those of `CmaSearch`.
    """

    def __init__(
        self,
        start: ArrayLike,
        seed: int,
        *,
        population: int | None = None,
        sigma: float | None = None,
        islands: int | None = None,
    ) -> None:
        """Search from a start (P,).

        Args:
            population: candidates of a generation, of all islands together; a few less where islands do not divide it.
            sigma: initial step size of the first island; the others have smaller ones, down to a 25th.
            islands: how many; by default such that each has seven times the candidates of CMA-ES alone.

        Raises:
            Error: the start lies outside the cube or has one coordinate only, or a setting cannot be used.
        """
        point = checked_start(start)
        if len(point) < 2:
            raise Error("islands need at least two parameters; nlopt:LN_BOBYQA or random search one")
        size = ENLARGED * usual_size(len(point))
        population = checked_population(population, ISLANDS * size, LEAST_POPULATION)
        count = max(round(population / size), 1) if islands is None else islands
        steps = checked_sigma(sigma) * np.geomspace(1.0, SMALLEST_SPREAD, count)
        self._generator = np.random.default_rng(seed)
        self._islands = ManyCma(out_of_cube(point), steps, max(population // count, LEAST_POPULATION))
        self._latest = np.full((EXCHANGE, count), np.inf)  # least cost of each island in the latest generations
        self._generation = 0
        self._progress = BestSoFar(point)
        self._sampled: Floats | None = None  # before the map into the cube
        self._asked: Floats | None = None
        self._reason = ""

    def ask(self) -> Floats:
        """See `Search`."""
        if self._reason:
            raise Error(f"the search has finished: {self._reason}")
        if self._asked is None:
            self._sampled = self._islands.ask(self._generator)
            self._asked = frozen(into_cube(self._sampled.reshape(-1, self._sampled.shape[2])))
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`; every so often the worst islands give way."""
        asked = self.ask()
        values = checked_costs(costs, len(asked))
        self._progress.add(asked, values)
        assert self._sampled is not None
        by_island = values.reshape(self._sampled.shape[:2])
        self._latest[self._generation % EXCHANGE] = by_island.min(axis=1)
        self._islands.tell(self._sampled, by_island)
        self._asked = self._sampled = None
        self._generation += 1
        converged = self._islands.spans() < CONVERGED
        if len(converged) == 1:
            self._reason = "converged" if converged[0] else ""
        elif converged.any() or self._generation % EXCHANGE == 0:
            self._exchange(converged)

    def follow(self, candidates: Floats) -> bool:
        """See `Search`."""
        asked = self.ask()
        assert self._sampled is not None
        moved = np.any(candidates != asked, axis=1).reshape(self._sampled.shape[:2])
        self._sampled[moved] = out_of_cube(candidates[moved.ravel()])
        self._asked = frozen(candidates)
        return True

    def finished(self) -> str:
        """See `Search`; an island that has converged gives way, so that only one that is alone finishes."""
        return self._reason

    def step_size(self) -> float:
        """See `Search`: that of the island that found the least of late."""
        return float(self._islands.sigma[self._ranks()[0]])

    def state(self) -> dict[str, Floats]:
        """See `Search`; mean and step size are those of the island that found the least of late.

        Also its covariance `C` (P, P) without the step size, and of all islands `means` (K, P), `sigmas` (K,) and
        `latest` (K,), the least cost of each in its latest generations.
        """
        best = self._ranks()[0]
        return self._progress.state(into_cube(self._islands.mean[best]), self.step_size()) | {
            "C": self._islands.covariance[best].copy(),
            "means": into_cube(self._islands.mean),
            "sigmas": self._islands.sigma.copy(),
            "latest": self._latest.min(axis=0),
        }

    def _ranks(self) -> list[int]:
        """Islands, the best of late first; of equal ones the first."""
        return [int(index) for index in np.argsort(self._latest.min(axis=0), kind="stable")]

    def _exchange(self, converged: np.ndarray) -> None:
        """Let copies of the best islands take the place of the worst, and of all that have converged."""
        ranks = self._ranks()
        count = max(int(REPLACED * len(ranks)), 1)
        due = ranks[len(ranks) - count :] if self._generation % EXCHANGE == 0 else []
        worst = [index for index in ranks if converged[index] or index in due]
        best = [index for index in ranks[:count] if index not in worst] or [ranks[0]]
        for place, index in enumerate(worst):
            source = best[place % len(best)]
            self._islands.copy(source, index, STRETCH ** self._generator.uniform(-1.0, 1.0))
            if converged[index]:
                self._islands.sigma[index] = max(
                    float(self._islands.sigma[index]), GREATEST_RESTART * self._generator.uniform()
                )
            self._latest[:, index] = self._latest[:, source]
