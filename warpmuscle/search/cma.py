"""CMA-ES with the `cma` package, alone or with restarts."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.search.bounds import LARGEST_DEVIATION, into_cube, out_of_cube, scattered
from warpmuscle.search.many_cma import usual_size
from warpmuscle.search.one_thread import one_thread
from warpmuscle.search.restarts import CmaRun, Restarts
from warpmuscle.search.search import BestSoFar, checked_costs, checked_population, checked_sigma, checked_start, frozen

_SPARED = [name for name in ("matplotlib", "scipy.stats") if name not in sys.modules]
with warnings.catch_warnings():
    warnings.simplefilter("ignore", UserWarning)  # it misses Matplotlib, which only its plots need
    # Its plots and surrogate models alone need these, which take twenty times as long to import as all the rest of it.
    sys.modules.update(dict.fromkeys(_SPARED))  # type: ignore[arg-type]
    try:
        import cma  # type: ignore[import-untyped]
    finally:
        for _name in _SPARED:
            del sys.modules[_name]

LEAST_POPULATION = 4  # two parents, so that the covariance has something to learn from
MIRRORED = 0.16  # of a generation: the other side of its worst candidates (Auger, Brockhoff, Hansen, GECCO 2011)


class CmaSearch:
    """CMA-ES with active covariance update (Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772).

    The strategy knows no bounds: what it samples is mapped into the cube by `into_cube`. Compared on functions with
    their optimum within the cube, on its faces and beyond them, that map was the most reliable: mirroring took twice
    the evaluations at a face, and the package's penalty for leaving the cube froze coordinates on faces where wide
    initial steps had put them.

    A restart begins at a point drawn around the start with the initial step size. With the default step size, that is
    nearly uniform in the cube, where Hansen (2009) has it; with a small one it remains in the neighbourhood that the
    caller meant.

    Linear algebra runs in one thread, which rounds the same on equal processors with any number of cores, and is the
    fastest for matrices of this size. BLAS has other kernels, which round differently, for other processors.
    """

    def __init__(
        self,
        start: ArrayLike,
        seed: int,
        *,
        population: int | None = None,
        sigma: float | None = None,
        restarts: str = "none",
    ) -> None:
        """Search from a start (P,), the mean of the first generation.

        Args:
            population: candidates of a generation, by default 4 + 3 ln P; the first one with restarts.
            sigma: initial step size, by default a quarter of the cube's edge.
            restarts: none, ipop or bipop, see `Restarts`.

        Raises:
            Error: the start lies outside the cube or has one coordinate only, or a setting cannot be used.
        """
        self._start = checked_start(start)
        if len(self._start) < 2:
            raise Error("CMA-ES needs at least two parameters; nlopt:LN_BOBYQA or random search one")
        population = checked_population(population, usual_size(len(self._start)), LEAST_POPULATION)
        self._restarts = Restarts(restarts, population, checked_sigma(sigma))
        self._generator = np.random.default_rng(seed)
        self._progress = BestSoFar(self._start)
        self._reason = ""
        self._asked: Floats | None = None
        self._sampled: list[Floats] = []  # what was asked, before the map into the cube
        self._strategy = self._begin(self._restarts.run, self._start)

    def ask(self) -> Floats:
        """See `Search`; the first call after `tell` samples a generation."""
        if self._reason:
            raise Error(f"the search has finished: {self._reason}")
        if self._asked is None:
            with one_thread():
                self._sampled = self._strategy.ask()
            self._asked = frozen(into_cube(np.array(self._sampled)))
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`; may end a run and begin the next one."""
        asked = self.ask()
        values = checked_costs(costs, len(asked))
        self._progress.add(asked, values)
        self._used += len(asked)
        with one_thread(), warnings.catch_warnings():
            # Where others were followed, the package misses mirrored candidates that it had asked for.
            warnings.simplefilter("ignore", cma.evolution_strategy.InjectionWarning)
            self._strategy.tell(self._sampled, values.tolist())
        self._asked, self._sampled = None, []
        reason = ", ".join(self._strategy.stop())
        if reason or self._used >= self._restarts.run.evaluations:
            run = self._restarts.next(self._used, self._generator)
            if run is None:
                self._reason = reason or "budget"
            else:
                self._strategy = self._begin(run, scattered(self._start, self._restarts.first.sigma, self._generator))

    def follow(self, candidates: Floats) -> bool:
        """See `Search`; the package takes what it has not sampled for injected (Hansen, arXiv:1110.4181)."""
        for row in np.flatnonzero(np.any(candidates != self.ask(), axis=1)):
            self._sampled[row] = out_of_cube(candidates[row])
        self._asked = frozen(candidates)
        return True

    def finished(self) -> str:
        """See `Search`; the names of the stopping criteria of the `cma` package that were met in the last run."""
        return self._reason

    def step_size(self) -> float:
        """See `Search`."""
        return float(self._strategy.sigma)

    def state(self) -> dict[str, Floats]:
        """See `Search`.

        Also `C` (P, P), the covariance without the step size; `path_sigma` and `path_c` (P,), the evolution paths;
        `population` and `restarts` (). They and `sigma` describe steps before the map into the cube, which is the
        identity but close to its faces.
        """
        strategy = self._strategy
        scale = np.broadcast_to(np.asarray(strategy.sigma_vec.scaling, dtype=np.float64), self._start.shape)
        path = getattr(strategy.adapt_sigma, "ps", None)
        return self._progress.state(into_cube(strategy.mean), strategy.sigma) | {
            "C": strategy.sm.C * np.outer(scale, scale),
            "path_sigma": np.zeros_like(self._start) if path is None else np.array(path, dtype=np.float64),
            "path_c": np.array(strategy.pc, dtype=np.float64),
            "population": np.array(self._restarts.run.population, dtype=np.float64),
            "restarts": np.array(self._restarts.count, dtype=np.float64),
        }

    def _begin(self, run: CmaRun, start: Floats) -> Any:
        """The strategy of a run from a point (P,) of the cube."""
        options = strategy_options(run.population, self._generator)
        self._used = 0  # evaluations of this run
        return cma.CMAEvolutionStrategy(out_of_cube(start), run.sigma, options)


def strategy_options(population: int, generator: np.random.Generator) -> dict[str, Any]:
    """Options of a strategy that draws from a generator of its own, prints nothing and touches no file."""
    return {
        "popsize": population,
        "randn": _normals(generator),
        "seed": np.nan,  # leaves NumPy's global generator alone
        # By default, from 300 parameters on, the package adapts the step size by another method, which draws from the
        # global generator.
        "AdaptSigma": cma.sigma_adaptation.CMAAdaptSigmaCSA,
        "maxstd": LARGEST_DEVIATION,
        "CMA_mirrors": MIRRORED,
        "verbose": -10,  # also ignores a file cma_signals.in
        "verb_log": 0,
        "verb_disp": 0,
    }


def _normals(generator: np.random.Generator) -> Callable[[int, int], Floats]:
    """What the package draws its standard normal numbers from; a closure, lest the search refers to itself."""

    def draw(count: int, dimensions: int) -> Floats:
        return generator.standard_normal((count, dimensions))

    return draw
