"""The better fit: parameters and signals together, by forward simulation of several motions at once.

Stages: equations of motion (no simulation); parameters alone; signals alone, a few steps, every motion by itself; both
together on the motions that parameters are fitted to; and signals alone on all motions. So those that are held out
get their signals fitted to parameters that never saw them. Activation dynamics is inside the simulation all along.
Motions that this loses, and all of arms of many joints, have their signals fitted window by window.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.equation_error import Capacity, fit_equations
from warpmuscle.throw.follow import Follower, Replay
from warpmuscle.throw.least_squares import Outcome, Prior, Unknowns, fit
from warpmuscle.throw.metrics import Agreement
from warpmuscle.throw.signals import to_activation
from warpmuscle.throw.windows import FINE_STEP, by_windows

FIDELITY = 1e-3
LAST = "signals"  # the stage that ends a fit
LOOSER, TIGHTER = 0.1, (2.0, 5.0)  # times the price of leaving the extracted signals, if motions or signals miss a bar
SIGNAL_STEP = 1e-3  # of difference quotients: wide enough for simulations in single precision
PARAMETER_STEP = 1e-3
PLANAR = 3  # joints, beyond which signals are fitted by windows from the beginning
HORIZON = 1.0  # s, by which it grows
FINE = 0.2  # times the tolerance, of fits again
ENOUGH = 0.9  # of the motions that parameters are fitted to, which must meet all bars
DAMPED = 0.06  # of an interval: the size of a parameter's step in which damping is meant


@dataclass(frozen=True)
class Settings:
    """How motions are fitted.

    `fidelity` is the price of a signal's distance from the extracted one, knot by knot, against 1 - r2: the more, the
    closer to it, and the less accurate the motion. If it may `adapt`, motions that miss a bar are fitted again at other
    prices.
    """

    fidelity: float = FIDELITY
    adapt: bool = True
    smoothness: float = 1e-4  # price of second differences of a signal's distance from the extracted one
    prior: float = 0.025  # price of a parameter's distance from its start, in parts of its interval
    parameter_steps: int = 20
    early_steps: int = 8
    common_steps: int = 15
    signal_steps: int = 12
    tolerance: float = 5e-3  # relative gain of a step, below which it is enough
    common: bool = True  # whether parameters and signals are fitted together
    starts: int = 3
    seed: int = 0


@dataclass(frozen=True)
class Stage:
    """What a stage came to."""

    name: str
    agreement: Agreement
    seconds: float
    simulations: int


@dataclass
class Fitted:
    """Parameters and signals of a fit to n motions."""

    unknowns: Floats  # (P,) see `Arm.unknowns`
    individual: Floats  # (n, size) signals at their knots and start, see `Follower.size`
    replay: Replay
    stages: list[Stage] = field(default_factory=list)

    @property
    def complete(self) -> bool:
        """Whether all stages were completed."""
        return self.stages[-1].name == LAST

    @property
    def agreement(self) -> Agreement:
        return self.stages[-1].agreement


def fit_motions(
    follower: Follower,
    start: Floats,
    training: Sequence[int],
    settings: Settings | None = None,
    progress: Callable[[str], None] = lambda stage: None,
    keep: Callable[[Fitted], None] = lambda fitted: None,
) -> Fitted:
    """Fit parameters to the motions `training`, and signals to all.

    Args:
        start: (P,) parameters to start from, see `Arm.unknowns`.
        progress: called with each stage before it begins.
        keep: is given what every stage that simulates came to.
    """
    fitting = _Fitting(follower, start, np.asarray(training, dtype=np.intp), settings or Settings(), progress, keep)
    return fitting.run()


class _Fitting:
    """A fit and its stages."""

    def __init__(
        self,
        follower: Follower,
        start: Floats,
        training: NDArray[np.intp],
        settings: Settings,
        progress: Callable[[str], None] = lambda stage: None,
        keep: Callable[[Fitted], None] = lambda fitted: None,
    ) -> None:
        self._follower, self._settings, self._progress, self._keep = follower, settings, progress, keep
        self._unstable = len(follower.arm.driven) > PLANAR
        self._training, self._all = training, np.arange(len(follower.motions))
        self._start = start
        self._extracted = follower.extracted
        self._capacity = Capacity(follower.arm, follower.motions)
        self._individual, self._shared = self._extracted.copy(), start.copy()
        self._stages: list[Stage] = []
        self._begin = time.perf_counter()

    def run(self) -> Fitted:
        s = self._settings
        self._stage("start", 0)
        self._equations()
        outcome = self._fit(self._training, s.parameter_steps, individual=False, shared=True, damping=1.0)
        self._shared = outcome.shared
        self._stage("parameters", outcome.simulations)
        if self._unstable:
            simulations = self._by_windows(self._training)
            self._stage("signals of these", simulations)
            simulations = self._by_windows(self._missed())
        else:
            if s.common:
                simulations = self._signals(self._training, s.early_steps).simulations + self._both()
                self._stage("parameters and signals", simulations)
            simulations = self._signals(self._all, s.signal_steps).simulations + self._by_windows(self._missed())
        if s.common:
            simulations += self._fit_jointly_again()
        simulations += self._at_other_prices(2 * s.signal_steps)
        return self._stage(LAST, simulations)

    def _both(self, exact: bool = False) -> int:
        """Fit parameters and signals together to the motions that parameters are fitted to."""
        both = self._fit(
            self._training, self._settings.common_steps, individual=True, shared=True, damping=0.1, exact=exact
        )
        self._individual[self._training], self._shared = both.individual, both.shared
        return both.simulations

    def _fit_jointly_again(self) -> int:
        """Fit parameters and signals again where these parameters leave too many of their own motions behind.

        Kept if more motions meet all bars, or as many at a lower cost; returns how many simulations that took.
        """
        individual, shared, good = self._individual.copy(), self._shared, self._agreement().good()
        if np.mean(good[self._training]) >= ENOUGH:
            return 0
        before = (-good.sum(), self._costs(self._all).sum())
        simulations = self._both(exact=True)
        if not self._unstable:
            simulations += self._signals(self._all, self._settings.signal_steps).simulations
        simulations += self._by_windows(self._missed())
        if (-self._agreement().good().sum(), self._costs(self._all).sum()) >= before:
            self._individual, self._shared = individual, shared
        return simulations

    def _missed(self) -> NDArray[np.intp]:
        """Motions that miss a bar."""
        return np.flatnonzero(~self._agreement().good())

    def _agreement(self) -> Agreement:
        return self._follower.agreement(self._individual, self._shared)[0]

    def _at_other_prices(self, steps: int) -> int:
        """Fit signals of motions that miss a bar at another price of leaving the extracted ones.

        Returns how many simulations that took.
        """
        simulations = 0
        for price in (LOOSER, *TIGHTER) if self._settings.adapt else ():
            a = self._agreement()
            followed = a.with_signals_kept().good()
            missed = np.flatnonzero(~followed if price < 1.0 else followed & ~a.good())
            if len(missed):
                with self._kept_if_better(missed):
                    simulations += self._signals(missed, steps, price, exact=True).simulations
        return simulations

    @contextmanager
    def _kept_if_better(self, which: NDArray[np.intp]) -> Iterator[None]:
        """Keep what becomes of some motions' signals where more bars are met, or as many at a lower cost."""
        individual, before, met = self._individual.copy(), self._costs(which), self._agreement().met()[which]
        yield
        now = self._agreement().met()[which]
        worse = which[(now < met) | ((now == met) & (self._costs(which) >= before))]
        self._individual[worse] = individual[worse]

    def _by_windows(self, which: NDArray[np.intp]) -> int:
        """Fit signals of some motions window by window, see `windows`; returns how many simulations that took."""
        if not len(which):
            return 0
        with self._kept_if_better(which):
            self._individual[which], simulations = by_windows(self._follower, which, self._shared, self._distance())
        return simulations

    def _costs(self, which: NDArray[np.intp]) -> Floats:
        """Sums of squared residuals of some motions."""
        shared = np.tile(self._shared, (len(which), 1))
        return np.asarray(np.sum(self._follower.residuals(which, self._individual[which], shared) ** 2, axis=1))

    def _signals(self, which: NDArray[np.intp], steps: int, price: float = 1.0, exact: bool = False) -> Outcome:
        """Fit signals of some motions over a horizon that grows: what is late in a long motion hangs on all before."""
        end, simulations = self._follower.horizon, 0
        for horizon in [*np.arange(HORIZON, end - 0.5 * HORIZON, HORIZON).tolist(), end]:
            self._follower.horizon = horizon
            outcome = self._fit(which, steps, individual=True, shared=False, price=price, exact=exact)
            self._individual[which] = outcome.individual
            simulations += outcome.simulations
        return Outcome(outcome.individual, outcome.shared, outcome.cost, outcome.history, simulations)

    def again(self, individual: Floats, shared: Floats) -> tuple[Floats, Floats]:
        """Signals (n, size) and parameters (P,) fitted from others on."""
        self._individual, self._shared, self._start = individual.copy(), shared, shared
        self._both()
        return self._signals(self._all, self._settings.signal_steps).individual, self._shared

    def _equations(self) -> None:
        """Parameters by the equations of motion; what is regularised towards from now on."""
        follower, s = self._follower, self._settings
        self._progress("equations")
        synergies = follower.synergies
        excitation, start = synergies.excitation(synergies.signals), synergies.excitation(synergies.start)
        activation = to_activation(follower.arm, excitation, start)
        motions = follower.motions.rows(self._training.tolist())
        found = fit_equations(
            follower.arm, motions, activation[self._training], self._start, starts=s.starts, seed=s.seed
        )
        self._shared = self._start = found.unknowns
        self._stage("equations", 0)

    def _fit(
        self,
        which: NDArray[np.intp],
        steps: int,
        *,
        individual: bool,
        shared: bool,
        damping: float = 1e-2,
        price: float = 1.0,
        exact: bool = False,
    ) -> Outcome:
        """A stage of Levenberg-Marquardt on some motions, with their signals or the shared parameters or both free.

        Args:
            price: factor of that of leaving the extracted signals.
            exact: whether derivatives are of steps as long as the scene's from the beginning, to a finer end, even
                where angles are followed well, as the hand may still be off.
        """
        follower, s = self._follower, self._settings
        self._progress(
            {(False, True): "parameters", (True, True): "parameters and signals"}.get((individual, shared), "signals")
        )
        size = follower.size
        signals = Unknowns(
            self._individual[which], np.zeros(size), np.ones(size), FINE_STEP if exact else SIGNAL_STEP, None,
            [Prior(self._distance(price), self._extracted[which])], individual,
        )  # fmt: skip
        count = len(self._shared)
        prior = Prior(s.prior * np.eye(count), self._start)
        parameters = Unknowns(
            self._shared, np.zeros(count), np.ones(count), PARAMETER_STEP, np.full(count, DAMPED), [prior], shared
        )

        def residuals(rows: NDArray[np.intp], x: Floats, z: Floats, roughly: bool = False) -> Floats:
            followed = follower.residuals(which[rows], x, z, roughly)
            if not shared:
                return followed
            return np.concatenate([followed, self._capacity.residuals(which[rows], z)], axis=1)

        def rough(rows: NDArray[np.intp], x: Floats, z: Floats) -> Floats:
            return residuals(rows, x, z, roughly=True)

        return fit(
            residuals, signals, parameters, iterations=steps, damping=damping,
            tolerance=FINE * s.tolerance if exact else s.tolerance, rough=None if exact else rough,
            enough=None if shared or exact or price > 1.0 else follower.followed,
        )  # fmt: skip

    def _distance(self, price: float = 1.0) -> Floats:
        """Price (size, size) of signals' squared distance from the extracted ones, and of second differences of it."""
        second = np.diff(np.eye(len(self._follower.knots)), 2, axis=0)
        block = self._settings.smoothness * second.T @ second
        at_knots = np.kron(np.eye(self._follower.synergies.count), block)
        smooth = np.pad(at_knots, (0, self._follower.size - len(at_knots)))
        return np.asarray(price * self._settings.fidelity * np.eye(self._follower.size) + smooth, dtype=np.float64)

    def _stage(self, name: str, simulations: int) -> Fitted:
        """What a stage came to, with those before it."""
        agreement, replay = self._follower.agreement(self._individual, self._shared)
        self._stages.append(Stage(name, agreement, time.perf_counter() - self._begin, simulations))
        fitted = Fitted(self._shared.copy(), self._individual.copy(), replay, self._stages.copy())
        if simulations:
            self._keep(fitted)
        return fitted


def trade(
    follower: Follower,
    fitted: Fitted,
    training: NDArray[np.intp],
    prices: Sequence[float],
    settings: Settings | None = None,
) -> list[tuple[float, Agreement]]:
    """Accuracy against fidelity: parameters and signals fitted again at other prices of leaving the extracted ones."""
    settings = settings or Settings()
    curve = []
    individual, shared = fitted.individual, fitted.unknowns
    for price in prices:
        fitting = _Fitting(follower, fitted.unknowns, training, replace(settings, fidelity=price))
        individual, shared = fitting.again(individual, shared)
        curve.append((price, follower.agreement(individual, shared)[0]))
    return curve
