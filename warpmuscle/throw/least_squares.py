"""Levenberg-Marquardt for many fits at once that may share parameters, within boxes, derivatives from batches.

Every one of n fits has its own unknowns (n, U); all of them share S more. One batch of simulations holds all perturbed
copies of all fits. The normal equations are an arrow: the fits' own blocks, bordered by what is shared, which is
solved first by Schur complement (Nocedal and Wright 2006, ch. 10).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats

# Residuals (B, R) of copies: which fit each one belongs to (B,), its own unknowns (B, U), what is shared (B, S).
Residuals = Callable[[NDArray[np.intp], Floats, Floats], Floats]
LEAST_DAMPING, MOST_DAMPING = 1e-9, 1e6
ATTEMPTS = 5  # at a step, with ever more damping
ROUGH_ENOUGH = 1e-3  # relative gain of a step, below which rough derivatives are no longer of use
BOUND = 1e-9  # an unknown nearer than that to its bound is at it


@dataclass(frozen=True)
class Prior:
    """(x - reference)^T matrix (x - reference), added to the sum of squares."""

    matrix: Floats  # (U, U)
    reference: Floats  # (n, U) or (U,)

    def cost(self, x: Floats) -> Floats:
        d = x - self.reference
        return np.asarray(np.einsum("ia,ab,ib->i", d, self.matrix, d))

    def slope(self, x: Floats) -> Floats:
        """Half of the gradient."""
        return np.asarray((x - self.reference) @ self.matrix)


@dataclass
class Unknowns:
    """Some unknowns of a fit: where they start, their box, and what is known of them beforehand."""

    start: Floats  # (n, U), or (S,) for shared ones
    low: Floats  # (U,)
    high: Floats  # (U,)
    step: float  # of the difference quotients
    scale: Floats | None = None  # (U,) sizes in which damping is meant; 1 if None
    priors: Sequence[Prior] = ()
    free: bool = True


@dataclass
class Outcome:
    """What a fit came to."""

    individual: Floats  # (n, U)
    shared: Floats  # (S,)
    cost: Floats  # (n,) sum of squares, without the shared priors
    history: list[Floats] = field(default_factory=list)  # cost (n,) after each iteration
    simulations: int = 0


def fit(
    residuals: Residuals,
    individual: Unknowns,
    shared: Unknowns,
    *,
    iterations: int = 20,
    damping: float = 1e-2,
    tolerance: float = 1e-4,
    enough: Callable[[Floats], NDArray[np.bool_]] | None = None,
    rough: Residuals | None = None,
) -> Outcome:
    """Minimise the sum of squared residuals and priors over all fits.

    Args:
        residuals: of any copies; must be finite.
        damping: at the start. Fits that share nothing that is free have one damping each, so that one that diverges
            does not hold up the others; else there is one for all.
        tolerance: two steps in a row with less relative gain end it.
        enough: tells by the residuals (n, R) which fits are good enough to leave the batch; only of fits that share
            nothing that is free.
        rough: residuals for the derivatives alone, if others are cheaper and nearly as good for that.
    """
    solver = _Solver(residuals, rough, individual, shared, damping)
    stalled = 0
    for _ in range(iterations):
        if enough is not None and not shared.free:
            solver.active &= ~enough(solver.residual)
        if not solver.active.any():
            break
        gain = solver.step()
        solver.outcome.history.append(solver.cost.copy())
        if gain < ROUGH_ENOUGH and solver.refine():
            continue
        stalled = stalled + 1 if gain < tolerance else 0
        if stalled >= 2:
            break
    solver.outcome.individual, solver.outcome.shared, solver.outcome.cost = (
        solver.individual,
        solver.shared,
        solver.cost,
    )
    return solver.outcome


class _Solver:
    """The state of a fit between steps."""

    def __init__(
        self, residuals: Residuals, rough: Residuals | None, individual: Unknowns, shared: Unknowns, damping: float
    ) -> None:
        self._residuals, self._rough, self._individual, self._shared = residuals, rough, individual, shared
        self.individual, self.shared = individual.start.copy(), shared.start.copy()
        self._damping = np.full(len(self.individual), damping)
        self._first_damping = damping
        self.active = np.ones(len(self.individual), dtype=bool)
        self.outcome = Outcome(self.individual, self.shared, np.zeros(len(self.individual)))
        self.residual = self._evaluate(
            np.arange(len(self.individual)), self.individual, np.tile(self.shared, (len(self.individual), 1))
        )
        self.cost = self._cost(np.arange(len(self.individual)), self.individual, self.residual)
        self._shared_cost = self._cost_of_shared(self.shared)

    def _evaluate(self, which: NDArray[np.intp], individual: Floats, shared: Floats) -> Floats:
        self.outcome.simulations += len(which)
        return self._residuals(which, individual, shared)

    def _cost(self, which: NDArray[np.intp], individual: Floats, residual: Floats) -> Floats:
        cost = np.sum(residual**2, axis=1)
        for prior in self._individual.priors:
            cost = cost + Prior(prior.matrix, _rows(prior.reference, which)).cost(individual)
        return np.asarray(cost)

    def _cost_of_shared(self, shared: Floats) -> float:
        return float(sum(prior.cost(shared[None])[0] for prior in self._shared.priors))

    def refine(self) -> bool:
        """Take exact derivatives from now on, with the damping of the start; False if they have been all along."""
        if self._rough is None:
            return False
        self._rough = None
        self._damping[:] = self._first_damping
        return True

    def step(self) -> float:
        """Take a step, or none if no damping makes one that helps; returns the relative gain."""
        which = np.flatnonzero(self.active)
        jacobian = self._jacobian(which)
        before = self.cost[which].sum() + self._shared_cost
        step = self._joint_step if self._shared.free else self._step_alone
        step(which, jacobian)
        after = self.cost[which].sum() + self._shared_cost
        return float((before - after) / max(before, 1e-300))

    def _jacobian(self, which: NDArray[np.intp]) -> Floats:
        """Of the residuals of some fits by all free unknowns, (m, R, U + S), by one batch of copies."""
        parts = []
        count = (self.individual.shape[1] if self._individual.free else 0) + (
            len(self.shared) if self._shared.free else 0
        )
        individual = np.repeat(self.individual[which][:, None], count, axis=1)
        shared = np.broadcast_to(self.shared, (len(which), count, len(self.shared))).copy()
        first = 0
        if self._individual.free:
            index = np.arange(self.individual.shape[1])
            middle = 0.5 * (self._individual.low + self._individual.high)
            parts.append(np.where(self.individual[which] > middle, -1.0, 1.0) * self._individual.step)
            individual[:, index, index] += parts[0]
            first = len(index)
        if self._shared.free:
            index = np.arange(len(self.shared))
            towards = np.where(self.shared > 0.5 * (self._shared.low + self._shared.high), -1.0, 1.0)
            parts.append(np.tile(towards * self._shared.step, (len(which), 1)))
            shared[:, first + index, index] += parts[-1]
        offsets = np.concatenate(parts, axis=1)
        copies = np.repeat(which, count)
        individual, shared = individual.reshape(len(copies), -1), shared.reshape(len(copies), -1)
        base = self.residual[which]
        if self._rough is None:
            moved = self._residuals(copies, individual, shared)
        else:  # the unmoved ones go with them, to be differenced alike
            copies = np.concatenate([copies, which])
            individual = np.concatenate([individual, self.individual[which]])
            shared = np.concatenate([shared, np.tile(self.shared, (len(which), 1))])
            moved = self._rough(copies, individual, shared)
            moved, base = moved[: -len(which)], moved[-len(which) :]
        self.outcome.simulations += len(copies)
        moved = moved.reshape(len(which), count, -1)
        return np.asarray(((moved - base[:, None]) / offsets[:, :, None]).transpose(0, 2, 1))

    def _blocks(self, which: NDArray[np.intp], jacobian: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Of the fits' own unknowns: matrices (m, U, U), half gradients (m, U), and which may move (m, U)."""
        x = self.individual[which]
        matrix = jacobian.transpose(0, 2, 1) @ jacobian
        slope = np.einsum("irk,ir->ik", jacobian, self.residual[which])
        for prior in self._individual.priors:
            matrix = matrix + prior.matrix
            slope = slope + Prior(prior.matrix, _rows(prior.reference, which)).slope(x)
        return matrix, slope, _movable(x, slope, self._individual)

    def _step_alone(self, which: NDArray[np.intp], jacobian: Floats) -> None:
        """A step of every fit by itself."""
        matrix, slope, movable = self._blocks(which, jacobian)
        waiting = np.arange(len(which))
        for _ in range(ATTEMPTS):
            fits = which[waiting]
            move = _boxed_step(
                matrix[waiting],
                slope[waiting],
                movable[waiting],
                self._damping[fits],
                self.individual[fits],
                self._individual,
            )
            individual = np.clip(self.individual[fits] + move, self._individual.low, self._individual.high)
            residual = self._evaluate(fits, individual, np.tile(self.shared, (len(fits), 1)))
            cost = self._cost(fits, individual, residual)
            good = cost < self.cost[fits]
            better = fits[good]
            self.individual[better], self.residual[better], self.cost[better] = (
                individual[good],
                residual[good],
                cost[good],
            )
            self._damping[better] = np.maximum(self._damping[better] / 4.0, LEAST_DAMPING)
            waiting = waiting[~good]
            self._damping[which[waiting]] = np.minimum(self._damping[which[waiting]] * 5.0, MOST_DAMPING)
            if len(waiting) <= 0.2 * len(which):
                return

    def _joint_step(self, which: NDArray[np.intp], jacobian: Floats) -> None:
        """A step of all fits and what they share."""
        count = self.individual.shape[1] if self._individual.free else 0
        border = jacobian[:, :, count:]
        corner = np.einsum("irk,irl->kl", border, border)
        slope = np.einsum("irk,ir->k", border, self.residual[which])
        for prior in self._shared.priors:
            corner, slope = corner + prior.matrix, slope + prior.slope(self.shared[None])[0]
        movable = _movable(self.shared, slope, self._shared)
        scale = np.ones(len(self.shared)) if self._shared.scale is None else self._shared.scale
        blocks = self._blocks(which, jacobian[:, :, :count]) if count else None
        for _ in range(ATTEMPTS):
            damping = float(self._damping.max())
            reduced, right = corner + damping * np.diag(1.0 / scale**2), -slope
            individual_part = individual_border = None
            if blocks is not None:
                matrix, own_slope, free = blocks
                coupling = np.where(free[:, :, None], jacobian[:, :, :count].transpose(0, 2, 1) @ border, 0.0)
                sides = np.concatenate([coupling, -np.where(free, own_slope, 0.0)[:, :, None]], axis=2)
                solved = np.linalg.solve(_masked(matrix, free, np.full(len(which), damping), self._individual), sides)
                individual_border, individual_part = solved[:, :, :-1], solved[:, :, -1]
                reduced = reduced - np.einsum("iuk,iul->kl", coupling, individual_border)
                right = right - np.einsum("iuk,iu->k", coupling, individual_part)
            move = np.zeros(len(self.shared))
            move[movable] = np.linalg.solve(reduced[np.ix_(movable, movable)], right[movable])
            shared = np.clip(self.shared + move, self._shared.low, self._shared.high)
            individual = self.individual[which]
            if individual_part is not None and individual_border is not None:
                individual = np.clip(
                    individual + individual_part - individual_border @ (shared - self.shared),
                    self._individual.low,
                    self._individual.high,
                )
            residual = self._evaluate(which, individual, np.tile(shared, (len(which), 1)))
            cost, shared_cost = self._cost(which, individual, residual), self._cost_of_shared(shared)
            if cost.sum() + shared_cost < self.cost[which].sum() + self._shared_cost:
                self.shared, self.individual[which], self.residual[which] = shared, individual, residual
                self.cost[which], self._shared_cost = cost, shared_cost
                self._damping = np.maximum(self._damping / 4.0, LEAST_DAMPING)
                return
            self._damping = np.minimum(self._damping * 5.0, MOST_DAMPING)


