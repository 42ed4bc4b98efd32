"""Quadratic programmes of a body on its feet, of random numbers of a person's size, and answers to them in float64."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

ROOT, LEG, ARM = 6, 5, 3  # coordinates: the root's, those of each leg, and of a chain that touches nothing
EDGES = 4  # of a friction cone


@dataclass(frozen=True)
class Problems:
    """P programmes of n coordinates and m controls; see `warpmuscle.quadratic_program`."""

    mass: np.ndarray
    bias: np.ndarray
    forces: np.ndarray
    wanted: np.ndarray
    weight: np.ndarray
    cost: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __getitem__(self, rows) -> Problems:
        return Problems(*(getattr(self, f.name)[rows] if getattr(self, f.name).ndim > 1 else getattr(self, f.name)
                          for f in fields(self)))  # fmt: skip

    def arguments(self) -> dict[str, np.ndarray]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


def standing(count: int, muscles: int = 92, torques: int = 13, points: int = 8, seed: int = 0) -> Problems:
    """Programmes of bodies that stand on so many points: activations, torques and edges of friction cones."""
    random = np.random.default_rng(seed)
    n = ROOT + 2 * LEG + ARM
    chain = [[ROOT + side * LEG + k for k in range(LEG)] for side in range(2)] + [[n - ARM + k for k in range(ARM)]]
    size = np.r_[[9.0] * 3, [3.0] * 3, np.tile([1.7, 1.0, 0.7, 0.15, 0.05], 2), [1.0, 0.5, 0.2]]
    links = random.normal(size=(count, n, 2 * n)) * size[:, None]
    mass = links @ links.transpose(0, 2, 1) / (2 * n)
    forces = np.zeros((count, n, muscles + torques + EDGES * points))
    for j in range(muscles):
        limb = chain[random.integers(3)]
        rows = random.choice(limb, random.integers(1, 4), replace=False)
        forces[:, rows, j] = random.normal(size=(count, len(rows))) * random.uniform(10.0, 100.0)
    for j in range(torques):
        forces[:, ROOT + j % (n - ROOT), muscles + j] = 1.0
    for k in range(points):
        leg = chain[k % 2]
        for e in range(EDGES):
            turn = 2.0 * np.pi * e / EDGES
            edge = np.array([0.6 * np.cos(turn), 1.0, 0.6 * np.sin(turn)])
            at = np.array([0.1 - 0.2 * (k % 2), -0.9, 0.1 * (k // 2)]) + 0.02 * random.normal(size=(count, 3))
            column = muscles + torques + EDGES * k + e
            forces[:, :3, column], forces[:, 3:6, column] = edge, np.cross(at, edge)
            forces[:, leg, column] = random.normal(size=(count, LEG)) * [0.5, 0.4, 0.3, 0.1, 0.05]
    feet = forces[:, :, muscles + torques :]
    weight = np.eye(n) + 100.0 * feet @ feet.transpose(0, 2, 1)
    bias = np.zeros((count, n))
    bias[:, 1], bias[:, ROOT:] = 735.0, random.normal(size=(count, n - ROOT)) * 5.0
    wanted = random.normal(size=(count, n)) * np.r_[np.ones(ROOT), np.full(n - ROOT, 5.0)]
    parts = (muscles, torques, EDGES * points)
    cost, low, high = (
        np.concatenate([np.full(part, value) for part, value in zip(parts, values, strict=True)])
        for values in ((0.5, 0.01, 1e-6), (0.0, -5.0, 0.0), (1.0, 5.0, np.inf))
    )
    return rounded(Problems(mass, bias, forces, wanted, weight, cost, low, high))


def rounded(problems: Problems) -> Problems:
    """The same in single precision, as a device has them, with symmetric matrices."""
    found = {f.name: getattr(problems, f.name).astype(np.float32).astype(float) for f in fields(problems)}
    for name in ("mass", "weight"):
        found[name] = np.tril(found[name]) + np.tril(found[name], -1).transpose(0, 2, 1)
    return Problems(**found)


def by_scipy(problems: Problems, p: int) -> np.ndarray:
    """Controls (m,) of a programme by bounded least squares of the accelerations' error and the effort."""
    from scipy.optimize import lsq_linear

    root = np.linalg.cholesky(problems.weight[p]).T
    inverse = np.linalg.inv(problems.mass[p])
    scale = np.sqrt(problems.cost)
    matrix = np.concatenate([root @ inverse @ problems.forces[p] / scale, np.eye(len(scale))])
    aim = np.concatenate([root @ (problems.wanted[p] + inverse @ problems.bias[p]), np.zeros(len(scale))])
    bounds = problems.low * scale, problems.high * scale
    found = lsq_linear(matrix, aim, bounds, method="bvls", tol=1e-15, max_iter=3000)
    return np.asarray(found.x / scale)


def objective(problems: Problems, p: int, control: np.ndarray) -> float:
    """What a programme minimises, where controls (m,) move the body."""
    acceleration = np.linalg.solve(problems.mass[p], problems.forces[p] @ control - problems.bias[p])
    error = problems.wanted[p] - acceleration
    return float(0.5 * error @ problems.weight[p] @ error + 0.5 * np.sum(problems.cost * control**2))


def optimum(problems: Problems, p: int, control: np.ndarray) -> np.ndarray:
    """The controls (m,) that are optimal, in float64: from those at bounds, of which wrong ones are changed.

    Raises AssertionError where that does not end. The programme has one optimum: where free controls are within their
    bounds, and no other would be better away from its bound.
    """
    scale, inverse = np.sqrt(problems.cost), np.linalg.inv(problems.mass[p])
    root = np.linalg.cholesky(problems.weight[p]).T
    matrix = np.concatenate([root @ inverse @ problems.forces[p] / scale, np.eye(len(scale))])
    aim = np.concatenate([root @ (problems.wanted[p] + inverse @ problems.bias[p]), np.zeros(len(scale))])
    low, high = control <= problems.low, control >= problems.high
    tiny = 1e-9 * np.linalg.norm(matrix, axis=0).max() * np.linalg.norm(aim)
    for _ in range(50):
        free, found = ~(low | high), np.where(low, problems.low, problems.high) * scale
        fixed = matrix[:, ~free] @ found[~free]
        found[free] = np.linalg.lstsq(matrix[:, free], aim - fixed, rcond=None)[0]
        slope, found = matrix.T @ (matrix @ found - aim), found / scale
        wrong = (low & (slope < -tiny)) | (high & (slope > tiny))
        under, over = free & (found < problems.low), free & (found > problems.high)
        if not (wrong | under | over).any():
            return np.asarray(found)
        low, high = (low & ~wrong) | under, (high & ~wrong) | over
    raise AssertionError("no optimum was found")
