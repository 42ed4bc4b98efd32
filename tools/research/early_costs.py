"""How much of a search's motion could be saved if candidates were compared before their end.

For docs/how-to/choose-a-strategy.md.

    python tools/research/early_costs.py fwalk --candidates 800
    python tools/research/early_costs.py walk56_search --candidates 320 --device cpu

A search runs as usual; its candidates are looked at after each tenth of their time. For each generation: how much
motion the candidates that fall leave unsimulated anyway; how many of the better half at the end are in the better half
already, which is what rungs of short runs would keep; whether costs of those that reach the end ever fall, since
only what grows can tell early that a candidate is out; and the motion that is simulated after it was.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.simulation.candidates import CandidateBatch

LOOKS = 10


class Looks:
    """Costs of all candidates of a search over time, by batch: (LOOKS, n) each, infinite once they have failed."""

    def __init__(self) -> None:
        self.costs: list[Floats] = []
        self.ends: list[Floats] = []  # (n,) part of the time that each came to

    def run(self, plain: Callable[..., None]) -> Callable[..., None]:
        """A way to run batches that looks at them."""

        def run(trials: CandidateBatch, duration: float | None = None, progress: Any = None) -> None:
            if duration is not None:
                plain(trials, duration, progress)
                return
            whole, seen = trials.batch.scene.duration, []
            for look in range(LOOKS):
                plain(trials, None if look == LOOKS - 1 else whole / LOOKS, progress)
                seen.append(trials.cost().copy())
            self.costs.append(np.array(seen))
            ends = trials.batch.end_time().reshape(-1, trials.runs)
            self.ends.append(ends.mean(axis=1) / whole)

        return run


def kept(costs: Floats) -> Floats:
    """Of the better half at the end, the part that is in the better half at each look, (LOOKS,)."""
    half = max(costs.shape[1] // 2, 1)
    better = [set(np.argsort(row, kind="stable")[:half].tolist()) for row in costs]
    return np.array([len(found & better[-1]) / half for found in better])


def saved(costs: Floats, ends: Floats) -> float:
    """Of the motion simulated, the part that comes after a candidate's cost has passed the final median cost.

    The median is known at the end only: a search that stopped candidates by an earlier generation would save less.
    """
    passed = costs > np.median(costs[-1])
    first = np.where(passed.any(axis=0), (passed.argmax(axis=0) + 1) / LOOKS, 1.0)
    return float(np.maximum(ends - first, 0.0).sum() / ends.sum())


def main(
    scene: str,
    candidates: Annotated[int, typer.Option(help="In all.")] = 800,
    search: Annotated[str, typer.Option(help="Strategy.")] = "cma",
    population: Annotated[int | None, typer.Option(help="Of a generation.")] = None,
    sigma: Annotated[float | None, typer.Option(help="First step.")] = None,
    seed: int = 1,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
) -> None:
    """Print what early costs say about late ones, in quarters of the search."""
    wp.config.log_level = wp.LOG_WARNING
    warnings.simplefilter("ignore")
    looks = Looks()
    plain = CandidateBatch.run
    CandidateBatch.run = looks.run(plain)  # type: ignore[method-assign]
    try:
        optimize(load(scene), candidates, seed, device, search=search, population=population, sigma=sigma)
    finally:
        CandidateBatch.run = plain  # type: ignore[method-assign]
    print(f"{scene}: {len(looks.costs)} batches; in quarters of the search")
    names = ("batches", "of the time simulated", "of the better half, better at 10, 30, 50, 70 %", "costs that fell",
             "motion beyond the median cost")  # fmt: skip
    print(f"| {' | '.join(names)} |")
    print("|---|---|---|---|---|")
    for part in (some for some in np.array_split(np.arange(len(looks.costs)), 4) if len(some)):
        same = np.mean([kept(looks.costs[k]) for k in part], axis=0)
        time = np.mean([looks.ends[k].mean() for k in part])
        steps = [np.diff(looks.costs[k][:, looks.ends[k] >= 1.0 - 1e-6], axis=0).ravel() for k in part]
        every = np.concatenate(steps)
        fell = np.mean(every < 0.0) if len(every) else 0.0
        beyond = np.mean([saved(looks.costs[k], looks.ends[k]) for k in part])
        early = ", ".join(f"{100.0 * same[k]:.0f}" for k in (0, 2, 4, 6))
        print(f"| {part[0]} to {part[-1]} | {100.0 * time:.0f} % | {early} % | {100.0 * fell:.0f} % | "
              f"{100.0 * beyond:.0f} % |")  # fmt: skip


if __name__ == "__main__":
    run_script(main)
