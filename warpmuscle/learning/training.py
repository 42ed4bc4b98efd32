"""Trains a policy for a scene, keeps what it has learnt on the disk, and goes on after a kill."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from warpmuscle.core.arguments import as_integer, as_number, as_path
from warpmuscle.core.errors import Error, ResultError, RolloutError
from warpmuscle.formats import SceneLike, scene_of, toml
from warpmuscle.learning.env import RolloutEnv
from warpmuscle.learning.evaluation import Evaluation, evaluate
from warpmuscle.learning.learner import Learner
from warpmuscle.learning.options import PPOOptions, options_of
from warpmuscle.learning.player import replay, task_of, text_of
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.learning.training_loop import Ends, Tell, TrainingLoop
from warpmuscle.learning.warm_start import check_fit, options_from, source_in
from warpmuscle.results.checkpoint import remove_leftovers
from warpmuscle.results.learned import Learned
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import write
from warpmuscle.results.training_file import Arrays, check_belongs, locked, read_training, training_path, write_training
from warpmuscle.scene import Scene
from warpmuscle.scene.joints.symmetry import is_symmetric
from warpmuscle.scene.learning import Task, Variation
from warpmuscle.scene.parameters import at_start, free_parameters
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.kernel_cache import progress_said

ON_GPU, ON_CPU = 4096, 64  # instances, by default
STARTS = 128  # states of a gait, by default
INTERVAL = 20.0  # s of wall time between two checkpoints
LARGEST_SEED = 2**31 - 1


@dataclass(frozen=True)
class Trained:
    """What a training has led to."""

    result: Result
    evaluation: Evaluation


def learn(
    scene: SceneLike,
    output: str | Path | None = None,
    *,
    task: Task | None = None,
    options: PPOOptions | Mapping[str, Any] | None = None,
    source: str | Path | None = None,
    seed: int = 1,
    device: str | None = None,
    iterations: int | None = None,
    until: float | None = None,
    target: float | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    interval: float = INTERVAL,
    trust: bool = False,
) -> Trained:
    """Train a policy by proximal policy optimisation.

    Args:
        scene: what it moves. output: HDF5 file to write and to replace; the state of the training lies beside it, from
            which `resume` goes on.
        task: what it learns, by default `usual_task`. seed: of all that is drawn.
        options: of the training, all of them, or some by their names.
        source: result file of a policy to begin with, by default with noise. Options that are not given by name are
            then as that policy is: its hidden layers, and noise and learning rate at the end of its training.
        device, threads: as of `Rollout`.
        iterations: after which to end. until: s of wall time after which to end. By default neither ends it.
        target: share of the instances that must last their whole time at the wanted speed for the training to end.
        command: put into the result. progress: is told of every iteration.
        interval: s of wall time between two checkpoints.
        trust: as of `load`.

    Raises:
        SceneError, RolloutError: as `RolloutEnv`, or the policy to begin with has learnt to observe or move something
            else.
        ResultError: a file cannot be read or written, is both `source` and `output`, or there is an unfinished training
            of that name.
        Error: nothing ends the training, or an option is impossible.
    """
    scene = scene_of(scene, trust=trust)
    ends = _checked_ends(iterations, until, target)
    seed = as_integer(seed, "seed", 0, LARGEST_SEED)
    values = msgspec.structs.asdict(options) if isinstance(options, PPOOptions) else dict(options or {})
    values = {"instances": usual_instances(device)} | values
    path = None if output is None else as_path(output, "output")
    if path is not None:
        _check_free(path)
    begun = None
    if source is not None:
        source = as_path(source, "source")
        if path is not None:
            _check_other(source, path)
        begun = source_in(source)
    with nullcontext() if path is None else locked(path), _said(progress) as tell:
        training = Training(
            scene, task or usual_task(scene), options_of(values) if begun is None else options_from(begun, values),
            seed, device, ends, threads, command, tell, interval, begun,
        )  # fmt: skip
        return training.run(path)


def _said(progress: Tell | None) -> AbstractContextManager[Tell | None]:
    return progress_said(progress, "preparing to learn", TrainingProgress.in_words)


def usual_task(scene: Scene) -> Task:
    """What is learnt in a scene: what it says, or to walk at 1.2 m/s from states of its controller's own gait."""
    if scene.learning is not None:
        return scene.learning
    starts = STARTS if scene.simbicon is not None else 0
    even = is_symmetric(at_start(scene).character)
    return Task(symmetric=even, variation=Variation(start_states=starts, start_after=0.0))


def usual_instances(device: str | None) -> int:
    """How many instances learn together on a device where nothing else is said; raises RolloutError."""
    return ON_CPU if find_device(device).is_cpu else ON_GPU


def resume(
    path: str | Path,
    *,
    device: str | None = None,
    iterations: int | None = None,
    until: float | None = None,
    target: float | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    interval: float = INTERVAL,
) -> Trained:
    """Go on with a training that was interrupted, killed, or has come to its end, as if it had not been.

    Args:
        path: result file of `learn(output=...)`, beside which the state of the training must lie.
        device: by default that of the file. Others: as of `learn`; by default those that the training began with, of
            which `until` counts from now.

    Raises:
        ResultError: a file cannot be read or written, or holds no training. Error: as of `learn`.
    """
    path = as_path(path, "path")
    file = training_path(path)
    if not file.exists():
        raise ResultError(f"{path}: there is no training to go on with: {file} is missing")
    with locked(path), _said(progress) as tell:
        return _gone_on(path, file, device, iterations, until, target, threads, command, tell, interval)


