"""New throws from goals alone: the signals of a few synergies change until the ball flies as wanted.

A known throw, its muscles and its synergies are the start. The ball leaves the hand at a given time and flies freely.
Unknown are the signals of the chosen synergies at their knots up to then; everything else stays as it was.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.throw.arm import hand_position, joint_positions, states
from warpmuscle.throw.follow import Follower, Replay
from warpmuscle.throw.least_squares import Prior, Unknowns, fit
from warpmuscle.throw.metrics import determination
from warpmuscle.throw.motion import Motions

ALLOWED = {"distance": 0.05, "speed": 0.1, "angle": np.radians(2.0)}  # m, m/s, rad, by which a ball may miss its goal
MOMENT = 1e-4  # s, of the difference quotient of the hand's velocity
PRICE = 1e-3  # of a squared change of a signal at a knot, against a squared error in its unit
UNITS = {"distance": 0.02, "speed": 0.05, "angle": np.radians(1.0)}  # errors that count as 1: m, m/s, rad
WINDOW = 0.5  # s before the release in which signals change: earlier ones change the whole course of the motion
PACE = 20.0  # units by which a goal is approached at once
STEPS = 12


@dataclass(frozen=True)
class Goal:
    """What a ball is to do; what is None may be anything."""

    distance: float | None = None  # m, forwards from below the shoulder's start to where it meets the height
    height: float = 0.0  # m, of the target above the ground
    speed: float | None = None  # m/s, at release
    angle: float | None = None  # rad, of the velocity above the horizontal at release

    def __post_init__(self) -> None:
        if self.distance is None and self.speed is None and self.angle is None:
            raise Error("a throw needs a goal: a distance, or a speed or an angle of release")
        for name in ("distance", "speed"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 100.0:
                raise Error(f"the {name} of a throw must be greater than 0 and less than 100, not {value:g}")
        if self.angle is not None and not abs(self.angle) <= np.pi / 2.0:
            raise Error(f"the angle of a throw must be from -90 to 90 deg, not {np.degrees(self.angle):g} deg")
        if not -10.0 <= self.height <= 100.0:
            raise Error(f"the height of a target must be from -10 to 100 m, not {self.height:g} m")

    def __str__(self) -> str:
        parts = [f"to {self.distance:g} m"] if self.distance is not None else []
        parts += [f"at {self.height:g} m of height"] if self.distance is not None and self.height else []
        parts += [f"with {self.speed:g} m/s"] if self.speed is not None else []
        parts += [f"at {np.degrees(self.angle):.3g} deg"] if self.angle is not None else []
        return " ".join(parts)


@dataclass(frozen=True)
class Flight:
    """A ball's release and landing, of B throws; forwards and up."""

    position: Floats  # (B, 2) m, at release, from below the shoulder's start and above the ground
    velocity: Floats  # (B, 2) m/s, at release
    distance: Floats  # (B,) m, where it meets the target's height on its way down; NaN if it never does
    duration: Floats  # (B,) s

    @property
    def speed(self) -> Floats:
        return np.asarray(np.linalg.norm(self.velocity, axis=1))

    @property
    def angle(self) -> Floats:
        """Above the horizontal, rad."""
        return np.asarray(np.arctan2(self.velocity[:, 1], self.velocity[:, 0]))


@dataclass(frozen=True)
class Throw:
    """A throw that was made."""

    goal: Goal
    flight: Flight  # of one throw
    release: float  # s
    below: float  # m, where the shoulder starts, forwards
    ground: float  # m, height of the ground
    gravity: float  # m/s^2
    known: Floats  # (size,) signals of the throw that it began as, see `Follower.size`
    own: Floats  # (size,) signals
    replay: Replay  # of one motion
    synergies: tuple[int, ...]  # whose signals changed
    change: float  # root mean square of that change
    resemblance: Floats  # (J,) r2 of its angles with those of the throw that it began as

    @property
    def error(self) -> float:
        """By which the ball misses, m."""
        return abs(float(self.flight.distance[0]) - self.goal.distance) if self.goal.distance is not None else 0.0

    @property
    def met(self) -> bool:
        """Whether everything that the goal names is met; a ball that does not land meets no distance."""
        misses = [
            abs(float(getattr(self.flight, name)[0]) - getattr(self.goal, name)) <= most
            for name, most in ALLOWED.items()
            if getattr(self.goal, name) is not None
        ]
        return all(misses)


