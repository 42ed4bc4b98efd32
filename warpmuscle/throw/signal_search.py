"""Searches for signals of synergies that throw a ball as a goal says.

A raised arm is unstable, and many strong muscles throw it into its stops by changes of a signal that are small
elsewhere. So the first generation does not change all signals alike, but moves the arm alike: by the derivatives of
the angles by the signals (a batch of simulations), changes in directions that move it a lot are small.

The cost is the misses in their units, with how far joints pass their limits up to the release and behind it, the effort
(mean square of the excitations), then how far the signals are from the known throw's; the hand must be above the
shoulder when it lets go, and turning forwards.

No one way to begin suits all arms and goals: `WAYS` are tried until a throw meets its goal. What changes all signals
alike gets farther with few muscles; and where a ball goes as it should out of joints beyond their limits, these count
more from then on than what joints do behind the release.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.search.cma import CmaSearch
from warpmuscle.search.directions import directions
from warpmuscle.throw.follow import Follower, Replay
from warpmuscle.throw.goals import LIMIT_UNIT, PAST_LIMITS, Flight, Goal, misfit, tamed

CLEARANCE = 0.05  # m, by which the hand is to be above the shoulder
EFFORT, CHANGE = 2.0, 1.0  # prices of mean square excitation and of mean square change, against a squared unit
POPULATION = 48
GENERATIONS = 200
DEVIATION = 0.03  # of a signal's change in the first generation, in parts of its range, at most
MOVED = np.radians(6.0)  # by which changes of that generation together move the joints, root mean square
STEP = 5e-3  # of a signal's change, in the difference quotients of the angles
RANGE = 33.0  # times its deviation in the first generation, by which a change may grow
FAR = 10.0  # rad, of a joint whose simulation came to nothing
FORBIDDEN = 1e6  # cost of a release below the shoulder or backwards
GOOD = 0.8  # of the squared units, with which nothing is missed by more than is allowed
CLOSE = 0.05  # of the squared units: a goal that is met so well is met, and nothing is left but effort
PATIENCE, LONG = 15, 50  # generations in which the cost must fall, once the goal is met and before
GAIN = 0.02  # by which part
APART = 0.15  # root mean square difference of signals, by which solutions are to differ


class Throws(Protocol):
    """What a search needs of a `synthesis.Thrower`, whose methods these are."""

    follower: Follower
    individual: Floats
    frames: Integers
    hats: Floats

    def tail(self, frame: int) -> Floats: ...
    def simulated(self, signals: Floats) -> Replay: ...
    def flights(self, replay: Replay, frames: Integers, height: float) -> tuple[Flight, Floats]: ...
    def past(self, replay: Replay, frame: int) -> tuple[dict[str, float], dict[str, float]]: ...
    def past_limits(self, replay: Replay) -> Floats: ...
    def effort(self, signals: Floats) -> Floats: ...


@dataclass(frozen=True)
class Way:
    """How a run of CMA-ES begins."""

    alike: str  # what its first generation changes alike: the "angles", or the "signals"
    deviation: float  # of a signal's change in that generation, in parts of its range, at most
    population: int
    weight: float = 1.0  # of how far joints pass their limits up to the release
    anew: bool = False  # whether from the known throw, rather than from the best so far
    nearly: bool = False  # whether only where nothing but limits is missed
    draw: int = 0  # which random numbers it takes, unlike those of other runs


WAYS = (
    Way("angles", DEVIATION, POPULATION),
    Way("angles", DEVIATION, POPULATION, weight=16.0, nearly=True, draw=1),
    Way("angles", DEVIATION, POPULATION, weight=16.0, nearly=True, draw=5),  # the first may end while it still gains
    Way("signals", DEVIATION, POPULATION, anew=True, draw=2),
    Way("signals", 0.02, 2 * POPULATION, draw=3),
    Way("angles", DEVIATION, POPULATION, weight=16.0, nearly=True, draw=4),
)


@dataclass(frozen=True)
class Best:
    """The best throw so far."""

    signals: Floats  # (size,)
    frame: int  # of release
    cost: float = np.inf
    miss: float = np.inf  # in squared units, of the ball and of the limits up to the release
    ball: float = np.inf  # of the ball alone


class SignalSearch:
    """A search for signals of some synergies."""

    def __init__(self, thrower: Throws, goal: Goal, synergies: tuple[int, ...], others: Sequence[Floats]) -> None:
        self._thrower, self._goal, self._synergies, self._others = thrower, goal, synergies, others
        self._hats, self._frames, self._known = thrower.hats, thrower.frames, thrower.individual
        self._weight = 1.0  # of limits, up to the release
        self.simulations = 0

    def run(self, seed: int) -> tuple[tuple[Floats, int], int]:
        """Signals (size,) and the frame of release of the best throw, and how many were simulated."""
        best = Best(self._thrower.individual, int(self._thrower.frames[0]))
        for way in WAYS:
            if way.nearly and not best.ball <= GOOD < best.miss:
                continue
            self._weight = way.weight
            self._known = self._thrower.individual if way.anew else best.signals
            found = self._descend(seed + 1000 * way.draw, way, Best(self._known, best.frame))
            best = min(self._judged(found), self._judged(best), key=lambda one: (one.miss > GOOD, one.cost))
            if best.miss <= GOOD:
                break
        _, after = self._thrower.past(self._thrower.simulated(best.signals[None]), best.frame)
        if max(after.values(), default=0.0) > PAST_LIMITS:
            best = self._follow_through(seed, best)
        return (best.signals, best.frame), self.simulations

    def _judged(self, one: Best) -> Best:
        """The same, with a cost in which limits have the weight that they have now."""
        if not np.isfinite(one.cost):
            return one
        cost, miss, ball, frame = self.cost(one.signals[None])
        return Best(one.signals, int(frame[0]), float(cost[0]), float(miss[0]), float(ball[0]))

    def _follow_through(self, seed: int, best: Best) -> Best:
        """The same throw, and another way to come to rest behind its release, within the joints' limits."""
        hats, frame = self._thrower.tail(best.frame), best.frame
        if not hats.shape[1] or best.miss >= FORBIDDEN:
            return best
        self._hats, self._frames, self._known = hats, np.array([frame]), best.signals
        return self._descend(seed, WAYS[0], self._judged(best))

    def _descend(self, seed: int, way: Way, best: Best) -> Best:
        """The best of a run of CMA-ES from `known` on, and of what is given."""
        size = self._hats.shape[1] * len(self._synergies)
        likely: Floats = way.deviation * np.eye(size)
        if way.alike == "angles":
            likely = directions(self._slopes(), way.deviation, MOVED)
        search = CmaSearch(np.full(size, 0.5), seed, population=way.population, sigma=0.5 / RANGE)
        history: list[float] = []
        for _ in range(GENERATIONS):
            signals = self._signals(RANGE * (2.0 * search.ask() - 1.0) @ likely)
            cost, miss, ball, frame = self.cost(signals)
            search.tell(cost)
            k = int(cost.argmin())
            if cost[k] < best.cost:
                best = Best(signals[k], int(frame[k]), float(cost[k]), float(miss[k]), float(ball[k]))
            history.append(best.cost)
            patience = PATIENCE if best.miss <= CLOSE else LONG
            settled = len(history) > patience and history[-1] > (1.0 - GAIN) * history[-1 - patience]
            if settled or search.finished():
                break
        return best

    def _slopes(self) -> Floats:
        """Derivatives (U, R) of the angles of all frames by changes, so scaled that R sums up to a mean square."""
        thrower, size = self._thrower, self._hats.shape[1] * len(self._synergies)
        steps = STEP * np.eye(size)
        angle = thrower.simulated(self._signals(np.concatenate([np.zeros((1, size)), steps, -steps]))).angle
        self.simulations += 2 * size + 1
        free = np.nan_to_num(angle[:, :, thrower.follower.arm.free]).reshape(2 * size + 1, -1)
        up, down = free[1 : size + 1] - free[0], free[0] - free[size + 1 :]
        farther = np.linalg.norm(up, axis=1) > np.linalg.norm(down, axis=1)  # a signal of 0 or 1 has one side alone
        return np.asarray(np.where(farther[:, None], up, down) / (STEP * np.sqrt(free.shape[1])))

    def _signals(self, changes: Floats) -> Floats:
        """Signals (B, size) of changes (B, synergies * coarse knots) of the known ones."""
        knots = len(self._thrower.follower.knots)
        change = changes.reshape(len(changes), len(self._synergies), -1) @ self._hats.T
        signals = np.tile(self._known, (len(changes), 1))
        for row, number in enumerate(self._synergies):
            part = slice(number * knots, (number + 1) * knots)
            signals[:, part] = np.clip(signals[:, part] + change[:, row], 0.0, 1.0)
        return signals

    def cost(self, signals: Floats) -> tuple[Floats, Floats, Floats, Integers]:
        """Costs (B,), misses (B,) in squared units, those of the ball alone, and frames of release (B,).

        Args:
            signals: (B, size).
        """
        thrower = self._thrower
        self.simulations += len(signals)
        replay = thrower.simulated(signals)
        flight, clearance = thrower.flights(replay, self._frames, self._goal.height)
        missed = misfit(flight, self._goal)
        below = np.maximum(CLEARANCE - clearance, 0.0) + np.maximum(-flight.velocity[..., 0], 0.0)
        missed = np.where(below > 0.0, FORBIDDEN * (1.0 + below), missed)
        missed = np.nan_to_num(missed, nan=10.0 * FORBIDDEN)
        choice = missed.argmin(axis=1)
        rows = np.arange(len(signals))
        past = np.nan_to_num(thrower.past_limits(replay)[:, :, thrower.follower.arm.free], nan=FAR) / LIMIT_UNIT
        before = np.maximum.accumulate(past, axis=1)[rows, self._frames[choice]]
        ball, held = missed[rows, choice], tamed(before).sum(axis=1)
        after = tamed(past.max(axis=1)).sum(axis=1) - held
        change = np.mean((signals - thrower.individual) ** 2, axis=1)
        cost = ball + self._weight * held + after + EFFORT * thrower.effort(signals) + CHANGE * change
        for other in self._others:
            apart = np.sqrt(np.mean((signals - other) ** 2, axis=1))
            cost = cost + tamed(np.maximum(APART - apart, 0.0) / 0.01)
        return cost, ball + held, ball, self._frames[choice]
