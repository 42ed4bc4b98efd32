"""Instances that a learnt policy moves; PyTorch is not needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error, ResultError, RolloutError, SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import Status
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.learning.episodes import EpisodeBatch
from warpmuscle.learning.imitation import Gait
from warpmuscle.learning.policy import DevicePolicy
from warpmuscle.results.learned import Learned, PolicyTable
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read_learned
from warpmuscle.scene import Scene
from warpmuscle.scene.controller import Command
from warpmuscle.scene.joints.symmetry import is_symmetric
from warpmuscle.scene.learning import Task, Variation
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.checks import check_ranges
from warpmuscle.simulation.perturbations import Perturbations

UNITS = {"speed": "m/s", "turning_rate": "rad/s"}  # of commands


class Player:
    """A batch whose decisions a policy makes.

    The same policy, scene, task and seed give an instance the same motion to the bit, wherever it is in whatever batch,
    on the same kind of device.

    Attributes:
        batch: the episodes. act: puts actions for an observation where the batch takes them from.
    """

    def __init__(
        self,
        policy: PolicyTable,
        scene: SceneLike,
        instances: int = 1,
        device: str | None = None,
        task: Task | None = None,
        seed: int = 0,
        *,
        record: Sequence[int] = (),
        record_rate: float = 100.0,
        threads: int | None = None,
        gait: Gait | None = None,
    ) -> None:
        """Prepare and begin all episodes.

        Args:
            policy: as a result file has it. Others: as of `EpisodeBatch`.

        Raises:
            SceneError, RolloutError: as of `EpisodeBatch`, or the policy is for another scene or task.
        """
        scene = scene_of(scene)
        task = in_full(of_body(task, scene) or scene.learning)
        try:
            self.batch = EpisodeBatch(
                scene, instances, device, task, seed, record=record, record_rate=record_rate, threads=threads,
                gait=gait, kept_gait=policy.gait,
            )  # fmt: skip
        except SceneError as error:
            if not error.key.startswith("learning.") or policy.scene in ("", scene.name):
                raise
            raise RolloutError(f"{_foreign(policy, scene)}: {error}") from None
        for does, learnt, found in (
            ("observes", policy.observation, tuple(self.batch.senses.names)),
            ("moves", policy.action, self.batch.actions.names),
        ):
            if learnt != found:
                raise RolloutError(f"{_foreign(policy, scene)}: it {does} {_other(learnt, found)}")
        self.act: Callable[[wp.array], object] = DevicePolicy(
            policy, instances, self.batch.device, self.batch.actions.requested
        ).act

    def walk(self, disturbances: Perturbations, commands: Mapping[str, ArrayLike]) -> tuple[Integers, Floats]:
        """Act in one episode of each instance, from the scene's initial state.

        Args:
            disturbances, commands: as of `EpisodeBatch.begin_under`.

        Returns:
            How they ended, (instances,), see `Status`, and when, s.
        """
        batch, state = self.batch, self.batch.rollout.state
        batch.begin_under(disturbances, commands)
        status = state.status.numpy().copy()
        ended = np.zeros(len(status), dtype=np.int32)
        for _ in range(min(batch.longest, batch.rollout.steps // batch.decision_steps)):
            self.decide(restart=False)
            running = status == Status.RUNNING  # a body that has failed may be moved on, but stays a failure
            status[running], ended[running] = state.status.numpy()[running], state.step.numpy()[running]
            if not (status == Status.RUNNING).any():
                break
        return np.where(status == Status.RUNNING, Status.COMPLETED, status), ended * batch.scene.time_step

    def decide(self, restart: bool = True) -> None:
        """Make a decision in every instance; where an episode ends, the next one begins, unless it is not to."""
        self.act(self.batch.senses.observation)
        self.batch.step(restart)


def _foreign(policy: PolicyTable, scene: Scene) -> str:
    """What a policy was learnt for, in words, where it does not fit a scene."""
    if policy.scene in ("", scene.name):
        return "the policy was learnt for another scene or task"
    return f"the policy was learnt for the scene {policy.scene}, not for {scene.name}"


def _other(learnt: tuple[str, ...], found: tuple[str, ...]) -> str:
    """How names that a policy has learnt differ from those that there are."""
    other = next((name for name in learnt if name not in found), None)
    if other is not None:
        return f"{other!r}, which is not there"
    return (
        f"{number_of(len(learnt), 'number')} of {len(found)}"
        if len(learnt) != len(found)
        else "the same numbers in another order"
    )


def text_of(task: Task) -> str:
    """A task as a result file keeps it."""
    return msgspec.json.encode(task).decode()


def task_of(learned: Learned) -> Task:
    """The task that a policy of a result file has learnt; raises ResultError if it is none."""
    try:
        task = msgspec.json.decode(learned.task, type=Task)
        check_ranges("learning", task)
    except (msgspec.DecodeError, ValueError, RecursionError, SceneError) as error:
        place = f"{learned.file}: " if learned.file else ""
        raise ResultError(f"{place}damaged result file: the task of its policy: {error}") from None
    return task


def learned_in(path: str | Path) -> Learned:
    """The policy of a result file; raises ResultError if it cannot be read, or holds none."""
    learned = read_learned(path)
    if learned is None:
        raise ResultError(f"{path}: holds no policy; `warpmuscle learn` makes one")
    task_of(learned)
    return learned


def commanded(task: Task, texts: Sequence[str]) -> Task:
    """The task with commands that stay, each given as KEY=VALUE: speed, m/s, turning_rate, rad/s, or a coordinate.

    Raises:
        Error: another key, or no finite number.
    """
    for key, number in commands_given(task, texts).items():
        if key in task.pose:
            task = msgspec.structs.replace(task, pose={**task.pose, key: (number, number)})
        else:
            task = msgspec.structs.replace(task, **{key: (number, number)})
        if key == "turning_rate":
            task = msgspec.structs.replace(task, turning_share=1.0)
    return msgspec.structs.replace(task, command_time=0.0) if texts else task


def commands_given(task: Task, texts: Sequence[str]) -> dict[str, float]:
    """Commands of a task, each given as KEY=VALUE; raises Error as `commanded`."""
    known, found = task.command_names, {}
    for text in texts:
        key, _, value = (part.strip() for part in text.partition("="))
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if key not in known or not math.isfinite(number):
            raise Error(f"{text!r}: write KEY=NUMBER; of this policy KEY is {', '.join(known)}")
        found[key] = number
    return found


def beyond(task: Task, texts: Sequence[str]) -> list[str]:
    """What lies outside of what a policy has learnt, of commands given as KEY=VALUE; a sentence each.

    Raises:
        Error: as `commanded`.
    """
    learnt, found = commands_of(task), []
    for name, value in commands_given(task, texts).items():
        one = learnt[name]
        if not one.min <= value <= one.max:
            range_ = f"{one.min:g} to {one.max:g}" if one.min < one.max else f"{one.min:g} alone"
            found.append(
                f"{name} = {value:g} {one.unit}: the policy has learnt {range_}; what it does is anyone's guess"
            )
    return found


def commands_of(task: Task) -> dict[str, Command]:
    """What a policy can be told, in the order of its task's commands; by default the middle of what it has learnt."""
    intervals = {"speed": task.speed, "turning_rate": task.turning_rate, **task.pose}
    return {
        name: Command(0.5 * (low + high), low, high, unit=UNITS.get(name, "rad or m"))
        for name, (low, high) in intervals.items()
    }


