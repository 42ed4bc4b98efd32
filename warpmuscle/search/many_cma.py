"""CMA-ES of many populations of equal size at once, in arrays: thousands of candidates are asked for in milliseconds.

The `cma` package does more, one population and one candidate at a time; `search.cma` has it. Here the time of a
generation is that of its linear algebra.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.search.bounds import LARGEST_DEVIATION
from warpmuscle.search.one_thread import one_thread


def usual_size(parameters: int) -> int:
    """Candidates of a generation of CMA-ES alone (Hansen, arXiv:1604.00772, eq. 48)."""
    return 4 + int(3 * math.log(parameters))


@dataclass(frozen=True)
class Rates:
    """Weights and learning rates of a population (Hansen, arXiv:1604.00772, table 1)."""

    weights: Floats  # (population,), of ranks, the best first; negative ones of the worse half, of the covariance alone
    mass: float  # variance effective selection mass of the positive ones
    path_sigma: float
    damping: float
    path_c: float
    rank_one: float
    rank_mu: float

    @classmethod
    def of(cls, population: int, parameters: int) -> Rates:
        """The recommended ones."""
        n = parameters
        raw = math.log((population + 1) / 2) - np.log(np.arange(1, population + 1))
        good, bad = raw[raw > 0.0], raw[raw <= 0.0]
        mass = float(good.sum() ** 2 / (good**2).sum())
        rank_one = 2.0 / ((n + 1.3) ** 2 + mass)
        rank_mu = min(1.0 - rank_one, 2.0 * (0.25 + mass + 1.0 / mass - 2.0) / ((n + 2.0) ** 2 + mass))
        bad_mass = float(bad.sum() ** 2 / max((bad**2).sum(), 1e-300))
        least = min(
            1.0 + rank_one / rank_mu, 1.0 + 2.0 * bad_mass / (mass + 2.0), (1.0 - rank_one - rank_mu) / (n * rank_mu)
        )
        negative = least * bad / max(np.abs(bad).sum(), 1e-300)
        path_sigma = (mass + 2.0) / (n + mass + 5.0)
        return cls(
            weights=np.concatenate([good / good.sum(), negative]),
            mass=mass,
            path_sigma=path_sigma,
            damping=1.0 + 2.0 * max(0.0, math.sqrt((mass - 1.0) / (n + 1.0)) - 1.0) + path_sigma,
            path_c=(4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n),
            rank_one=rank_one,
            rank_mu=rank_mu,
        )


class ManyCma:
    """K populations, each with a mean, a step size, a covariance and evolution paths of its own.

    Linear algebra runs in one thread, which rounds the same on equal processors with any number of cores.

    Attributes:
        mean, path_sigma, path_c: (K, P). sigma: (K,). covariance: (K, P, P), without the step size.
    """

    def __init__(self, start: Floats, sigma: Floats, population: int) -> None:
        """Begin all at a start (P,) with step sizes (K,)."""
        count, n = len(sigma), len(start)
        self.population, self.rates = population, Rates.of(population, n)
        self.mean = np.tile(start, (count, 1))
        self.sigma = np.array(sigma, dtype=np.float64)
        self.covariance = np.tile(np.eye(n), (count, 1, 1))
        self.path_sigma, self.path_c = np.zeros((count, n)), np.zeros((count, n))
        self._axes, self._lengths = np.tile(np.eye(n), (count, 1, 1)), np.ones((count, n))
        self._count = np.zeros(count, dtype=np.int64)  # generations
        self._usual = math.sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n**2))  # length of a normal vector

    def ask(self, generator: np.random.Generator) -> Floats:
        """Candidates, (K, population, P), of all space."""
        count, n = self.mean.shape
        normal = generator.standard_normal((count, self.population, n))
        with one_thread():
            steps = (normal * self._lengths[:, None, :]) @ self._axes.transpose(0, 2, 1)
        return self.mean[:, None, :] + self.sigma[:, None, None] * steps

    def tell(self, candidates: Floats, costs: Floats) -> None:
        """Learn from candidates (K, population, P) and their costs (K, population) (Hansen 2016, figure 6)."""
        with one_thread():
            order = np.argsort(costs, axis=1, kind="stable")
            ranked = np.take_along_axis(candidates, order[:, :, None], axis=1)
            steps = (ranked - self.mean[:, None, :]) / self.sigma[:, None, None]
            self._count += 1
            self._learn(steps)
            self._decompose()

    def _learn(self, steps: Floats) -> None:
        """Move means, paths, covariances and step sizes by steps (K, population, P) in the order of their ranks."""
        rates, n = self.rates, self.mean.shape[1]
        good = rates.weights > 0.0
        step = np.einsum("i,kip->kp", rates.weights[good], steps[:, good])
        self.mean += self.sigma[:, None] * step
        keep = 1.0 - rates.path_sigma
        white = self._white(step[:, None, :])[:, 0]
        self.path_sigma *= keep
        self.path_sigma += math.sqrt(rates.path_sigma * (2.0 - rates.path_sigma) * rates.mass) * white
        length = np.linalg.norm(self.path_sigma, axis=1)
        grown = np.sqrt(1.0 - keep ** (2.0 * self._count))
        short = length / grown < (1.4 + 2.0 / (n + 1.0)) * self._usual
        self.path_c *= 1.0 - rates.path_c
        gain = math.sqrt(rates.path_c * (2.0 - rates.path_c) * rates.mass)
        self.path_c[short] += gain * step[short]
        self._learn_covariance(steps, short)
        self.sigma *= np.exp(np.minimum(rates.path_sigma / rates.damping * (length / self._usual - 1.0), 1.0))
        widest = np.sqrt(np.einsum("kpp->kp", self.covariance).max(axis=1))
        self.sigma = np.minimum(self.sigma, LARGEST_DEVIATION / widest)

    def _learn_covariance(self, steps: Floats, short: Floats) -> None:
        """Both updates of the covariances, the second with negative weights for the worse half (eq. 46, 47)."""
        rates, n = self.rates, self.mean.shape[1]
        weights = np.tile(rates.weights, (len(steps), 1))
        bad = rates.weights < 0.0
        if bad.any():
            weights[:, bad] *= n / np.maximum((self._white(steps[:, bad]) ** 2).sum(axis=2), 1e-300)
        lost = np.where(short, 0.0, rates.path_c * (2.0 - rates.path_c))
        kept = 1.0 - rates.rank_one * (1.0 - lost) - rates.rank_mu * rates.weights.sum()
        self.covariance *= kept[:, None, None]
        self.covariance += rates.rank_one * self.path_c[:, :, None] * self.path_c[:, None, :]
        self.covariance += rates.rank_mu * (steps.transpose(0, 2, 1) * weights[:, None, :]) @ steps

    def _white(self, steps: Floats) -> Floats:
        """Steps (K, n, P) times the inverse square root of the covariance."""
        turned: Floats = (steps @ self._axes) / self._lengths[:, None, :]
        return np.asarray(turned @ self._axes.transpose(0, 2, 1))

    def _decompose(self) -> None:
        """Axes and their lengths, of covariances that are made symmetric and positive."""
        self.covariance = 0.5 * (self.covariance + self.covariance.transpose(0, 2, 1))
        values, self._axes = np.linalg.eigh(self.covariance)
        self._lengths = np.sqrt(np.maximum(values, 1e-14 * values.max(axis=1, keepdims=True)))

    def copy(self, source: int, target: int, factor: float) -> None:
        """Let one population go on where another one stands, with its step size times a factor."""
        for array in (self.mean, self.covariance, self.path_sigma, self.path_c, self._axes, self._lengths, self._count):
            array[target] = array[source]
        self.sigma[target] = factor * self.sigma[source]

    def spans(self) -> Floats:
        """Standard deviation along the longest axis of each population, (K,)."""
        return np.asarray(self.sigma * self._lengths.max(axis=1))
