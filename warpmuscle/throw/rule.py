"""From goals to signals of new throws: a rule that is learned from throws that were searched for.

Many signals meet a goal, and a rule can be learned only of some that change steadily with it. So a throw that meets a
goal in the middle is searched for globally, out of one recorded throw, and its time of release is kept; every other
goal, of distance, height and angle of release, is met by the signals nearest to those of this one throw. They are found
by Gauss-Newton from the signals of the nearest goal that was met. A rule, a thin-plate spline, learns the signals from
these goals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.throw.goals import ALLOWED, PAST_LIMITS, Goal, fly
from warpmuscle.throw.job import Job
from warpmuscle.throw.least_squares import Prior, Unknowns, fit
from warpmuscle.throw.synthesis import Throw, Thrower

LOW, HIGH = np.array([2.0, 0.0, np.radians(10.0)]), np.array([4.0, 1.0, np.radians(40.0)])  # m, m, rad: what is learned
MARGIN = 0.12  # of that box, by which goals beyond it are
MIDDLE = Goal(3.0, 0.5, angle=np.radians(25.0))
UNITS = np.array([0.02, np.radians(1.0)])  # of a landing and of an angle
PRICE = 3.0  # of a squared change of a signal from the middle's, against a squared error in its unit
STEPS = 12  # of Gauss-Newton from one goal to the next, at most
DAMPING = 1.0  # at its start: two outcomes of many signals curve strongly
STEP = 5e-3  # of a change, in difference quotients: single precision spoils those of smaller ones
TOLD = 0.3  # m/s, that count as much as the whole extent of the goals
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
        signals = np.tile(self.thrower.own, (len(changes), 1))
        signals[:, : count * knots] = np.clip(signals[:, : count * knots] + moved, 0.0, 1.0)
        return signals

    def outcomes(self, changes: Floats, goals: Floats) -> Floats:
        """Where balls land, at each goal's height, m, and at which angle they leave, rad: (B, 2)."""
        frame = int(self.thrower.frames[-1])
        replay = self.thrower.simulated(self.signals(changes), frame)
        self.simulations += len(changes)
        flight, _ = self.thrower.flights(replay, np.array([frame]), 0.0)
        out = [fly(flight.position[k, 0], flight.velocity[k, 0], self.thrower.gravity, height)
               for k, height in enumerate(goals[:, 1])]  # fmt: skip
        return np.array([[np.nan_to_num(float(one.distance)), float(one.angle)] for one in out])

    def past_limits(self, changes: Floats) -> Floats:
        """By how much joints pass their limits at most up to the release, in throws of changes (B, U), (B,) rad."""
        replay, frame = self.thrower.simulated(self.signals(changes)), int(self.thrower.frames[-1])
        past = self.thrower.past_limits(replay)[:, : frame + 1, self.thrower.follower.arm.free]
        return np.asarray(past.max(axis=(1, 2)))

    def to(self, goal: Floats) -> bool:
        """Meet one more goal with the least change from the first, found from the nearest on; False if that fails."""
        near = int(np.argmin(np.linalg.norm((np.array(self.goals) - goal) / (HIGH - LOW), axis=1)))

        def residuals(which: Any, x: Floats, shared: Floats) -> Floats:
            return np.asarray((self.outcomes(x, np.tile(goal, (len(x), 1))) - goal[[0, 2]]) / UNITS)

        size = len(self.changes[0])
        price = Prior(PRICE * np.eye(size), np.zeros(size))
        unknowns = Unknowns(self.changes[near][None], -np.ones(size), np.ones(size), STEP, None, [price])
        nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
        found = fit(residuals, unknowns, nothing, iterations=STEPS, damping=DAMPING, tolerance=STEADY).own[0]
        error = self.outcomes(found[None], goal[None])[0] - goal[[0, 2]]
        if abs(error[0]) > ALLOWED["distance"] or abs(error[1]) > ALLOWED["angle"]:
            return False
        if self.past_limits(found[None])[0] > PAST_LIMITS:
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


