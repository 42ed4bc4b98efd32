"""Tunes a policy that walks by a few numbers: how much more or less it excites each muscle, on both sides alike.

    python tools/tune_policy.py tasks.h5 -o tuned.h5 --generations 22 --seed 1

What is searched, by CMA-ES, is added to the last layer of the policy, and everything else stays as it was learnt. A
candidate walks at three speeds and is pushed once, without noise. It is the better the less a metre costs (Bhargava),
the nearer angles and vertical force are to the key points of human walking, and moments of the legs to those that
searches may use (`scene.people.pinzone_two`), the longer its feet stay on the ground, up
to people's stance, the less its steps are wider or narrower than people's, and the less bodies are inside each other.
No other norm is looked at: those are for `warpmuscle judge`.
"""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.gait.cycles import body_weight, strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.joint_moments import from_people, leg_moments, mean_curves
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.learning.player import Player, replay, task_of, undisturbed
from warpmuscle.learning.policy import actions_of
from warpmuscle.results.learned import CURVE, Ancestor, Layer, Learned, PolicyTable
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import Result, read, write
from warpmuscle.scene import Scene
from warpmuscle.scene.norms import REFERENCES, STANCE
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.people.pinzone_two import SEARCHED_MOMENTS
from warpmuscle.search.cma import CmaSearch
from warpmuscle.simulation.perturbations import Perturbations

SPEEDS = (1.25, 0.9, 1.6)  # m/s, told as far as it has learnt them; stance and force are of the first one
PUSHES = 1  # walks that are pushed, at `PUSHED` s and the first speed
DURATION, PUSHED = 10.0, 4.0  # s
NARROW, WIDE = REFERENCES["step width"].low, REFERENCES["step width"].high  # m, of people's steps
TOUCHING = 0.3  # cm, that bodies may be inside each other
WIDEST = 0.5  # that is added to an action at most
ENERGY, ANGLES, FORCE, SUPPORT, WIDTH, INSIDE, SIZE, FALL = 4.0, 8.0, 0.5, 0.6, 20.0, 2.0, 1.0, 40.0  # of `Walked.cost`
MOMENTS = "moments from people that may be searched with"


@dataclass(frozen=True)
class Aims:
    """What is asked of a candidate besides."""

    push: float  # N s, from the side
    moments: float  # weight of the distance of moments, SD; 0: they do not count


def moments_away(motion: Recording, scene: Scene) -> float:
    """How far moments of hips, knees and ankles are from people's in the mean, SD."""
    weight = body_weight(scene)
    cycles = {side: strides(motion, side, weight=weight) for side in SIDES}
    moments = leg_moments(motion, scene).items()
    away = [from_people(name, mean_curves(motion, sides, cycles), SEARCHED_MOMENTS) for name, sides in moments]
    return float(np.mean(away))


@dataclass(frozen=True)
class Walked:
    """What a candidate's walks came to."""

    measures: tuple[Measures | None, ...]  # at `SPEEDS`; None of those that fell or took no steps
    lasted: float  # share of the time of all its walks
    moments: float = 0.0  # weight of the distance of moments, SD

    @property
    def cost(self) -> float:
        """The less, the better: energy, angles, force, stance and the width of steps."""
        found = [one for one in self.measures if one is not None]
        if len(found) < len(self.measures) or self.lasted < 1.0:
            return FALL * (2.0 - self.lasted)
        first = found[0]
        return (
            ENERGY * _mean(found, "cost of transport") + ANGLES * _mean(found, "angles from key points")
            + FORCE * _number(first, "deviation of the ground force") + SUPPORT * abs(_number(first, "stance") - STANCE)
            + (self.moments * _number(first, MOMENTS) if self.moments else 0.0)
            + WIDTH * float(np.mean([_beyond(_number(one, "step width")) for one in found]))
            + INSIDE * max(max(one.get("bodies inside each other") or 0.0 for one in found) - TOUCHING, 0.0)
        )  # fmt: skip


