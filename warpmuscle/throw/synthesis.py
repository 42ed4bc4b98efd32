"""New throws from goals alone: the signals of synergies change until the ball flies as wanted.

A known throw, its muscles and its synergies are the start. Unknown are changes of the signals at a few knots, which
CMA-ES searches for: every generation is one batch of simulations. The ball may leave the hand at any frame of a window
of time; of each candidate the frame that suits the goal best counts, so that the time of release is found with the
signals. It flies freely from there.

How they are searched for is described in `signal_search`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.scene.joints import root_type
from warpmuscle.throw.arm import hand_position, joint_positions, past_limits, states
from warpmuscle.throw.follow import Follower, Replay
from warpmuscle.throw.goals import LIMITS, PAST_LIMITS, Flight, Goal, fly
from warpmuscle.throw.metrics import determination
from warpmuscle.throw.motion import ArmMotions
from warpmuscle.throw.signal_search import SignalSearch

MOMENT = 1e-4  # s, of the difference quotient of the hand's velocity
SPACING = 0.1  # s, of the knots at which signals are changed
EARLIER, LATER = 0.35, 0.2  # s, by which the ball may leave before and after the known throw would carry farthest


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
    individual: Floats  # (size,) signals
    replay: Replay  # of one motion
    synergies: tuple[int, ...]  # whose signals changed
    change: float  # root mean square of that change
    resemblance: Floats  # (J,) r2 of its angles with those of the throw that it began as
    effort: float = 0.0  # mean square of the excitations up to the release
    clearance: float = np.inf  # m, by which the hand is above the shoulder at the release
    past_limits: Mapping[str, float] = field(default_factory=dict)  # rad, at most, of joints that pass their limits up
    past_after: Mapping[str, float] = field(default_factory=dict)  # to the release; the same of those behind it
    simulations: int = 0
    lack: str = ""  # what the muscles lack to meet the goal, if that was found

    @property
    def error(self) -> float:
        """By which the ball misses, m."""
        return abs(float(self.flight.distance[0]) - self.goal.distance) if self.goal.distance is not None else 0.0

    @property
    def landing(self) -> Floats:
        """Forwards from below the shoulder's start and above the ground, (2,) m; NaN where the ball does not land."""
        distance = float(self.flight.distance[0])
        return np.array([distance, self.goal.height if np.isfinite(distance) else np.nan])

    @property
    def missed(self) -> dict[str, float]:
        """What of the goal is missed by more than is allowed, and by how much.

        A ball that does not land meets no distance. A joint that passes its limits by more than is allowed, up to the
        release, misses those; behind it the arm may still come to its stops.
        """
        beyond = max(self.past_limits.values(), default=0.0)
        return self.flight.misses(self.goal) | ({LIMITS: beyond} if beyond > PAST_LIMITS else {})

    @property
    def met(self) -> bool:
        """Whether everything that the goal names is met."""
        return not self.missed


def check_release(release: float, motions: ArmMotions) -> None:
    """Error unless a time of release, s, is within the first motion."""
    end = float(motions.time[motions.valid[0] > 0.0][-1])
    if not 0.0 < release <= end:
        raise Error(f"the release must be within the throw, 0 to {end:g} s, not {release:g} s")


