"""Runs of a sweep side by side, from their first candidates to their files, with as little beside as can be.

As many as a window holds begin together, ask for a generation each, and wait until the batches of all have run; what
was evaluated goes into one journal (see `rounds.py`). Once all have ended, their best candidates are replayed in a
batch, too, and each run gets its file. What scenes have in common is found once, and not once a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.formats import toml
from warpmuscle.optimization.options import MakeBatches
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.optimization.replay import Replay
from warpmuscle.optimization.run import make_search_loop
from warpmuscle.optimization.search_loop import INTERRUPTED, SearchLoop
from warpmuscle.results.brief import ALL, brief
from warpmuscle.results.records import ParameterTable, Result, best_of, parameter_table
from warpmuscle.results.result_templates import Stamps
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.finished import FinishedJournal
from warpmuscle.sweep.folder import RunState
from warpmuscle.sweep.pruning.rule import Rule
from warpmuscle.sweep.pruning.scheduler import Referee
from warpmuscle.sweep.rounds import Known, Rounds
from warpmuscle.sweep.shared_batches import SharedBatches
from warpmuscle.sweep.task import Task
from warpmuscle.sweep.union import MergedScene, groups, searched_scenes, unchanged, weighed_scenes

LEAST_WINDOW, MOST_WINDOW = 64, 2048  # runs side by side
SHARE_OF_BATCH = 16  # candidates of a run in a batch, about, for the window to fill it
REPLAY_BYTES = 2**27  # of the recorded motion of a batch of best candidates
REPLAY_BYTES_OF_GPU = 2**30  # which takes as long for a thousand of them as for a hundred
Tell = Callable[[str, Progress], None]
Finished = Callable[[RunState], None]


@dataclass(frozen=True)
class Pruning:
    """Who competes with whom, and costs of rivals that have ended earlier, by what they have in common."""

    rule: Rule
    ended: Mapping[str, Sequence[Floats]]


@dataclass(frozen=True)
class _Prepared:
    """What all runs of a scene have in common."""

    scene: Scene  # as it is searched
    text: str
    parameters: ParameterTable


def run_in_lockstep(
    tasks: Sequence[Task], folder: Path, known: dict[str, Known], device: str | None, threads: int | None,
    tell: Tell | None, finished: Finished | None = None, pruning: Pruning | None = None,
) -> dict[str, str]:  # fmt: skip
    """Run optimisations without stages that have no files yet, those of one kind side by side.

    Args:
        folder: for their files. known: what earlier processes have evaluated, by name of the run.
        device, threads: see `make_rollout`. tell: called several times a second of work.
        finished: gets what each run has come to, once it has its file.
        pruning: who competes with whom; by default nobody does.

    Returns:
        Why those that failed did, by name.

    Raises:
        KeyboardInterrupt: what was evaluated is in the journal.
    """
    given = list({id(task.scene): task.scene for task in tasks}.values())
    weighed = weighed_scenes(given)
    with unchanged(scene for scene in weighed if isinstance(scene, Scene)):
        found = searched_scenes(weighed)
        wrong = {id(scene): str(own) for scene, own in zip(given, found, strict=True) if isinstance(own, Error)}
        keys = [id(scene) for scene in given if id(scene) not in wrong]
        scenes = [own for own in found if isinstance(own, Scene)]
        failed = {task.name: wrong[id(task.scene)] for task in tasks if id(task.scene) in wrong}
        with unchanged(scenes):
            for group in groups(scenes):
                index = {keys[number]: place for place, number in enumerate(group)}
                mine = [task for task in tasks if id(task.scene) in index]
                try:
                    prepared = [_prepared(scenes[number]) for number in group]
                    engine = _Group(prepared, folder, device, threads, tell, finished)
                except Error as error:  # such as of a gait to track that cannot be read
                    failed |= {task.name: str(error) for task in mine}
                    continue
                failed |= engine.run(mine, [index[id(task.scene)] for task in mine], known, pruning)
    return failed


def _prepared(scene: Scene) -> _Prepared:
    """What runs of a scene have in common, which is as it is searched."""
    return _Prepared(scene, toml.dumps(scene), parameter_table(free_parameters(scene)))


class _Group:
    """Scenes of one kind, and what simulates them."""

    def __init__(
        self, prepared: Sequence[_Prepared], folder: Path, device: str | None, threads: int | None, tell: Tell | None,
        finished: Finished | None,
    ) -> None:  # fmt: skip
        self._prepared, self._folder, self._tell, self._finished = prepared, folder, tell, finished
        self._rounds, self._stamps, self._journal = Rounds(folder), Stamps(), FinishedJournal(folder)
        report = None if tell is None else partial(tell, "")
        scenes = [one.scene for one in prepared]
        self._batches = SharedBatches(scenes, device, threads, report, self._rounds.keep)
        self._replays = _Replays(self._batches.union, device, threads)
        self._window = min(max(self._batches.largest // SHARE_OF_BATCH, LEAST_WINDOW), MOST_WINDOW)

    def run(
        self, tasks: Sequence[Task], scenes: Sequence[int], known: dict[str, Known], pruning: Pruning | None = None
    ) -> dict[str, str]:
        """Run all tasks, window by window; `scenes` are the numbers of their scenes. Why some failed, by name."""
        failed: dict[str, str] = {}
        for part in windows([task.rivals for task in tasks], self._window):
            chosen = [(tasks[number], scenes[number]) for number in part]
            runs = [
                _Run(task, self._prepared[index], index, known.get(task.name), self._tell) for task, index in chosen
            ]
            failed |= self._side_by_side(runs, pruning)
        return failed

    def _side_by_side(self, runs: Sequence[_Run], pruning: Pruning | None) -> dict[str, str]:
        """Run these from their first candidate to their files."""
        self._rounds.names = [run.task.name for run in runs]
        judge = None if pruning is None else Referee(pruning.rule, runs, pruning.ended).judge
        errors = self._batches.run([(run.index, run.search) for run in runs], judge)
        failed = {run.task.name: str(error) for run, error in zip(runs, errors, strict=True) if error is not None}
        ended = []
        for run in runs:
            if run.task.name not in failed:
                result = run.result() if run.task.keep == ALL else brief(run.result())
                if result.best is None:
                    failed[run.task.name] = f"{run.ended} before any candidate had ended: nothing to keep"
                else:
                    ended.append((run, result))
        values = [(run.index, np.asarray(result.best.params)) for run, result in ended if result.best is not None]
        for (run, result), replay in zip(ended, self._replays.of(values), strict=True):
            try:
                content = self._stamps.image(replace(result, replays=(replay[0],), parts=replay[1]))
                replace_file(self._folder / f"{run.task.name}.h5", content, synchronised=False)
                if self._finished is not None and result.best is not None and result.evaluations is not None:
                    count, asked = result.evaluated, run.task.options.candidates
                    self._finished(RunState(run.task.name, True, run.ended, count, asked, result.best.cost))
            except SceneError as error:
                failed[run.task.name] = str(error)
            except Error as error:
                failed[run.task.name] = f"{self._folder / run.task.name}.h5: {error}"
        self._journal.keep(
            [(name, path, result) for run, result in ended
             if (name := run.task.name) not in failed and (path := self._folder / f"{name}.h5").exists()]
        )  # fmt: skip
        if not failed:
            self._rounds.clear()
        return failed


def windows(rivals: Sequence[str], size: int) -> list[list[int]]:
    """Numbers of runs that go side by side, about so many at once; those that compete always do."""
    groups: dict[str, list[int]] = {}
    for number, key in enumerate(rivals):
        groups.setdefault(key or f"#{number}", []).append(number)
    found: list[list[int]] = []
    for members in groups.values():
        if not found or len(found[-1]) + len(members) > size:
            found.append([])
        found[-1] += members
    return found


class _Run:
    """One optimisation."""

    def __init__(self, task: Task, prepared: _Prepared, index: int, known: Known | None, tell: Tell | None) -> None:
        self.task, self.index, self.ended = task, index, ""
        self._prepared, self._known, self._tell = prepared, known, tell
        self._loop: SearchLoop | None = None
        self.rivals, self.candidates = task.rivals, task.options.candidates

    @property
    def done(self) -> int:
        """Candidates so far."""
        return 0 if self._loop is None else self._loop.tracker.done

    def costs(self) -> Floats:
        """Costs of its candidates so far, in order."""
        return np.zeros(0) if self._loop is None else self._loop.evaluations().cost

    def stop(self, reason: str) -> None:
        """Let it end before its next candidates."""
        assert self._loop is not None
        self._loop.tracker.stopped = reason

    def search(self, batches: MakeBatches) -> None:
        """Search from the first candidate to the end; KeyboardInterrupt if that has ended it."""
        task, scene = self.task, self._prepared.scene
        known = {} if self._known is None else self._known.generations
        elsewhere = max(known, default=-1) + 1 if self._known is not None and self._known.elsewhere else 0
        tell = None if self._tell is None else partial(self._tell, task.name)
        tracker = Tracker(task.options.candidates, task.options.until, tell)
        loop = make_search_loop(scene, task.seed, task.options, (), batches, tracker, known, elsewhere=elsewhere)
        assert isinstance(loop, SearchLoop)
        self._loop = loop
        self.ended = loop.run(lambda generation: None)
        if self.ended == INTERRUPTED:
            raise KeyboardInterrupt

    def result(self) -> Result:
        """All but the motion."""
        assert self._loop is not None
        loop, evaluations = self._loop, self._loop.evaluations()
        return Result(
            self._prepared.text, loop.device, self.task.command, self.task.seed, self._prepared.parameters,
            evaluations, best_of(evaluations), searched=loop.searched(self.ended),
        )  # fmt: skip


class _Replays:
    """Motions of the best candidates of runs, many in a batch."""

    def __init__(self, union: MergedScene, device: str | None, threads: int | None) -> None:
        found = find_devices(device)[0]
        self._union, self._device, self._threads = union, str(found), threads
        self._bytes = REPLAY_BYTES if found.is_cpu else REPLAY_BYTES_OF_GPU
        self._rollout: Rollout | None = None

    def of(self, values: Sequence[tuple[int, Floats]]) -> Iterator[Replay]:
        """Motions of candidates, each the number of its scene and its parameters, in order."""
        if not values:
            return
        rollout = self._made(len(values))
        rows = np.concatenate([self._union.values(index, own[None]) for index, own in values])
        for begin in range(0, len(rows), rollout.instances):
            part = rows[begin : begin + rollout.instances]
            rollout.set_parameters(part[np.minimum(np.arange(rollout.instances), len(part) - 1)])
            rollout.run()
            for instance, motion in enumerate(rollout.recordings(range(len(part)))):
                yield motion, rollout.parts(instance)

    def _made(self, wanted: int) -> Rollout:
        """A batch that records as many as fit."""
        if self._rollout is None:
            one = Rollout(self._union.scene, 1, self._device, record=[0], threads=self._threads)
            count = max(min(wanted, self._bytes // max(one.recording_bytes, 1)), 1)
            self._rollout = one
            if count > 1:
                self._rollout = Rollout(
                    self._union.scene, count, self._device, record=range(count), threads=self._threads
                )
            self._rollout.load()
        return self._rollout