def _gone_on(
    path: Path, file: Path, device: str | None, iterations: int | None, until: float | None, target: float | None,
    threads: int | None, command: str, progress: Tell | None, interval: float,
) -> Trained:  # fmt: skip
    """See `resume`; no other process is at work on these files."""
    earlier, state = read_training(file)
    check_belongs(path, earlier)
    remove_leftovers(path)
    remove_leftovers(file)
    assert earlier.learned is not None
    known = dict(earlier.learned.options)
    before = {name: known.pop(name, None) for name in ("iterations", "until", "target")}
    if iterations is None and until is None and target is None:
        iterations, until, target = before["iterations"], before["until"], before["target"]
    ends = _checked_ends(iterations, until, target)
    try:
        options, task = options_of(known), task_of(earlier.learned)
    except ResultError:
        raise
    except Error as error:
        raise ResultError(f"{file}: damaged training: {error}") from None
    commands = "\n".join(filter(None, (earlier.command, command)))
    training = Training(
        toml.loads(earlier.scene, name=f"{file}, its scene"), task, options, earlier.seed, device or earlier.device,
        ends, threads, commands, progress, interval,
    )  # fmt: skip
    try:
        training.go_on(earlier.learned, state)
    except (ValueError, RolloutError) as error:
        raise ResultError(f"{file}: damaged training: {error}") from None
    return training.run(path)


class Training:
    """A policy that is trained for a scene."""

    def __init__(
        self, scene: Scene, task: Task, options: PPOOptions, seed: int, device: str | None, ends: Ends,
        threads: int | None, command: str, progress: Tell | None, interval: float, source: Learned | None = None,
    ) -> None:  # fmt: skip
        """Prepare; compiles what is to be compiled."""
        if progress is not None:
            progress(TrainingProgress(0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, compiling=True))
        self.scene, self.task, self.options, self.seed = scene, task, options, seed
        self._ends, self._threads, self._command, self._tell = ends, threads, command, progress
        self.env = RolloutEnv(scene, options.instances, device, self.task, seed, threads=threads)
        self.device = str(self.env.batch.device)
        if source is not None:
            check_fit(source, self.env, self.task)
        self.ancestors = () if source is None else source.ancestors
        self.learner = Learner(self.env, options, seed, source=source)
        self.loop = TrainingLoop(self.learner, ends, interval, progress)
        self._evaluation: Evaluation | None = None

    def go_on(self, learned: Learned, state: Arrays) -> None:
        """Take over what was learnt before; raises ValueError or RolloutError if it is of another training."""
        self.learner.restore(state)
        self.loop.go_on(learned)
        self.ancestors = learned.ancestors

    def run(self, path: Path | None) -> Trained:
        """Learn until an end, and write what was learnt to a path, if there is one; raises ResultError."""
        if path is not None:
            self._keep(path)
        self.loop.run(lambda: self._keep(path), self._meets_target)
        evaluation = self._evaluation or self.evaluate()
        result = self.result()
        assert result.learned is not None
        recording, _ = replay(result.learned.policy, self.scene, self.device, self.task, self.seed)
        result = replace(result, replays=(recording,))
        if path is not None:
            write_training(training_path(path), self.result(), self.learner.state())
            write(path, result)
        return Trained(result, evaluation)

    def evaluate(self) -> Evaluation:
        """How the policy does as it is now, in as many instances as learn."""
        self.loop.tell_trying()
        n = self.options.instances
        return evaluate(self.learner.policy(), self.scene, n, self.device, self.task, threads=self._threads)

    def result(self) -> Result:
        """All that is known now, without a motion."""
        ends = {name: value for name, value in asdict(self._ends).items() if value is not None}
        options = msgspec.structs.asdict(self.options) | ends
        policy = replace(self.learner.policy(), gait=self.env.batch.kept_gait)
        learned = Learned(
            policy, text_of(self.task), self.loop.curve(), options, self.loop.ended,
            self.learner.critic(), self.ancestors,
        )  # fmt: skip
        table = parameter_table(free_parameters(self.scene))
        return Result(toml.dumps(self.scene), self.device, self._command, self.seed, table, learned=learned)

    def _keep(self, path: Path | None) -> None:
        if path is not None:
            result = self.result()
            write_training(training_path(path), result, self.learner.state())
            write(path, result)

    def _meets_target(self) -> bool:
        begin = time.monotonic()
        found = self.evaluate()
        assert self._ends.target is not None
        if found.arrived >= self._ends.target:
            self._evaluation = found
            return True
        self.loop.tried(time.monotonic() - begin)
        return False


def _checked_ends(iterations: int | None, until: float | None, target: float | None) -> Ends:
    """What a training ends at; raises Error for what is impossible, or nothing."""
    if iterations is None and until is None and target is None:
        raise Error("a training needs an end: iterations, until (a wall time) or target (a share that walks)")
    return Ends(
        None if iterations is None else as_integer(iterations, "iterations"),
        None if until is None else as_number(until, "until", above=0.0),
        None if target is None else as_number(target, "target", least=0.0, most=1.0),
    )


def _check_other(source: Path, path: Path) -> None:
    """Raise ResultError if what is to be written would replace the policy to begin with."""
    for written in (path, training_path(path)):
        if written.exists() and source.exists() and written.samefile(source):
            raise ResultError(f"{path}: would replace the policy to begin with; write to another file")


def _check_free(path: Path) -> None:
    """Raise ResultError if a file's training was killed, so that it may be gone on with."""
    file = training_path(path)
    if not file.exists():
        return
    try:
        learned = read_training(file)[0].learned
    except ResultError:
        return  # nothing that could be gone on with
    if learned is not None and not learned.ended:
        raise ResultError(
            f"{path}: an unfinished training; continue it with --resume {path}, or remove {file} to begin anew"
        )