class Thrower:
    """Makes throws out of one that is known.

    Attributes:
        follower: what the known throw was fitted with. individual: (size,) its signals.
        values: (P,) of the scene's parameters.
        recorded: coordinates (T, C), speeds and accelerations (T, S) of the motion that the known throw follows.
        release: s, when the known throw would carry farthest, or the time that was asked for.
        frames: at which a ball may be let go. gravity: m/s^2.
        hats: (K, c) by how much a change at each coarse knot changes a signal at the knots.
    """

    def __init__(
        self,
        follower: Follower,
        individual: Floats,
        shared: Floats,
        release: float | None = None,
        motion: int = 0,
        seed: int = 0,
    ) -> None:
        """Begin with a fitted throw.

        Args:
            individual: (size,) its signals. shared: (P,) its parameters. motion: its number among the follower's.
            release: s; by default any time about the one when a ball that is let go with the hand above the shoulder
                flies farthest.
        """
        self.follower, self.individual, self._motion, self._seed = follower, individual.copy(), motion, seed
        arm, motions = follower.arm, follower.motions.rows([motion])
        self.values = arm.values(shared)
        self.recorded = tuple(part[0] for part in states(arm, motions))
        self._coordinates, self._speeds, _ = self.recorded
        plain = arm.plain
        if plain.ground.terrain is not None:
            raise SceneError("a throw lands on level ground; leave it out", "ground.terrain")
        if plain.water is not None:
            raise SceneError("a ball is thrown through air; leave the water out", "water")
        if plain.objects:
            raise SceneError("an arm throws its own ball; leave objects out", "objects")
        self.gravity, self._ground = float(plain.gravity), float(plain.ground.height)  # type: ignore[arg-type]
        self._shoulder = joint_positions(arm, self._coordinates)[0][:, [2, 1]]
        self._below = float(self._shoulder[0, 0])
        self._step = float(motions.time[1] - motions.time[0])
        self._last = last = int(np.flatnonzero(motions.valid[0] > 0.0)[-1])
        self.known = self.simulated(individual[None])
        if release is None:
            best = self._best_frame(last)
            first, final = best - round(EARLIER / self._step), best + round(LATER / self._step)
            self.frames: Integers = np.arange(max(first, 1), min(final, last) + 1)
            self.release = best * self._step
        else:
            check_release(release, motions)
            self.release = release
            self.frames = np.array([int(np.clip(round(release / self._step), 0, last))])
        self.hats = self._coarse()

    def _best_frame(self, last: int) -> int:
        """The frame from which the known throw would carry farthest with the hand above the shoulder."""
        frames = np.arange(1, last + 1)
        flight, clearance = self.flights(self.known, frames, 0.0)
        distance = np.where(clearance[0] > 0.0, np.nan_to_num(flight.distance[0], nan=-np.inf), -np.inf)
        if not np.isfinite(distance).any():
            raise Error("the hand never comes above the shoulder in this throw: say when to release the ball")
        return int(frames[distance.argmax()])

    def _coarse(self) -> Floats:
        """By how much a change at each coarse knot (c,) changes the signals at the knots (K, c), to the throw's end.

        After the release, too: an arm that throws faster has to be braked before its joints come to their limits.
        """
        end = float(self._last) * self._step
        count = max(round(end / SPACING), 1) + 1
        places = np.linspace(0.0, end, count)
        time = self.follower.knots.time
        far = np.abs(np.minimum(time, end)[:, None] - places) / (places[1] - places[0])
        return np.asarray(np.maximum(0.0, 1.0 - far))

    def tail(self, frame: int) -> Floats:
        """As `hats` (K, c), of the knots behind a frame of release, which change little before it."""
        time, released = self.follower.knots.time, frame * self._step
        after = np.flatnonzero(time > released + 1e-9)
        return np.eye(len(time))[:, after]

    def flights(self, replay: Replay, frames: Integers, height: float) -> tuple[Flight, Floats]:
        """Flights (B, F) of balls let go at some frames, and the hand's height above the shoulder there, m."""
        arm, count = self.follower.arm, len(replay.angle)
        ends = []
        for sign in (-1.0, 1.0):
            moved = np.tile(self._coordinates[frames], (count, 1, 1))
            if root_type(arm.scene.character).speeds:
                moved[:, :, :3] += sign * MOMENT * self._speeds[frames, :3]
            moved[:, :, arm.coordinate_places] = replay.angle[:, frames] + sign * MOMENT * replay.speed[:, frames]
            hand = hand_position(arm, moved.reshape(count * len(frames), -1))[:, [2, 1]]
            ends.append(hand.reshape(count, len(frames), 2))
        position, velocity = 0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]) / (2.0 * MOMENT)
        clearance = position[:, :, 1] - self._shoulder[frames, 1]
        return fly(position - [self._below, self._ground], velocity, self.gravity, height), clearance

    def throws(
        self,
        goal: Goal,
        count: int = 1,
        synergies: tuple[int, ...] | None = None,
        progress: Callable[[str], None] = lambda what: None,
    ) -> list[Throw]:
        """Some throws that meet a goal as well as the muscles can, each unlike those before it.

        Args:
            synergies: whose signals may change; by default all.
        """
        found: list[Throw] = []
        for number in range(count):
            progress(f"throwing {goal}" + (f", solution {number + 1} of {count}" if count > 1 else ""))
            found.append(self._throw(goal, synergies, [made.individual for made in found]))
        return found

    def throw(self, goal: Goal, synergies: tuple[int, ...] | None = None) -> Throw:
        """A throw that meets a goal as well as the muscles can."""
        return self.throws(goal, 1, synergies)[0]

    def stronger(self, factor: float) -> Thrower:
        """The same with muscles so many times as strong.

        Raises:
            Error: the scene says of no muscle that its strength is free.
        """
        names = [parameter.name for parameter in self.follower.arm.parameters]
        strengths = np.array([name.endswith(".f_max") for name in names])
        if not strengths.any():
            raise Error("no muscle's f_max is free")
        other = object.__new__(Thrower)
        other.__dict__ = dict(self.__dict__)
        other.values = np.where(strengths, factor * self.values, self.values)
        return other

    def _throw(self, goal: Goal, synergies: tuple[int, ...] | None, others: Sequence[Floats]) -> Throw:
        """One throw, unlike others (size,)."""
        chosen = tuple(range(self.follower.synergies.count)) if synergies is None else synergies
        search = SignalSearch(self, goal, chosen, others)
        best, simulations = search.run(self._seed + len(others))
        individual, frame = best
        replay = self.simulated(individual[None])
        flight, clearance = self.flights(replay, np.array([frame]), goal.height)
        one = replace(flight, **{name: getattr(flight, name)[:, 0] for name in
                                 ("position", "velocity", "distance", "duration", "short")})  # fmt: skip
        follower = self.follower
        free, valid = follower.arm.free, follower.motions.valid[[self._motion]]
        resemblance = determination(replay.angle[:, :, free], self.known.angle[:, :, free], valid)[0]
        change = float(np.sqrt(np.mean((individual - self.individual) ** 2)))
        return Throw(
            goal, one, frame * self._step, self._below, self._ground, self.gravity, self.individual, individual, replay,
            chosen, change, resemblance, float(self.effort(individual[None])[0]), float(clearance[0, 0]),
            *self.past(replay, frame), simulations,
        )  # fmt: skip

    def past(self, replay: Replay, frame: int) -> tuple[dict[str, float], dict[str, float]]:
        """Joints that pass their limits in a throw, and by how much at most, rad: up to its release, and behind it."""
        arm = self.follower.arm
        past = self.past_limits(replay)[0]
        most = past[: frame + 1].max(axis=0), past[frame:].max(axis=0)
        before, after = ({arm.joints[k]: float(part[k]) for k in arm.free if part[k] > 0.0} for part in most)
        return before, after

    def past_limits(self, replay: Replay) -> Floats:
        """By how much joints pass their limits from the begin to the end of the throw, (B, T, J), rad."""
        return past_limits(self.follower.arm, replay.angle[:, : self._last + 1])

    def simulated(self, signals: Floats, last: int | None = None) -> Replay:
        """Copies under signals (B, size), whole or up to a frame."""
        follower = self.follower
        which = np.full(len(signals), self._motion, dtype=np.intp)
        angle, speed = follower.simulator.run(
            which, follower.knots.time, follower.excitation(signals), self.values, follower.start(signals),
            until=None if last is None else last * self._step,
        )  # fmt: skip
        return Replay(angle, speed)

    def effort(self, signals: Floats) -> Floats:
        """Mean square of the excitations up to the last time of release, (B,)."""
        excitation = self.follower.excitation(signals)
        until = self.follower.knots.time <= self.frames[-1] * self._step
        acting = self.follower.arm.acting
        return np.asarray(np.mean(excitation[:, acting][:, :, until] ** 2, axis=(1, 2)))
