"""Functions to search, with their optimum within the unit cube."""

import numpy as np


def natural(x):
    """Points (n, P) of the cube, scaled to [-5, 5]."""
    return 10.0 * np.asarray(x) - 5.0


def sphere(x):
    return np.sum((natural(x) - 1.0) ** 2, axis=-1)


def rosenbrock(x):
    y = natural(x)
    return np.sum(100.0 * (y[:, 1:] - y[:, :-1] ** 2) ** 2 + (1.0 - y[:, :-1]) ** 2, axis=-1)


def rastrigin(x):
    y = natural(x) - 1.0
    return np.sum(y**2 + 10.0 * (1.0 - np.cos(2.0 * np.pi * y)), axis=-1)


FUNCTIONS = (sphere, rosenbrock, rastrigin)


def start_of(dimensions):
    """Somewhere to the side of the optimum."""
    return np.random.default_rng(7).uniform(0.25, 0.5, size=dimensions)


def run(search, function, evaluations):
    """Search until it has finished or so many evaluations were made; what it asked, its batches one by one."""
    batches = []
    while not search.finished() and sum(map(len, batches)) < evaluations:
        batches.append(search.ask())
        search.tell(function(batches[-1]))
    return batches
