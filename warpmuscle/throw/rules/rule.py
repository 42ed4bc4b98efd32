"""From goals to signals of new throws: a rule that is learned from throws that were searched for.

Many signals meet a goal, and a rule can be learned only of some that change steadily with it. So a throw that meets a
goal in the middle is searched for globally, out of one recorded throw, and its time of release is kept; every other
goal, of distance, height and angle of release, is met by the signals nearest to those of this one throw. They are found
by Gauss-Newton from the signals of the nearest goal that was met, and how far joints pass their limits counts as misses
do. A rule, a thin-plate spline, learns the signals from
these goals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error
from warpmuscle.throw.goals import ALLOWED, LIMIT_UNIT, PAST_LIMITS, Goal, fly
from warpmuscle.throw.job import Job
from warpmuscle.throw.least_squares import Prior, Unknowns, fit
from warpmuscle.throw.motion import RATE
from warpmuscle.throw.synthesis import Thrower

LOW, HIGH = np.array([2.0, 0.0, np.radians(10.0)]), np.array([4.0, 1.0, np.radians(40.0)])  # m, m, rad: what is learned
MARGIN = 0.12  # of that box, by which goals beyond it are
MIDDLE = Goal(3.0, 0.5, angle=np.radians(25.0))
UNITS = np.array([0.02, np.radians(1.0)])  # of a landing and of an angle
PRICE = 3.0  # of a squared change of a signal from the middle's, against a squared error in its unit
STEPS = 12  # of Gauss-Newton from one goal to the next, at most
DAMPING = 1.0  # at its start: two outcomes of many signals curve strongly
STEP = 5e-3  # of a change, in difference quotients: single precision spoils those of smaller ones
FAR = 50.0  # units, of limits that are passed, beyond which that counts no more
RESOLUTION = 0.3  # m/s, that count as much as the whole extent of the goals
SMOOTHING = 1e-3
ATTEMPTS = 3  # searches for the throw in the middle
LEAST_GOALS = 10  # with the middle: a plane in five numbers, and some more
STEADY = 1e-2  # relative gain of a step, below which it is enough


@dataclass
class Walk:
    """Throws that meet goals (G, 3): distance, height, angle; changes (G, U) of the signals from the first one's."""

    thrower: Thrower
    goals: list[Floats]
    changes: list[Floats]
    simulations: int = 0

    def signals(self, changes: Floats) -> Floats:
        """Signals (B, size) of changes (B, U) at the coarse knots."""
        hats, count = self.thrower.hats, self.thrower.follower.synergies.count
        knots = len(self.thrower.follower.knots)
        moved = (changes.reshape(len(changes), count, -1) @ hats.T).reshape(len(changes), count * knots)
        signals = np.tile(self.thrower.individual, (len(changes), 1))
        signals[:, : count * knots] = np.clip(signals[:, : count * knots] + moved, 0.0, 1.0)
        return signals

    def outcomes(self, changes: Floats, goals: Floats) -> tuple[Floats, Floats]:
        """What throws of changes (B, U) at goals (B, 3) come to.

        Returns:
            Where balls land, at each goal's height, m, and at which angle they leave, rad, (B, 2); and by how much
            joints pass their limits up to the release, (B, frames, joints), rad.
        """
        thrower = self.thrower
        frame = int(thrower.frames[-1])
        replay = thrower.simulated(self.signals(changes), frame)
        self.simulations += len(changes)
        flight, _ = thrower.flights(replay, np.array([frame]), 0.0)
        landed = fly(flight.position[:, 0], flight.velocity[:, 0], thrower.gravity, goals[:, 1])
        past = thrower.past_limits(replay)[:, : frame + 1, thrower.follower.arm.free]
        return np.stack([np.nan_to_num(landed.distance), landed.angle], axis=1), past

    @cached_property
    def acting(self) -> NDArray[np.bool_]:
        """Which changes (U,) of the signals act before the ball is let go; the others stay 0."""
        follower, release = self.thrower.follower, self.thrower.frames[-1] / RATE
        until = int(np.searchsorted(follower.knots.time, release - 1e-9))  # signals are straight up to that knot
        return np.tile(self.thrower.hats[: until + 1].any(axis=0), follower.synergies.count)

    def all_changes(self, acting: Floats) -> Floats:
        """Changes (B, U) of those that act."""
        found = np.zeros((len(acting), len(self.acting)))
        found[:, self.acting] = acting
        return found

    def nearest(self, goal: Floats) -> int:
        """Which of the goals that are met is nearest."""
        return int(np.argmin(np.linalg.norm((np.array(self.goals) - goal) / (HIGH - LOW), axis=1)))

    def to(self, goal: Floats) -> bool:
        """Meet one more goal with the least change from the first, found from the nearest on; False if that fails."""

        def residuals(which: Any, x: Floats, shared: Floats) -> Floats:
            outcome, past = self.outcomes(self.all_changes(x), np.tile(goal, (len(x), 1)))
            held = np.minimum(past.reshape(len(x), -1) / LIMIT_UNIT, FAR)
            return np.concatenate([(outcome - goal[[0, 2]]) / UNITS, held], axis=1)

        size = int(self.acting.sum())
        price = Prior(PRICE * np.eye(size), np.zeros(size))
        start = self.changes[self.nearest(goal)][None, self.acting]
        unknowns = Unknowns(start, -np.ones(size), np.ones(size), STEP, None, [price])
        nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
        found = fit(residuals, unknowns, nothing, iterations=STEPS, damping=DAMPING, tolerance=STEADY).individual
        found = self.all_changes(found)[0]
        outcome, past = self.outcomes(found[None], goal[None])
        error = np.abs(outcome[0] - goal[[0, 2]])
        if error[0] > ALLOWED["distance"] or error[1] > ALLOWED["angle"] or past.max() > PAST_LIMITS:
            return False
        self.goals.append(goal)
        self.changes.append(found)
        return True


