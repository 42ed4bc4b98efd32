"""Whether a model of the cost can tell, before they are simulated, which candidates of a search are worth it.

For docs/how-to/choose-a-strategy.md.

    python tools/research/surrogates.py run56.h5 walk56_person.h5
    python tools/research/surrogates.py fwalk.h5 --latest 1000

Each file is the result of a search. For one generation after the other, models are fitted to the latest candidates
before it, and rank those of the generation. Told are the part of the better half of those that was put into the better
half, which is what a search could keep by simulating half of what it asks for (half would be right by chance), and
Spearman's rank correlation, by quarter of the search. Models see the ranks of costs, in coordinates in which the
generation has unit spread:

nearest: mean of the ten nearest candidates. quadratic: linear and square terms, ridge regression. process: a Gaussian
process with a squared exponential kernel as wide as candidates are apart.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.results.result import read

NEAREST = 10
RIDGE = 1e-2  # of the number of candidates
NOISE = 0.3  # variance of ranks that a process does not explain, over their own
QUARTERS = 4
GENERATIONS = 40  # at most, that are looked at of each quarter, evenly spaced
SMALLEST = 8  # candidates of a generation that can be ranked


def ranks(costs: Floats) -> Floats:
    """Ranks with mean 0 and variance 1."""
    order = np.argsort(np.argsort(costs, kind="stable"), kind="stable").astype(float)
    return np.asarray((order - order.mean()) / max(float(order.std()), 1e-12))


def squared_distances(one: Floats, other: Floats) -> Floats:
    """Of all rows of one array to all of another."""
    return np.asarray(np.maximum((one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1) - 2.0 * one @ other.T, 0.0))


def nearest(known: Floats, costs: Floats, asked: Floats) -> Floats:
    """Mean of the nearest candidates."""
    count = min(NEAREST, len(known))
    places = np.argpartition(squared_distances(asked, known), count - 1, axis=1)[:, :count]
    return np.asarray(costs[places].mean(axis=1))


def quadratic(known: Floats, costs: Floats, asked: Floats) -> Floats:
    """Ridge regression on all coordinates and their squares."""

    def terms(points: Floats) -> Floats:
        return np.hstack([np.ones((len(points), 1)), points, points**2])

    matrix = terms(known)
    normal = matrix.T @ matrix + RIDGE * len(known) * np.eye(matrix.shape[1])
    return np.asarray(terms(asked) @ np.linalg.solve(normal, matrix.T @ costs))


def process(known: Floats, costs: Floats, asked: Floats) -> Floats:
    """The mean of a Gaussian process."""
    inner = squared_distances(known, known)
    width = max(float(np.median(inner)), 1e-12)
    covariance = np.exp(-inner / width) + NOISE * np.eye(len(known))
    return np.asarray(np.exp(-squared_distances(asked, known) / width) @ np.linalg.solve(covariance, costs))


MODELS: dict[str, Callable[[Floats, Floats, Floats], Floats]] = {
    "nearest": nearest, "quadratic": quadratic, "process": process,
}  # fmt: skip


def told(params: Floats, costs: Floats, number: Floats, latest: int) -> dict[str, Floats]:
    """By model: (QUARTERS, 2) part of the better half that was found, and rank correlation."""
    count = int(number.max()) + 1
    found = {name: np.full((QUARTERS, 2), np.nan) for name in MODELS}
    for quarter in range(QUARTERS):
        first, last = max(quarter * count // QUARTERS, 1), (quarter + 1) * count // QUARTERS
        results: dict[str, list[tuple[float, float]]] = {name: [] for name in MODELS}
        for generation in np.unique(np.linspace(first, max(last - 1, first), GENERATIONS).astype(int)):
            here, before = np.flatnonzero(number == generation), np.flatnonzero(number < generation)[-latest:]
            if len(here) < SMALLEST or len(before) < SMALLEST:
                continue
            spread = np.maximum(params[here].std(axis=0), 1e-9)
            middle = params[here].mean(axis=0)
            asked, known = (params[here] - middle) / spread, (params[before] - middle) / spread
            true = ranks(costs[here])
            for name, model in MODELS.items():
                predicted = ranks(model(known, ranks(costs[before]), asked))
                half = len(here) // 2
                better = set(np.argsort(true)[:half].tolist()) & set(np.argsort(predicted)[:half].tolist())
                results[name].append((len(better) / half, float(np.mean(true * predicted))))
        for name, pairs in results.items():
            if pairs:
                found[name][quarter] = np.mean(pairs, axis=0)
    return found


def main(
    files: list[Path],
    latest: Annotated[int, typer.Option(help="Candidates before a generation that models are fitted to.")] = 1500,
) -> None:
    """Print a table: a line a model, a column a quarter of the search."""
    print("| search | model | better half found, % by quarter | rank correlation, by quarter |")
    print("|---|---|---|---|")
    for file in files:
        result = read(file)
        assert result.evaluations is not None
        table, given = result.evaluations, result.parameters
        low, high = np.asarray(given.min, dtype=float), np.asarray(given.max, dtype=float)
        unit = (np.asarray(table.params, dtype=float) - low) / np.maximum(high - low, 1e-300)
        found = told(unit, np.asarray(table.cost, dtype=float), np.asarray(table.generation), latest)
        for name, parts in found.items():
            halves = ", ".join(f"{100.0 * half:.0f}" for half in parts[:, 0])
            correlations = ", ".join(f"{value:.2f}" for value in parts[:, 1])
            print(f"| {file.stem} | {name} | {halves} | {correlations} |")


if __name__ == "__main__":
    run_script(main)
