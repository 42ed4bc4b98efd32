"""When a CMA-ES starts again, and with which population and step size."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.errors import Error

KINDS = ("none", "ipop", "bipop")
DOUBLINGS = 9  # Hansen (2009)


@dataclass(frozen=True)
class CmaRun:
    """One strategy from its start to its end."""

    population: int
    sigma: float  # initial step size
    evaluations: float = math.inf  # after which it ends at the latest
    large: bool = False  # of the regime with doubled populations


class Restarts:
    """A sequence of runs.

    ipop: the population doubles from run to run (Auger and Hansen, "A restart CMA evolution strategy with increasing
    population size", CEC 2005).

    bipop: after a first run, that regime has its turn which has used fewer evaluations: the large one as in ipop, or
    the small one, with a population between the first and half of the last large one, a step size down to a
    hundredth, and at most half the evaluations of the last large run (Hansen, "Benchmarking a BI-population CMA-ES on
    the BBOB-2009 function testbed", GECCO 2009). The first run counts as a small one, as in the `cma` package.
    """

    def __init__(self, kind: str, population: int, sigma: float) -> None:
        """Begin with a population and an initial step size.

        Raises:
            Error: there is no such kind.
        """
        if kind not in KINDS:
            raise Error(f"restarts are one of {', '.join(KINDS)}, not {kind!r}")
        self._kind = kind
        self.run = CmaRun(population, sigma)
        self.count = 0  # of restarts so far
        self.first = self.run
        self._doublings = 0
        self._spent = {False: 0, True: 0}  # evaluations by regime: small, large
        self._last_large = 0  # evaluations of the last large run

    def next(self, evaluations: int, generator: np.random.Generator) -> CmaRun | None:
        """The run after the current one, which has used so many evaluations; None if there shall be no more."""
        self._spent[self.run.large] += evaluations
        if self.run.large:
            self._last_large = evaluations
        run: CmaRun | None = None
        if self._kind == "bipop" and self._spent[False] < self._spent[True]:
            run = self._small(generator)
        elif self._kind != "none" and self._doublings < DOUBLINGS:
            self._doublings += 1
            run = CmaRun(self.first.population * 2**self._doublings, self.first.sigma, large=True)
        if run is not None:
            self.run, self.count = run, self.count + 1
        return run

    def _small(self, generator: np.random.Generator) -> CmaRun:
        """A small run (Hansen 2009, section 2)."""
        finer, larger = generator.uniform(size=2)
        population = int(self.first.population * (0.5 * 2**self._doublings) ** (larger**2))
        return CmaRun(population, self.first.sigma * 10.0 ** (-2.0 * finer), 0.5 * self._last_large)