def goals_about(count: int, beyond: float, rng: np.random.Generator) -> Floats:
    """Goals (count, 3) within the box, or if `beyond` is positive outside of it by up to that part of its edges."""
    found: list[Floats] = []
    while len(found) < count:
        part = rng.uniform(-beyond, 1.0 + beyond, 3)
        if beyond and np.all((part >= 0.0) & (part <= 1.0)):
            continue
        found.append(LOW + part * (HIGH - LOW))
    return np.array(found)


def beyond_learned(goal: Floats) -> str:
    """What of a goal (3,) is beyond those that rules learn from; empty if nothing."""
    named = (("a distance", "m", 1.0), ("a height", "m", 1.0), ("an angle", "deg", np.degrees(1.0)))
    found = []
    for (name, unit, factor), low, high, value in zip(named, LOW, HIGH, goal, strict=True):
        if not low <= value <= high:
            least, most = factor * low, factor * high
            found.append(f"{name} of {factor * value:.3g} {unit}, but of {least:.3g} to {most:.3g} {unit}")
    return "; ".join(found)


def release_velocity(goals: Floats, place: Floats, gravity: float) -> Floats:
    """Velocities (B, 2), m/s, with which balls must leave a place (2,) to meet goals (B, 3); without drag."""
    forward, up, angle = goals[:, 0] - place[0], goals[:, 1] - place[1], goals[:, 2]
    drop = np.maximum(forward * np.tan(angle) - up, 1e-3)
    speed = np.abs(forward) / np.cos(angle) * np.sqrt(0.5 * gravity / drop)
    return np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=1)


def learned(goals: Floats, changes: Floats, place: Floats, gravity: float) -> Any:
    """The rule: a function of goals (B, 3) to changes (B, U).

    Its inputs are the goals, and the velocity with which a ball would have to leave the middle throw's place of
    release.
    """

    def inputs(asked: Floats) -> Floats:
        return np.hstack([RESOLUTION * (asked - LOW) / (HIGH - LOW), release_velocity(asked, place, gravity)])

    rule = RBFInterpolator(inputs(goals), changes, kernel="thin_plate_spline", smoothing=SMOOTHING)
    return lambda asked: rule(inputs(asked))