class Tuner:
    """Walks of a policy whose actions are changed."""

    def __init__(
        self, learned: Learned, scene: Scene, device: str | None, threads: int | None, aims: Aims,
    ) -> None:  # fmt: skip
        """Prepare; `groups` are numbers of actions that change together, `device` is what it runs on."""
        self._aims = aims
        self.policy, self._device, self._threads = learned.policy, device, threads
        task = undisturbed(task_of(learned))
        self._task = msgspec.structs.replace(task, command_time=0.0, episode_time=None)
        self._scene = msgspec.structs.replace(scene, duration=DURATION, learning=None)
        self._numeric = at_start(self._scene)
        self._gait = None
        batch = self._player(1).batch
        self.device, images = str(batch.device), batch.images
        others = range(len(self.policy.action)) if images is None else images.action.place
        self.groups = [tuple({k, int(other)}) for k, other in enumerate(others) if k <= int(other)]

    def _player(self, walks: int) -> Player:
        player = Player(
            self.policy, self._scene, walks, self._device, self._task, record=range(walks), record_rate=200.0,
            threads=self._threads, gait=self._gait,
        )  # fmt: skip
        self._gait = player.batch.gait
        return player

    def shifts(self, changes: np.ndarray) -> np.ndarray:
        """What is added to actions (n, actions), of what is added to groups (n, groups)."""
        found = np.zeros((len(changes), len(self.policy.action)), dtype=np.float32)
        for number, group in enumerate(self.groups):
            found[:, list(group)] = changes[:, number, None]
        return found

    def walk(self, changes: np.ndarray) -> list[Walked]:
        """Walks with these changes (n, groups)."""
        each = len(SPEEDS) + PUSHES
        n = len(changes) * each
        known = np.clip(SPEEDS, *self._task.speed)
        speeds = np.tile([*known, *[known[0]] * PUSHES], len(changes))
        pushed = (self._aims.push, 0.0, 0.0)
        pushes = np.tile([*[(0.0, 0.0, 0.0)] * len(SPEEDS), *[pushed] * PUSHES], (len(changes), 1))
        conditions = Perturbations(np.zeros((n, 3)), pushes, np.full(n, PUSHED), np.zeros(n))
        player, shifts = self._player(n), self.shifts(changes).repeat(each, axis=0)
        batch = player.batch

        def act(observation: object) -> None:
            batch.actions.requested.assign(actions_of(self.policy, batch.senses.observation.numpy(), shifts))

        player.act = act
        _, ended = player.walk(conditions, {"speed": speeds})
        lasted = np.minimum(ended / (DURATION - 0.5 * batch.dt), 1.0).reshape(-1, each)
        walks = []
        for number, shares in enumerate(lasted):
            motions = [
                batch.rollout.recording(number * each + k) if shares[k] == 1.0 else None for k in range(len(SPEEDS))
            ]
            walks.append(Walked(tuple(map(self._measured, motions)), float(shares.mean()), self._aims.moments))
        return walks

    def _measured(self, motion: Recording | None) -> Measures | None:
        try:
            if motion is None:
                return None
            found = gait_measures(motion, self._numeric)
            return {**found, MOMENTS: moments_away(motion, self._numeric)} if self._aims.moments else found
        except Error:  # no whole cycle
            return None

    def changed(self, change: np.ndarray) -> PolicyTable:
        """The policy with a change (groups,) in its last layer."""
        *others, last = self.policy.layers
        return replace(self.policy, layers=(*others, Layer(last.weight, last.bias + self.shifts(change[None])[0])))


