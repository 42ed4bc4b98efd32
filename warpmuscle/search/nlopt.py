"""The algorithms of NLopt, turned inside out."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import nlopt  # type: ignore[import-untyped]
import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.search.adapter import Abandoned, AskTellAdapter, Evaluate
from warpmuscle.search.differences import gradient, stencil
from warpmuscle.search.search import BestSoFar, checked_costs, checked_population, checked_sigma, checked_start

GRADIENT_STEP = 1e-4
TOLERANCE = 1e-9  # of the cube's edge: an algorithm with steps below that has converged
REASONS = {
    nlopt.SUCCESS: "success",
    nlopt.STOPVAL_REACHED: "stopval",
    nlopt.FTOL_REACHED: "ftol",
    nlopt.XTOL_REACHED: "xtol",
    nlopt.MAXEVAL_REACHED: "maxeval",
    nlopt.MAXTIME_REACHED: "maxtime",
}
# These do not come back once told to stop, and hold Python's lock meanwhile, so that the whole program would freeze;
# the last one may do so in its ordinary course as well (stevengj/nlopt, issue 117).
UNSTOPPABLE = ("GD_STOGO", "GD_STOGO_RAND", "LN_NEWUOA_BOUND")


def algorithms() -> list[str]:
    """Names of the algorithms that this NLopt can be asked for."""
    names = [name for name in dir(nlopt) if re.fullmatch(r"(G|GN|GD|LN|LD)_\w+|AUGLAG(_EQ)?", name)]
    return [name for name in names if name not in UNSTOPPABLE]


class NloptSearch:
    """An algorithm of NLopt (Johnson, "The NLopt nonlinear-optimization package"), one candidate at a time.

    NLopt calls the objective back, hence it runs in a thread that waits there until `tell`. Its random numbers come
    from a generator of its own for each thread, so that searches side by side do not disturb each other.

    Algorithms with gradients (LD_ and GD_) ask for the 2 P + 1 candidates of a central difference at once, or for a
    single one when they need no gradient. MLSL and AUGLAG use LD_LBFGS, or LN_BOBYQA without gradients. Those that
    cannot be interrupted are refused.
    """

    def __init__(
        self,
        algorithm: str,
        start: ArrayLike,
        seed: int,
        *,
        population: int | None = None,
        sigma: float | None = None,
        gradient_step: float = GRADIENT_STEP,
        tolerance: float = TOLERANCE,
    ) -> None:
        """Search from a start (P,), which global algorithms may ignore.

        Args:
            algorithm: by its NLopt name, such as LN_BOBYQA.
            population: of the algorithms that have one, by default theirs.
            sigma: initial step of local algorithms without gradient, by default NLopt's: a quarter of the edge, or
                less close to a face.
            gradient_step: of the differences.
            tolerance: the search ends when its steps are smaller; 0 for never.

        Raises:
            Error: there is no such algorithm, it refuses to start, or the start or a setting cannot be used.
        """
        if algorithm in UNSTOPPABLE:
            raise Error(f"NLopt's {algorithm} cannot be interrupted, hence not be used; LN_BOBYQA and G_MLSL_LDS can")
        if algorithm not in algorithms():
            raise Error(f"NLopt has no algorithm {algorithm!r}")
        point = checked_start(start)
        if not 0.0 < gradient_step <= 0.25:
            raise Error(f"the step of a gradient must be positive and at most 0.25, not {gradient_step}")
        if population is not None:
            population = checked_population(population, population, least=1)
        if sigma is not None:
            sigma = checked_sigma(sigma)
        self._progress = BestSoFar(point)
        body = _body(algorithm, point, seed, population, sigma, gradient_step, tolerance)
        self._algorithm = algorithm
        try:
            self._inside_out = AskTellAdapter(body, f"nlopt {algorithm}")
        except Exception as error:
            raise self._refusal(error) from error

    def ask(self) -> Floats:
        """See `Search`."""
        if self._inside_out.wanted is None:
            raise Error(f"the search has finished: {self._inside_out.result}")
        return self._inside_out.wanted

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`; returns when NLopt wants the next candidate or has ended."""
        asked = self.ask()
        values = checked_costs(costs, len(asked))
        self._progress.add(asked, values)
        try:
            self._inside_out.tell(values.copy())
        except Exception as error:
            raise self._refusal(error) from error

    def follow(self, candidates: Floats) -> bool:
        """See `Search`; the algorithms of NLopt take nothing but costs."""
        return np.array_equal(candidates, self.ask())

    def finished(self) -> str:
        """See `Search`; what NLopt returned in small letters, such as xtol, or roundoff or failure."""
        return self._inside_out.result or ""

    def step_size(self) -> float:
        """See `Search`; it has none."""
        return float("nan")

    def state(self) -> dict[str, Floats]:
        """See `Search`; the mean is the best candidate."""
        return self._progress.state(self._progress.best, np.nan)

    def _refusal(self, error: Exception) -> Error:
        text = str(error) or "invalid argument"
        return Error(
            f"NLopt's {self._algorithm} cannot search {number_of(len(self._progress.best), 'parameter')} so: {text}"
        )


def _body(
    algorithm: str,
    start: Floats,
    seed: int,
    population: int | None,
    sigma: float | None,
    gradient_step: float,
    tolerance: float,
) -> Callable[[Evaluate], str]:
    """What the thread does: optimise, and say why that ended."""

    def body(evaluate: Evaluate) -> str:
        def objective(x: Floats, slope: Floats) -> float:
            point = np.clip(x, 0.0, 1.0)  # rounding may lead NLopt out
            try:
                if slope.size == 0:
                    return float(evaluate(point[np.newaxis])[0])
                points, offsets = stencil(point, gradient_step)
                values = evaluate(points)
            except Abandoned:
                raise nlopt.ForcedStop from None
            slope[:] = gradient(values, offsets)
            return float(values[0])

        nlopt.srand(seed % 2**32)  # of this thread alone
        optimizer = _optimizer(algorithm, len(start), tolerance)
        if re.search("MLSL|AUGLAG", algorithm):
            inner = "LD_LBFGS" if algorithm.startswith(("LD_", "GD_")) else "LN_BOBYQA"
            optimizer.set_local_optimizer(_optimizer(inner, len(start), tolerance))
        if population is not None:
            optimizer.set_population(population)
        if sigma is not None:
            optimizer.set_initial_step(sigma)
        optimizer.set_min_objective(objective)
        try:
            optimizer.optimize(start)
        except (nlopt.RoundoffLimited, nlopt.roundoff_limited):
            return "roundoff"
        except nlopt.runtime_error:
            return "failure"
        return REASONS.get(optimizer.last_optimize_result(), "success")

    return body


def _optimizer(algorithm: str, dimensions: int, tolerance: float) -> Any:
    """An optimizer of the cube."""
    optimizer = nlopt.opt(getattr(nlopt, algorithm), dimensions)
    optimizer.set_lower_bounds(np.zeros(dimensions))
    optimizer.set_upper_bounds(np.ones(dimensions))
    optimizer.set_xtol_abs(tolerance)
    return optimizer