def release_velocity(goals: Floats, place: Floats, gravity: float) -> Floats:
    """Velocities (B, 2), m/s, with which balls must leave a place (2,) to meet goals (B, 3); without drag."""
    forward, up, angle = goals[:, 0] - place[0], goals[:, 1] - place[1], goals[:, 2]
    drop = np.maximum(forward * np.tan(angle) - up, 1e-3)
    speed = np.abs(forward) / np.cos(angle) * np.sqrt(0.5 * gravity / drop)
    return np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=1)


def learned(goals: Floats, changes: Floats, place: Floats, gravity: float) -> Any:
    """The rule: a function of goals (B, 3) to changes (B, U).

    It is told the goals and with which velocity a ball would have to leave the middle throw's place of release.
    """

    def told(asked: Floats) -> Floats:
        return np.hstack([TOLD * (asked - LOW) / (HIGH - LOW), release_velocity(asked, place, gravity)])

    rule = RBFInterpolator(told(goals), changes, kernel="thin_plate_spline", smoothing=SMOOTHING)
    return lambda asked: rule(told(asked))


@dataclass(frozen=True)
class Rule:
    """What was learned, and from what.

    `goals` (G, 3): distance, m, height, m, and angle, rad, of those that were met; `changes` (G, U) of the signals.
    """

    walk: Walk
    middle: Throw
    wanted: int  # goals that were tried

    @property
    def goals(self) -> Floats:
        return np.array(self.walk.goals)

    @property
    def changes(self) -> Floats:
        return np.array(self.walk.changes)

    def told(self, asked: Floats) -> Floats:
        """Changes (B, U) of the signals for goals (B, 3)."""
        place = self.middle.flight.position.reshape(-1, 2)[0]
        return np.asarray(learned(self.goals, self.changes, place, self.walk.thrower.gravity)(asked))

    def copied(self, asked: Floats) -> Floats:
        """As `told`, of the nearest goal that was met: what a rule is to be better than."""
        far = np.linalg.norm((self.goals[None] - asked[:, None]) / (HIGH - LOW), axis=2)
        return np.asarray(self.changes[np.argmin(far, axis=1)])

    def errors(self, changes: Floats, asked: Floats) -> Floats:
        """Errors (B, 2) of landing, m, and angle, rad, of throws, by simulation."""
        return np.asarray(np.abs(self.walk.outcomes(changes, asked) - asked[:, [0, 2]]))


def learn(job: Job, count: int, seed: int = 0, progress: Callable[[str], None] = lambda what: None) -> Rule:
    """A rule out of the first motion of a fitted job, of so many goals.

    Raises:
        Error: the goal in the middle is out of reach, or too few others are met.
    """
    if job.fitted is None:
        raise Error("fit a throw before learning a rule")
    progress("throwing at the middle")
    for attempt in range(ATTEMPTS):
        first = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns, seed=seed + 10 * attempt).throw(MIDDLE)
        if first.met:
            break
    if not first.met:
        raise Error(f"no throw {MIDDLE} was found, from which to learn others: missed {', '.join(first.missed)}")
    thrower = Thrower(job.follower, first.own, job.fitted.unknowns, first.release, seed=seed)
    size = thrower.hats.shape[1] * job.follower.synergies.count
    walk = Walk(thrower, [np.array([MIDDLE.distance, MIDDLE.height, MIDDLE.angle], dtype=np.float64)], [np.zeros(size)])
    wanted = goals_about(count, 0.0, np.random.default_rng(seed))
    order = np.argsort(np.linalg.norm((wanted - walk.goals[0]) / (HIGH - LOW), axis=1))
    missed = []
    for number, goal in enumerate(wanted[order]):
        progress(f"meeting goal {number + 1} of {count}")
        if not walk.to(goal):
            missed.append(goal)
    for goal in missed:  # now that there are others nearer to them
        walk.to(goal)
    if len(walk.goals) < LEAST_GOALS:
        met = len(walk.goals) - 1
        raise Error(f"{met} of {count} goals are met, too few to learn from; at least {LEAST_GOALS - 1}")
    return Rule(walk, first, count)