def tune(
    source: Path, output: Path, generations: int, population: int, sigma: float, seed: int, device: str | None,
    threads: int | None, aims: Aims,
) -> None:  # fmt: skip
    """Search, tell of every generation, and write the best policy."""
    begin = time.monotonic()
    if not output.resolve().parent.is_dir():
        raise Error(f"{output}: there is no such folder")
    result = read(source)
    if result.learned is None:
        raise SystemExit(f"{source}: holds no policy")
    learned, scene = result.learned, toml.loads(result.scene)
    tuner = Tuner(learned, scene, device, threads, aims)
    none = np.zeros(len(tuner.groups))
    best, walked = none, tuner.walk(none[None])[0]
    least = walked.cost
    print(f"{len(none)} numbers; as it is: {_told(least, walked)}", flush=True)
    search = CmaSearch(0.5 + none, seed, population=population, sigma=sigma)
    rows = []
    ended = "all generations are done"
    try:
        for generation in range(1, generations + 1):
            changes = WIDEST * (2.0 * search.ask() - 1.0)
            walks = tuner.walk(changes)
            costs = np.array([one.cost for one in walks]) + SIZE * np.sum(changes**2, axis=1)
            search.tell(costs)
            k = int(np.argmin(costs))
            if costs[k] < least:
                best, least, walked = changes[k], float(costs[k]), walks[k]
            passed = time.monotonic() - begin
            print(
                f"{generation:3d} {passed:5.0f} s, median {np.median(costs):.3f}; best {_told(least, walked)}",
                flush=True,
            )
            rows.append(_row(generation, population, passed, walks, least, learned))
    except KeyboardInterrupt:  # what was found is kept
        ended = "interrupted"
    command = shlex.join(["python", *sys.argv])
    itself = Ancestor(source.name, result.seed, learned.decisions, result.command)
    options = {
        "generations": generations, "population": population, "sigma": sigma, "push": aims.push,
        "moments": aims.moments,
    }  # fmt: skip
    tuned = Learned(
        tuner.changed(best), learned.task, {name: np.array([row[name] for row in rows]) for name in CURVE}, options,
        ended, learned.critic, (itself, *learned.ancestors),
    )  # fmt: skip
    motion, _ = replay(tuned.policy, scene, device, task_of(learned))
    write(
        output, Result(result.scene, tuner.device, command, seed, result.parameters, learned=tuned, replays=(motion,))
    )
    names = [tuner.policy.action[group[0]] for group in tuner.groups]
    print("added:", ", ".join(f"{name} {change:+.3f}" for name, change in zip(names, best, strict=True)))


def _row(
    generation: int, population: int, passed: float, walks: list[Walked], least: float, learned: Learned
) -> dict[str, float]:
    """Of a learning curve; most of what only learning has is 0."""
    each = (len(SPEEDS) + PUSHES) * DURATION / task_of(learned).decision_time
    kept = {name: float(learned.curve[name][-1]) for name in ("learning_rate", "deviation")}  # for who learns from it
    lasted = np.array([one.lasted for one in walks])
    speeds = [_number(measures, "speed") for one in walks for measures in one.measures if measures is not None]
    return dict.fromkeys(CURVE, 0.0) | {
        "iteration": float(generation), "decisions": float(generation * population * each), "wall_time": passed,
        "episodes": float(len(walks) * (len(SPEEDS) + PUSHES)), "completed": float((lasted == 1.0).mean()),
        "upright": float(lasted.mean() * DURATION), "gain": -least, "speed": float(np.mean(speeds)) if speeds else 0.0,
    } | kept  # fmt: skip


def _told(cost: float, walked: Walked) -> str:
    first = walked.measures[0]
    if first is None:
        return f"{cost:.3f}, falls"
    names = ("stance", "cost of transport", "angles from key points", "deviation of the ground force", "speed")
    return f"{cost:.3f}: " + ", ".join(f"{name} {_number(first, name):.3f}" for name in names)


def _number(measures: Measures, name: str) -> float:
    value = measures.get(name)
    return float("inf") if value is None else value


def _beyond(width: float) -> float:
    """How much a step is narrower or wider than people's, m."""
    return max(width - WIDE, NARROW - width, 0.0)


def _mean(every: list[Measures], name: str) -> float:
    return float(np.mean([_number(one, name) for one in every]))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("--output", "-o", type=Path, required=True)
    parser.add_argument("--generations", type=int, default=22)
    parser.add_argument("--population", type=int, default=14)
    parser.add_argument("--sigma", type=float, default=0.05, help="of the cube whose edge is twice the widest change")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--push", type=float, default=70.0, help="N s, from the side, that it is to survive")
    parser.add_argument(
        "--moments", type=float, default=0.0, help="weight of the distance of moments from people's, SD"
    )
    parser.add_argument("--device")
    parser.add_argument("--threads", type=int)
    given = parser.parse_args()
    try:
        tune(
            given.source, given.output, given.generations, given.population, given.sigma, given.seed, given.device,
            given.threads, Aims(given.push, given.moments),
        )  # fmt: skip
    except Error as error:
        raise SystemExit(f"error: {error}") from None