@dataclass
class Rule:
    """What was learned, from what, and how far that has come.

    Attributes:
        walk: the goals that are met.
        place: (2,) m, of the middle throw's release; `release` when that is, s.
        parameters: (P,) of the fit, see `Arm.unknowns`.
        wanted: (G, 3) goals to learn from, those near the middle first.
        met: (G,) whether they are. tried_from: (G,) number of the met goal they were last tried from, -1 before that.
    """

    walk: Walk
    place: Floats
    release: float
    parameters: Floats
    wanted: Floats
    met: NDArray[np.bool_]
    tried_from: Integers
    seed: int

    @property
    def goals(self) -> Floats:
        """(G, 3): distance, m, height, m, and angle, rad, of the middle and of those that were met."""
        return np.array(self.walk.goals)

    @property
    def changes(self) -> Floats:
        """(G, U) of the signals, for these goals."""
        return np.array(self.walk.changes)

    @property
    def enough(self) -> bool:
        """Whether a rule can be learned of what is met."""
        return len(self.walk.goals) >= LEAST_GOALS

    def meet(self, progress: Callable[[str], None] = lambda what: None) -> None:
        """Try all goals that were not tried; then those that were missed, where there is another one near to begin at.

        Where Ctrl-C ends it, everything up to the last whole goal is kept, and the next call goes on from there.
        """
        count = len(self.wanted)
        for number in range(count):
            if self.tried_from[number] < 0:
                progress(f"meeting goal {number + 1} of {count}")
                self._try(number)
        for number in np.flatnonzero(~self.met).tolist():
            if self.walk.nearest(self.wanted[number]) != self.tried_from[number]:
                progress(f"meeting goal {number + 1} of {count}, which was missed, from a nearer one")
                self._try(number)

    def _try(self, number: int) -> None:
        """Try a goal; where Ctrl-C ends it at whatever moment, it is as if it had not been tried."""
        goal, walk = self.wanted[number], self.walk
        near, count, tried_from = walk.nearest(goal), len(walk.goals), self.tried_from[number]
        try:
            self.met[number] = walk.to(goal)
            self.tried_from[number] = near
        except KeyboardInterrupt:
            del walk.goals[count:], walk.changes[count:]
            self.met[number], self.tried_from[number] = False, tried_from
            raise

    def predicted(self, asked: Floats) -> Floats:
        """Changes (B, U) of the signals for goals (B, 3)."""
        return np.asarray(learned(self.goals, self.changes, self.place, self.walk.thrower.gravity)(asked))

    def copied(self, asked: Floats) -> Floats:
        """As `predicted`, of the nearest goal that was met: what a rule is to be better than."""
        far = np.linalg.norm((self.goals[None] - asked[:, None]) / (HIGH - LOW), axis=2)
        return np.asarray(self.changes[np.argmin(far, axis=1)])

    def errors(self, changes: Floats, asked: Floats) -> Floats:
        """Of throws, by simulation, (B, 3): errors of landing, m, and angle, rad; how far limits are passed, rad."""
        outcome, past = self.walk.outcomes(changes, asked)
        return np.column_stack([np.abs(outcome - asked[:, [0, 2]]), past.max(axis=(1, 2))])


def begin(job: Job, count: int, seed: int = 0, progress: Callable[[str], None] = lambda what: None) -> Rule:
    """A rule out of the first motion of a fitted job, that is yet to meet so many goals.

    Raises:
        Error: the goal in the middle is out of reach.
    """
    if job.fitted is None:
        raise Error("fit a throw before learning a rule")
    progress("throwing at the middle")
    for attempt in range(ATTEMPTS):
        first = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns, seed=seed + 10 * attempt).throw(
            MIDDLE
        )
        if first.met:
            break
    if not first.met:
        raise Error(f"no throw {MIDDLE} was found, from which to learn others: missed {', '.join(first.missed)}")
    thrower = Thrower(job.follower, first.individual, job.fitted.unknowns, first.release, seed=seed)
    size = thrower.hats.shape[1] * job.follower.synergies.count
    walk = Walk(thrower, [np.array([MIDDLE.distance, MIDDLE.height, MIDDLE.angle], dtype=np.float64)], [np.zeros(size)])
    wanted = goals_about(count, 0.0, np.random.default_rng(seed))
    wanted = wanted[np.argsort(np.linalg.norm((wanted - walk.goals[0]) / (HIGH - LOW), axis=1))]
    place = first.flight.position.reshape(-1, 2)[0]
    return Rule(walk, place, first.release, job.fitted.unknowns, wanted, np.zeros(count, dtype=bool),
                np.full(count, -1), seed)  # fmt: skip