def of_body(task: Task | None, scene: Scene) -> Task | None:
    """The task without symmetry where the body is not its own mirror image: that is needed to learn, not to act."""
    if task is None or not task.symmetric or is_symmetric(at_start(scene).character):
        return task
    return msgspec.structs.replace(task, symmetric=False)


def in_full(task: Task | None) -> Task | None:
    """The task with all its disturbances from the first episode on."""
    if task is None or not (task.variation.growth or task.variation.push_growth):
        return task
    full = msgspec.structs.replace(task.variation, growth=0.0, push_growth=0.0)
    return msgspec.structs.replace(task, variation=full)


def lasting(task: Task) -> Task:
    """The task with episodes as long as the scene lasts, whatever they were while it was learnt."""
    return msgspec.structs.replace(task, episode_time=None)


def commands_in_words(task: Task) -> str:
    """In words, what a policy is told in an episode: numbers that stay, and those that are drawn from an interval."""
    words = []
    for name, command in commands_of(task).items():
        unit = "" if command.unit == "1" else f" {command.unit}"
        if command.min == command.max:
            words.append(f"{name} {command.min:g}{unit}")
        else:
            often = f" every {task.command_time:g} s" if task.command_time > 0.0 else " once"
            words.append(f"{name} drawn{often} from {command.min:g} to {command.max:g}{unit}")
    return ", ".join(words)


def undisturbed(task: Task) -> Task:
    """The task without anything that is drawn for its episodes' starts, without pushes and a curriculum."""
    return msgspec.structs.replace(task, variation=Variation(velocity_noise=0.0), curriculum="")


def replay(
    policy: PolicyTable,
    scene: SceneLike,
    device: str | None = None,
    task: Task | None = None,
    seed: int = 0,
    *,
    rate: float = 100.0,
) -> tuple[Recording, Status]:
    """The motion of one undisturbed episode from the scene's start, and how it ended.

    Args:
        rate: recorded frames a second. Others: as of `Player`.

    Raises:
        SceneError, RolloutError: as `Player`.
    """
    task = task if task is not None else Task()
    player = Player(policy, scene, 1, device, undisturbed(task), seed, record=[0], record_rate=rate)
    batch = player.batch
    steps = batch.rollout.steps // batch.decision_steps
    for _ in range(min(batch.longest, steps)):
        player.decide(restart=False)
        status = Status(int(batch.rollout.state.status.numpy()[0]))
        if status != Status.RUNNING:
            break
    return batch.rollout.recording(), Status.COMPLETED if status == Status.RUNNING else status
