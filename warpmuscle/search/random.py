"""Random search: independent candidates, uniform within their intervals, to a given precision."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.search.search import BestSoFar, checked_costs, checked_population, checked_start, frozen

GENERATION = 500


class RandomSearch:
    """Uniform candidates (Bergmann 2017, section 6); the first one is where the search starts.

    Candidate k is the same for a given seed however many are asked for at a time.
    """

    def __init__(self, start: Floats, low: Floats, high: Floats, seed: int) -> None:
        """Search low..high, (P,) each, from a start (P,)."""
        self._start, self._low, self._high = start, low, high
        self._generator = np.random.default_rng(seed)
        self._first = True

    def ask(self, count: int) -> Floats:
        """The next candidates, (count, P)."""
        values = self._generator.uniform(self._low, self._high, size=(count, len(self._low)))
        if self._first and count > 0:
            values[0] = self._start
            self._first = False
        return values

    def tell(self, candidates: Floats, costs: Floats) -> None:
        """Costs (count,) of candidates (count, P); random search learns nothing from them."""


class RandomGenerations:
    """Random search of the unit cube by generations; it never finishes.

    Candidate k is the same for a given seed whatever the size of a generation, and the same as of `RandomSearch`.
    """

    def __init__(self, start: ArrayLike, seed: int, *, population: int | None = None) -> None:
        """Search from a start (P,), which is the first candidate.

        Args:
            population: candidates of a generation, by default 500.

        Raises:
            Error: the start lies outside the cube, or the population is not positive.
        """
        self._start = checked_start(start)
        self._population = checked_population(population, GENERATION, least=1)
        self._source = RandomSearch(self._start, np.zeros_like(self._start), np.ones_like(self._start), seed)
        self._progress = BestSoFar(self._start)
        self._asked: Floats | None = None

    def ask(self) -> Floats:
        """See `Search`."""
        if self._asked is None:
            self._asked = frozen(self._source.ask(self._population))
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`."""
        asked = self.ask()
        self._progress.add(asked, checked_costs(costs, len(asked)))
        self._asked = None

    def follow(self, candidates: Floats) -> bool:
        """See `Search`."""
        self.ask()
        self._asked = frozen(candidates)
        return True

    def finished(self) -> str:
        """Never."""
        return ""

    def step_size(self) -> float:
        """See `Search`; it has none."""
        return float("nan")

    def state(self) -> dict[str, Floats]:
        """See `Search`; the mean is the best candidate."""
        return self._progress.state(self._progress.best, np.nan)