def _rows(reference: Floats, which: NDArray[np.intp]) -> Floats:
    return reference if reference.ndim == 1 else reference[which]


def _movable(x: Floats, slope: Floats, unknowns: Unknowns) -> NDArray[np.bool_]:
    """Which unknowns are not held at a bound by their gradient."""
    at_low = (x <= unknowns.low + BOUND) & (slope > 0.0)
    at_high = (x >= unknowns.high - BOUND) & (slope < 0.0)
    return np.asarray(~(at_low | at_high))


def _masked(matrix: Floats, free: NDArray[np.bool_], damping: Floats, unknowns: Unknowns) -> Floats:
    """Damped matrices in which those that are not free stand still."""
    size = matrix.shape[1]
    scale = np.ones(size) if unknowns.scale is None else unknowns.scale
    both = free[:, :, None] & free[:, None, :]
    diagonal = np.where(free, damping[:, None] / scale**2, 1.0)
    return np.where(both, matrix, 0.0) + diagonal[:, :, None] * np.eye(size)


def _boxed_step(
    matrix: Floats, slope: Floats, free: NDArray[np.bool_], damping: Floats, x: Floats, unknowns: Unknowns
) -> Floats:
    """Steps (m, U) to the minima of the quadratic models within the box, by a few rounds of an active set."""
    move = np.zeros_like(x)
    fixed = np.zeros_like(x)  # moves of those that have come to a bound
    free = free.copy()
    for _ in range(4):
        right = -slope - np.einsum("iab,ib->ia", matrix, fixed)
        masked = _masked(matrix, free, damping, unknowns)
        move = np.linalg.solve(masked, np.where(free, right, 0.0)[:, :, None])[:, :, 0] + fixed
        low, high = unknowns.low - x, unknowns.high - x
        outside = free & ((move < low) | (move > high))
        if not outside.any():
            break
        fixed = np.where(outside, np.clip(move, low, high), fixed)
        free &= ~outside
    return move