def check_release(release: float, motions: Motions) -> None:
    """Error unless a time of release, s, is within the first motion."""
    end = float(motions.time[motions.valid[0] > 0.0][-1])
    if not 0.0 < release <= end:
        raise Error(f"the release must be within the throw, 0 to {end:g} s, not {release:g} s")


class Thrower:
    """Makes throws out of one that is known."""

    def __init__(self, follower: Follower, own: Floats, shared: Floats, release: float | None = None) -> None:
        """Begin with a fitted throw, the first of the follower's.

        Args:
            own: (size,) its signals. shared: (P,) its parameters.
            release: s; by default when a ball that is let go with the hand above the shoulder flies farthest.
        """
        self._follower, self._own, self._shared = follower, own.copy(), shared
        self.known = follower.replay(np.zeros(1, dtype=np.intp), own[None], shared)
        arm, self._recorded = follower.arm, states(follower.arm, follower.motions)[0][0]
        plain = substitute(arm.scene, start_values(arm.scene))
        self._gravity, self._ground = float(plain.gravity), float(plain.ground.height)  # type: ignore[arg-type]
        self._shoulder = joint_positions(arm, self._recorded)[0][:, [2, 1]]
        self._below = float(self._shoulder[0, 0])
        time = follower.motions.time
        if release is None:
            release = float(time[self._best_frame()])
        check_release(release, follower.motions)
        self.release = release
        self._frame = int(np.clip(round(release / (time[1] - time[0])), 0, len(time) - 1))

    def _best_frame(self) -> int:
        """The frame from which the known throw would carry farthest with the hand above the shoulder."""
        best, farthest = 0, -np.inf
        for frame in range(len(self._recorded)):
            position, velocity = self._hand(self.known, frame)
            if position[0, 1] > self._shoulder[frame, 1]:
                distance = float(self._fly(position, velocity, 0.0).distance[0])
                if distance > farthest:
                    best, farthest = frame, distance
        if best == 0:
            raise Error("the hand never comes above the shoulder in this throw: say when to release the ball")
        return best

    def _hand(self, replay: Replay, frame: int) -> tuple[Floats, Floats]:
        """Position and velocity (B, 2) of the hand at a frame, forwards and up."""
        arm, follower = self._follower.arm, self._follower
        q, v, _ = states(arm, follower.motions.rows([0]))
        ends = []
        for sign in (-1.0, 1.0):
            moved = np.repeat(q[:, frame], len(replay.angle), axis=0)
            if root_type(arm.scene.character).speeds:
                moved[:, :3] += sign * MOMENT * v[0, frame, :3]
            moved[:, arm.coordinate_places] = replay.angle[:, frame] + sign * MOMENT * replay.speed[:, frame]
            ends.append(hand_position(arm, moved)[:, [2, 1]])
        return 0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]) / (2.0 * MOMENT)

    def flight(self, replay: Replay, height: float) -> Flight:
        """The flights of balls let go in these throws, to a height above the ground, m."""
        return self._fly(*self._hand(replay, self._frame), height)

    def _fly(self, position: Floats, velocity: Floats, height: float) -> Flight:
        position = position - [self._below, self._ground]
        drop = velocity[:, 1] ** 2 + 2.0 * self._gravity * (position[:, 1] - height)
        duration = np.where(drop >= 0.0, (velocity[:, 1] + np.sqrt(np.maximum(drop, 0.0))) / self._gravity, np.nan)
        return Flight(position, velocity, position[:, 0] + velocity[:, 0] * duration, duration)

    def throw(self, goal: Goal, synergies: tuple[int, ...] | None = None, count: int = 3) -> Throw:
        """A throw that meets a goal as well as the muscles can.

        Args:
            synergies: whose signals may change; by default the `count` that matter most for the goal.
        """
        if synergies is None:
            synergies = self._most_useful(goal, count)
        places = self._places(synergies)
        own, start = self._own[places].copy(), self._outcome(self._own[None], goal)[0]
        wanted = self._wanted(goal)
        stages = max(int(np.ceil(np.abs(wanted - start).max() / PACE)), 1)
        for stage in range(1, stages + 1):
            between = start + (wanted - start) * stage / stages
            nearer = self._approach(own, places, goal, between)
            if not self._nearer(nearer, own, places, goal, wanted):
                break
            own = nearer
        signals = self._own.copy()
        signals[places] = own
        replay = self._replay(signals[None])
        known = self.known.angle[:, :, self._follower.arm.free]
        resemblance = determination(
            replay.angle[:, :, self._follower.arm.free], known, self._follower.motions.valid[:1]
        )[0]
        change = float(np.sqrt(np.mean((own - self._own[places]) ** 2)))
        return Throw(
            goal, self.flight(replay, goal.height), self.release, self._below, self._ground, self._gravity, self._own,
            signals, replay, synergies, change, resemblance,
        )  # fmt: skip

    def _nearer(self, own: Floats, than: Floats, places: NDArray[np.intp], goal: Goal, wanted: Floats) -> bool:
        """Whether signals at some places come nearer to what is wanted than others."""
        signals = np.tile(self._own, (2, 1))
        signals[:, places] = own, than
        error = np.linalg.norm(self._outcome(signals, goal) - wanted, axis=1)
        return bool(error[0] < error[1])

    def _approach(self, own: Floats, places: NDArray[np.intp], goal: Goal, wanted: Floats) -> Floats:
        """Signals at some places that come nearest to what is wanted, from others on."""

        def residuals(which: NDArray[np.intp], x: Floats, _: Floats, rough: bool = False) -> Floats:
            signals = np.tile(self._own, (len(x), 1))
            signals[:, places] = x
            return np.asarray(self._outcome(signals, goal, rough) - wanted)

        def roughly(which: NDArray[np.intp], x: Floats, shared: Floats) -> Floats:
            return residuals(which, x, shared, rough=True)

        size = len(places)
        price = Prior(PRICE * np.eye(size), self._own[places][None])
        unknowns = Unknowns(own[None], np.zeros(size), np.ones(size), 1e-3, None, [price])
        nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
        found = fit(residuals, unknowns, nothing, iterations=STEPS, damping=1.0, tolerance=1e-5, rough=roughly)
        return np.asarray(found.own[0])

    def _replay(self, signals: Floats, rough: bool = False) -> Replay:
        return self._follower.replay(np.zeros(len(signals), dtype=np.intp), signals, self._shared, rough)

    def _outcome(self, signals: Floats, goal: Goal, rough: bool = False) -> Floats:
        """What the goal is about, in its units, (B, k)."""
        flight = self.flight(self._replay(signals, rough), goal.height)
        parts = [getattr(flight, name) / UNITS[name] for name in UNITS if getattr(goal, name) is not None]
        return np.asarray(np.nan_to_num(np.stack(parts, axis=1)))

    def _wanted(self, goal: Goal) -> Floats:
        return np.array([getattr(goal, name) / UNITS[name] for name in UNITS if getattr(goal, name) is not None])

    def _places(self, synergies: tuple[int, ...]) -> NDArray[np.intp]:
        """Of the values of these synergies' signals at knots within the window, and the one after the release."""
        knots = self._follower.knots
        inside = np.flatnonzero((knots.time > self.release - WINDOW) & (knots.time < self.release + knots.time[1]))
        return np.concatenate([number * len(knots) + inside for number in synergies])

    def _most_useful(self, goal: Goal, count: int) -> tuple[int, ...]:
        """The synergies whose signals change most of what the goal is about."""
        total = self._follower.synergies.count
        places = self._places(tuple(range(total)))
        moved = np.repeat(self._own[None], len(places), axis=0)
        sign = np.where(self._own[places] > 0.5, -1.0, 1.0)
        moved[np.arange(len(places)), places] += 0.01 * sign
        slope = (self._outcome(moved, goal) - self._outcome(self._own[None], goal)) / (0.01 * sign)[:, None]
        power = np.array([np.sum(slope[places // len(self._follower.knots) == k] ** 2) for k in range(total)])
        return tuple(sorted(np.argsort(-power)[: min(count, total)].tolist()))
