"""Whether signals of new throws can be told from their goals: a rule learned from throws that were searched for.

Many signals meet a goal, and a rule can be learned only of some that change steadily with it. So a throw that meets a
goal in the middle is searched for globally, out of one recorded throw, and its time of release is kept; every other
goal, of distance, height and angle of release, is met by the signals nearest to those of this one throw. They are found
by Gauss-Newton from the signals of the nearest goal that was met. A rule, a thin-plate spline, learns the signals from
these goals; it is tried on others between them and beyond them, by simulation, beside a copy of the signals of the
nearest goal, and beside the spread of the recorded throws, all of which were meant for one target.

Example: python tools/throw_prediction.py throws/*.csv -o prediction.npz
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from scipy.interpolate import RBFInterpolator

from warpmuscle.core.array_types import Floats
from warpmuscle.formats import load
from warpmuscle.throw.arm import hand_position, states
from warpmuscle.throw.goals import ALLOWED, Goal, fly
from warpmuscle.throw.job import Job, Options
from warpmuscle.throw.least_squares import Prior, Unknowns, fit
from warpmuscle.throw.synthesis import Thrower

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

    def to(self, goal: Floats) -> bool:
        """Meet one more goal with the least change from the first, found from the nearest on; False if that fails."""
        near = int(np.argmin(np.linalg.norm((np.array(self.goals) - goal) / (HIGH - LOW), axis=1)))

        def residuals(which: Any, x: Floats, shared: Floats) -> Floats:
            return (self.outcomes(x, np.tile(goal, (len(x), 1))) - goal[[0, 2]]) / UNITS

        size = len(self.changes[0])
        price = Prior(PRICE * np.eye(size), np.zeros(size))
        unknowns = Unknowns(self.changes[near][None], -np.ones(size), np.ones(size), STEP, None, [price])
        nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
        found = fit(residuals, unknowns, nothing, iterations=STEPS, damping=DAMPING, tolerance=STEADY).own[0]
        error = self.outcomes(found[None], goal[None])[0] - goal[[0, 2]]
        if abs(error[0]) > ALLOWED["distance"] or abs(error[1]) > ALLOWED["angle"]:
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


def own_spread(job: Job) -> tuple[float, float]:
    """Median and 95th percentile of how far a man's recorded throws land from their median, m, at half a metre.

    The ball is let go where it carries farthest in each.
    """
    arm, motions = job.arm, job.motions
    step = 1e-4
    landing = []
    coordinates, speeds, _ = states(arm, motions)
    for row in range(len(motions)):
        ends = []
        for sign in (-1.0, 1.0):
            moved = coordinates[row].copy()
            moved[:, :3] += sign * step * speeds[row][:, :3]
            moved[:, arm.coordinate_places] += sign * step * motions.angles[1][row]
            ends.append(hand_position(arm, moved)[:, [2, 1]])
        flight = fly(0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]) / (2.0 * step), 9.81, 0.5)
        landing.append(np.nanmax(flight.distance) - ends[0][0, 0])
    error = np.abs(np.array(landing) - np.median(landing))
    return float(np.median(error)), float(np.percentile(error, 95))


def main(
    files: Annotated[list[Path], typer.Argument(help="Motions, as `warpmuscle throw` takes them.")],
    scene: Annotated[str, typer.Option(help="The arm, with a ball in its hand.")] = "throw_ball",
    learn: Annotated[int, typer.Option(help="Goals to learn from.")] = 200,
    between: Annotated[int, typer.Option(help="Goals between these to try.")] = 30,
    beyond: Annotated[int, typer.Option(help="Goals beyond them to try.")] = 20,
    threads: Annotated[int | None, typer.Option(help="CPU threads.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help=".npz of goals, changes and errors.")] = None,
) -> None:
    """Print one table: median and 95th percentile of the landing errors."""
    begin = time.process_time()
    job = Job(load(scene), files[:1], Options(threads=threads))
    fitted = job.fit()
    first = Thrower(job.follower, fitted.own[0], fitted.unknowns).throw(MIDDLE)
    print(f"middle: {MIDDLE} {'met' if first.met else 'missed'}, released after {first.release:.2f} s", flush=True)
    thrower = Thrower(job.follower, first.own, fitted.unknowns, first.release)
    size = thrower.hats.shape[1] * job.follower.synergies.count
    walk = Walk(thrower, [np.array([3.0, 0.5, np.radians(25.0)])], [np.zeros(size)])
    rng = np.random.default_rng(0)
    wanted = goals_about(learn, 0.0, rng)
    order = np.argsort(np.linalg.norm((wanted - walk.goals[0]) / (HIGH - LOW), axis=1))
    missed = [goal for goal in wanted[order] if not walk.to(goal)]
    missed = [goal for goal in missed if not walk.to(goal)]  # now that there are others nearer to them
    met = learn - len(missed)
    goals, changes = np.array(walk.goals), np.array(walk.changes)
    print(f"{met} of {learn} goals to learn from are met, {walk.simulations} simulations, "
          f"{time.process_time() - begin:.0f} s of CPU", flush=True)  # fmt: skip
    rule = learned(goals, changes, first.flight.position[0], thrower.gravity)
    spread = own_spread(Job(load("throw"), files, Options())) if len(files) > 1 else None
    print(f"{'goals':10s} {'rule':26s} landing error, cm: median, 95 %   angle, deg: median, 95 %")
    kept: dict[str, Floats] = {"goals": goals, "changes": changes}
    for name, asked in (("between", goals_about(between, 0.0, rng)), ("beyond", goals_about(beyond, MARGIN, rng))):
        nearest = np.argmin(np.linalg.norm((goals[None] - asked[:, None]) / (HIGH - LOW), axis=2), axis=1)
        for what, guess in (("learned", rule(asked)), ("copy of the nearest", changes[nearest])):
            error = np.abs(walk.outcomes(guess, asked) - asked[:, [0, 2]])
            kept[f"{name} {what}"] = error
            print(line(name, what, error), flush=True)
    for what in ("learned", "copy of the nearest"):
        print(line("all", what, np.concatenate([kept[f"between {what}"], kept[f"beyond {what}"]])))
    if spread is not None:
        print(f"{'one':10s} {'the man himself':26s} {100.0 * spread[0]:18.1f} {100.0 * spread[1]:6.1f}")
    if output is not None:
        np.savez_compressed(output, **{key.replace(" ", "_"): value for key, value in kept.items()})


def line(name: str, what: str, error: Floats) -> str:
    """A line of the table, of errors (B, 2): m and rad."""
    middle, most = np.median(error, axis=0), np.percentile(error, 95, axis=0)
    return (f"{name:10s} {what:26s} {100.0 * middle[0]:18.1f} {100.0 * most[0]:6.1f} "
            f"{np.degrees(middle[1]):19.2f} {np.degrees(most[1]):6.2f}")  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
