"""A patient's path from recordings to predictions: reads, searches, goes on with each change, and measures."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.status import Status
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.gait.measures import measure
from warpmuscle.gait.muscle_effort import cost_of_transport, spent
from warpmuscle.optimization.best_scene import best_scene, recorded_scene
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read as read_result
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.sweep.board import Tell
from warpmuscle.sweep.patient.compared import (
    Changed,
    Distance,
    Walk,
    angle_distance,
    changed_numbers,
    judged_distances,
    searched_distances,
)
from warpmuscle.sweep.patient.file import UNCHANGED, PatientFile
from warpmuscle.sweep.patient.gait import gait_of
from warpmuscle.sweep.patient.plan import AXIS, Files, adapt_plan, hip_offset, match_plan, walk_plan
from warpmuscle.sweep.patient.recorded import Patient, read_patient
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.plan.runs import SweepRun
from warpmuscle.sweep.processes import in_processes
from warpmuscle.sweep.run import SweepResult, sweep

RATE = 200.0  # frames/s, of a scene as it stands


@dataclass(frozen=True)
class PathResult:
    """What a patient's path has come to."""

    asked: PatientFile
    patient: Patient
    before: Walk  # the scene in the patient's size, or if it falls the walk that was searched for first
    matched: tuple[Walk, ...]
    adapted: tuple[Walk, ...]  # without a change, and with each
    searched: tuple[Distance, ...]
    judged: tuple[Distance, ...]
    numbers: tuple[Changed, ...]
    failure: str = ""  # of searches
    as_it_stands: bool = True  # whether `before` is the scene itself

    @property
    def before_in_words(self) -> str:
        """What walks before the search, or falls."""
        return "the model before the search" if self.as_it_stands else "the model that was only made to walk"

    @property
    def distance_before(self) -> float | None:
        """Mean distance of the angles before the search, in the patient's standard deviations."""
        return None if self.before.gait is None else angle_distance(self.before.gait, self.patient)

    @property
    def distances(self) -> dict[int, float]:
        """The same of matched walks, by seed."""
        return {w.seed: angle_distance(w.gait, self.patient) for w in self.matched if w.gait is not None}

    @property
    def conditions(self) -> list[str]:
        """Names of the walks that adapted: the first without a change."""
        return [UNCHANGED, *self.asked.changes]


def follow(
    asked: PatientFile,
    page: Path,
    *,
    device: str | None = None,
    threads: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    say: Callable[[str], None] = lambda what: None,
) -> PathResult:
    """Go a patient's path, or what is left of it.

    Args:
        page: beside which, in a folder of its name, all is kept. progress: of each of the two sweeps. say: gets what is
            being done.

    Raises:
        Error: something of it cannot be used, with file, line and key; no search finds a walk.
        KeyboardInterrupt: it was interrupted; what was evaluated is kept, and the same call goes on.
    """
    files = Files(page)
    say("reading recordings")
    patient = read_patient(asked, device)
    is_new = not files.folder.exists()
    try:
        files.folder.mkdir(parents=True, exist_ok=True)
        plan = match_plan(asked, patient, files)
    except OSError as error:
        raise Error(f"{files.folder}: {error.strerror}") from None
    except Error:
        if is_new:  # nothing is kept of what cannot be used
            shutil.rmtree(files.folder, ignore_errors=True)
        raise
    stands = _as_it_stands(plan.runs[0].scene, device, threads)
    before, first = stands, None
    if not stands.walked:
        say("searching for a walk first, as the scene falls")
        way = walk_plan(asked, patient, files)
        made = sweep(way, files.of("walk.h5"), device=device, threads=threads, command=command, progress=progress)
        walk = _measured(way, made, threads)[0]
        if walk.walked:
            before, first = walk, best_scene(read_result(made.folder.result(way.runs[0].name)))[0]
    numeric = at_start(plan.runs[0].scene)
    offset = hip_offset(asked, patient, numeric, None if before.gait is None else before.gait.tilt)
    if first is not None or offset != 0.0:
        patient = patient.with_hips(offset)
        plan = match_plan(asked, patient, files, first)
    say("searching for walks like the patient's")
    done = sweep(plan, files.of("match.h5"), device=device, threads=threads, command=command, progress=progress)
    matched = _measured(plan, done, threads)
    scenes = {
        run.seed: best_scene(read_result(done.folder.result(run.name)))[0]
        for run, walk in zip(plan.runs, matched, strict=True)
        if walk.gait is not None and walk.walked
    }
    if not scenes:
        why = done.failure or next((walk.why for walk in matched if walk.why), "") or "all fell"
        remedy = "" if done.failure else "; give more `match.candidates`"
        raise Error(f"{asked.path}: no search found a walk like the patient's ({why}){remedy}")
    say("searching for walks with each change")
    changed = adapt_plan(asked, scenes, files)
    went = sweep(changed, files.of("changes.h5"), device=device, threads=threads, command=command, progress=progress)
    adapted = _measured(changed, went, threads)
    gaits = [walk for walk in matched if walk.seed in scenes]
    return PathResult(
        asked, patient, before, tuple(matched), tuple(adapted),
        tuple(searched_distances(patient, before.gait, gaits)), tuple(judged_distances(patient, before.gait, gaits)),
        tuple(changed_numbers(patient, gaits, adapted)), done.failure or went.failure, first is None,
    )  # fmt: skip


def _measured(plan: Plan, done: SweepResult, threads: int | None) -> list[Walk]:
    """The best walk of each run."""
    tasks = [(run, done.folder.result(run.name), done.failed.get(run.name, "")) for run in plan.runs]
    return list(in_processes(threads or 1, partial(_walk_of), tasks))


def _walk_of(task: tuple[SweepRun, Path, str]) -> Walk:
    run, file, failure = task
    walk = Walk(run.seed, str(run.axes.get(AXIS, "")), False, why=failure)
    if failure:
        return walk
    try:
        result = read_result(file)
    except ResultError as error:
        return replace(walk, why=str(error))
    best, evaluations = result.best, result.evaluations
    if best is None or evaluations is None or not result.replays:
        return replace(walk, why="no candidate had ended")
    status = Status(int(evaluations.status[best.index]))
    if status != Status.COMPLETED:
        return replace(walk, why=status.word)
    return _with_gait(replace(walk, walked=True), result.replays[0], recorded_scene(result))


def _with_gait(walk: Walk, motion: Recording, scene: Scene) -> Walk:
    """A walk with its gait and cost, or why there is none."""
    try:
        cycles = steady_strides(motion, scene)
        gait = measure(motion, scene)
        effort = spent(motion.window(gait.start), scene)
        cost = None if effort is None else cost_of_transport(effort.power, gait.speed_horizontal)
        return replace(walk, gait=gait_of(motion, scene, cycles, gait.speed_forward), cost=cost)
    except Error as error:
        return replace(walk, walked=False, why=str(error))


def _as_it_stands(scene: Scene, device: str | None, threads: int | None) -> Walk:
    """How a scene walks with the numbers that it begins with."""
    numeric = at_start(scene)
    rollout = make_rollout(numeric, 1, device, record=[0], record_rate=RATE, threads=threads)
    rollout.run()
    status, motion = Status(rollout.status()[0]), rollout.recording()
    if status != Status.COMPLETED:
        return Walk(0, "before", False, why=f"{status.word} after {motion.end:.1f} s")
    return _with_gait(Walk(0, "before", True), motion, numeric)
