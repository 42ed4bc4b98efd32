"""Searches by name."""

from __future__ import annotations

import difflib

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.search.bounds import scattered
from warpmuscle.search.random import RandomGenerations
from warpmuscle.search.search import Search, checked_sigma, checked_start

SMALLEST_SPREAD = 0.1  # of the step size that was asked for, among many searches


def make_search(
    name: str,
    dimensions: int,
    start: ArrayLike | None,
    seed: int,
    *,
    population: int | None = None,
    sigma: float | None = None,
    restarts: str = "none",
) -> Search:
    """A search of the unit cube.

    Args:
        name: islands, cma, cma:ipop, cma:bipop, random, or nlopt:ALGORITHM such as nlopt:LN_BOBYQA.
        dimensions: how many parameters, P.
        start: a point (P,) of the cube, None for its middle.
        population: candidates of a generation, by default as many as the strategy recommends.
        sigma: initial step size as a fraction of the cube's edge.
        restarts: of cma, none, ipop or bipop, when the name does not say.

    Raises:
        Error: there is no such strategy, or it cannot be used with these settings.
    """
    point = np.full(dimensions, 0.5) if start is None else checked_start(start)
    if point.shape != (dimensions,):
        raise Error(f"the start has {number_of(len(point), 'coordinate')} for {number_of(dimensions, 'parameter')}")
    family, _, detail = name.partition(":")
    if name in ("cma", "cma:ipop", "cma:bipop"):
        from warpmuscle.search.cma import CmaSearch  # which other searches need not wait for

        if detail and restarts not in ("none", detail):
            raise Error(f"{name} cannot have restarts {restarts!r} as well")
        return CmaSearch(point, seed, population=population, sigma=sigma, restarts=detail or restarts)
    if name == "islands" and restarts == "none":
        from warpmuscle.search.islands import IslandSearch

        return IslandSearch(point, seed, population=population, sigma=sigma)
    from warpmuscle.search.nlopt import UNSTOPPABLE, NloptSearch

    if name not in _names() and not (family == "nlopt" and detail in UNSTOPPABLE):
        raise Error(_unknown(name))
    if restarts != "none":
        raise Error(f"{name} has no restarts; cma has")
    if family == "nlopt":
        return NloptSearch(detail, point, seed, population=population, sigma=sigma)
    return RandomGenerations(point, seed, population=population)


def make_searches(
    name: str,
    dimensions: int,
    start: ArrayLike | None,
    seed: int,
    count: int,
    *,
    population: int | None = None,
    sigma: float | None = None,
    restarts: str = "none",
) -> list[Search]:
    """Independent searches with seeds of their own.

    The first one is as `make_search` has it, with that seed. The others have step sizes between a tenth of the first
    one's and all of it, spread evenly in their logarithm, and start at points drawn around the start with their own
    step size as standard deviation. So some stay near a start that is good, and others go far from one that is bad.
    Search i is the same however many there are.

    Raises:
        Error: see `make_search`; or the count is not positive, or too large.
    """
    if count < 1:
        raise Error(f"the number of searches must be positive, not {count}")
    check_size("searches", count)
    check_size("population", count * (population or 1))
    spread = checked_sigma(sigma)
    searches = [make_search(name, dimensions, start, seed, population=population, sigma=sigma, restarts=restarts)]
    center = np.full(dimensions, 0.5) if start is None else checked_start(start)
    for child in np.random.SeedSequence(seed).spawn(count - 1):
        generator = np.random.default_rng(child)
        step = spread * SMALLEST_SPREAD ** generator.uniform()
        point: Floats = scattered(center, step, generator)
        own_seed = int(generator.integers(2**63))
        searches.append(
            make_search(name, dimensions, point, own_seed, population=population, sigma=step, restarts=restarts)
        )
    return searches


def _names() -> list[str]:
    """Names of all strategies."""
    from warpmuscle.search.nlopt import algorithms

    return ["islands", "random", "cma", "cma:ipop", "cma:bipop", *(f"nlopt:{algorithm}" for algorithm in algorithms())]


def _unknown(name: str) -> str:
    """What is wrong with a name, and the nearest ones."""
    if name.lower().rstrip(":") == "nlopt":
        return f"{name!r} needs an algorithm, such as nlopt:LN_BOBYQA"
    known = {known.lower(): known for known in _names()}
    nearest = difflib.get_close_matches(name.lower(), known, n=3, cutoff=0.5)
    if not nearest and name:
        nearest = difflib.get_close_matches(f"nlopt:{name}".lower(), known, n=3)
    nearest = nearest or ["random", "cma", "nlopt:ln_bobyqa"]
    return f"there is no search strategy {name!r}; the nearest are {', '.join(known[low] for low in nearest)}"
