"""Optimisation of a scene's free parameters: candidates from a search, evaluated in batches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from warpmuscle.arrays import Floats
from warpmuscle.errors import Error
from warpmuscle.formats import toml
from warpmuscle.parameters import Parameter, free_parameters, snap, start_values
from warpmuscle.recording import Recording
from warpmuscle.results import Best, Evaluations, ParameterTable, Result
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Scene
from warpmuscle.search.random import RandomSearch
from warpmuscle.status import Status

CPU_BATCH = 500  # small enough that finished candidates come in all along
GPU_BATCH = 65536


@dataclass(frozen=True)
class Progress:
    """How far an optimisation has come."""

    candidates: int  # to be evaluated in all
    done: int  # of them evaluated to their end
    alive: int  # still walking in the batch that runs now
    best: float  # least cost so far; infinite before the first candidate has ended
    simulated: float  # s of motion computed so far, summed over instances
    fraction: float  # of all the work, counting a failed candidate as done, 0..1


def optimize(
    scene: Scene,
    candidates: int = 5000,
    seed: int = 1,
    device: str | None = None,
    *,
    threads: int | None = None,
    command: str = "",
    progress: Callable[[Progress], None] | None = None,
) -> Result:
    """Evaluate candidates drawn at random within the intervals of the scene's free parameters.

    The first candidate is the scene as it is. A KeyboardInterrupt ends the search; what was evaluated by then is
    returned.

    Args:
        candidates: how many to evaluate.
        seed: of the search; the same seed gives the same result on the same kind of device.
        device: see `Rollout`. threads: CPU threads, by default one a core.
        command: put into the result as what made it.
        progress: called several times a second of work.

    Raises:
        Error: the scene has no free parameters, or the search was interrupted before any candidate had ended.
    """
    parameters = free_parameters(scene)
    if not parameters:
        raise Error(
            "this scene has no free parameters: write a number in it as { value = .., min = .., max = .., step = .. }"
        )
    if candidates < 1:
        raise Error(f"the number of candidates must be positive, not {candidates}")
    search = RandomSearch(
        start_values(scene), np.array([p.min for p in parameters]), np.array([p.max for p in parameters]), seed
    )
    evaluations, used = _evaluate(scene, parameters, search, candidates, device, threads, progress)
    if len(evaluations.cost) == 0:
        raise Error("interrupted before any candidate had ended: nothing to keep")
    index = int(np.argmin(evaluations.cost))
    best = Best(params=evaluations.params[index], cost=float(evaluations.cost[index]), index=index)
    return Result(
        scene=toml.dumps(scene),
        device=used,
        command=command,
        seed=seed,
        parameters=parameter_table(parameters),
        evaluations=evaluations,
        best=best,
        replays=(replay(scene, np.asarray(best.params, dtype=np.float64), used),),
    )


def replay(scene: Scene, values: Floats, device: str | None = None) -> Recording:
    """Motion of the scene with these parameter values, (P,): alone, and the same to the last bit as in a batch."""
    rollout = Rollout(scene, 1, device, record=[0], threads=1)
    rollout.set_parameters(values)
    rollout.run()
    return rollout.recording()


def parameter_table(parameters: list[Parameter]) -> ParameterTable:
    """Free parameters as a result file keeps them."""
    return ParameterTable(
        name=tuple(p.name for p in parameters),
        unit=tuple(p.unit for p in parameters),
        min=np.array([p.min for p in parameters]),
        max=np.array([p.max for p in parameters]),
        step=np.array([p.step for p in parameters]),
        value=np.array([p.value for p in parameters]),
    )


def _evaluate(
    scene: Scene,
    parameters: list[Parameter],
    search: RandomSearch,
    candidates: int,
    device: str | None,
    threads: int | None,
    progress: Callable[[Progress], None] | None,
) -> tuple[Evaluations, str]:
    """Evaluate in batches until all are done or the user interrupts; also the name of the device."""
    parts: list[Evaluations] = []
    now = Progress(candidates, done=0, alive=0, best=np.inf, simulated=0.0, fraction=0.0)
    rollout = Rollout(scene, 1, device, threads=threads)
    name, largest = str(rollout.device), CPU_BATCH if rollout.device.is_cpu else GPU_BATCH
    try:
        if progress is not None:
            progress(now)
        while now.done < candidates:
            count = min(largest, candidates - now.done)
            values = snap(parameters, search.ask(count))
            if now.done == 0:
                values[0] = start_values(scene)  # the scene as it is, also where it lies between the steps
            if rollout.instances != count:
                rollout = Rollout(scene, count, name, threads=threads)
            rollout.set_parameters(values)

            def report(batch: Rollout, before: Progress = now) -> None:
                if progress is not None:
                    progress(_progress(batch, before))

            try:
                rollout.run(progress=report)
            finally:
                parts.append(_ended(rollout, values))
            search.tell(values, rollout.cost())
            now = _progress(rollout, now)
    except KeyboardInterrupt:
        pass
    return _joined(parts, len(parameters)), name


def _progress(batch: Rollout, before: Progress) -> Progress:
    """Progress with a batch as far as it has come, from the progress before that batch."""
    ended = (batch.status() != Status.RUNNING) | (batch.time >= batch.scene.duration)
    alive = int(np.count_nonzero(~ended))
    costs = batch.cost()[ended]
    part = batch.instances - alive + alive * batch.time / batch.scene.duration
    return Progress(
        candidates=before.candidates,
        done=before.done + batch.instances - alive,
        alive=alive,
        best=min(before.best, float(costs.min())) if len(costs) else before.best,
        simulated=before.simulated + float(batch.end_time().sum()),
        fraction=(before.done + part) / before.candidates,
    )


def _ended(rollout: Rollout, values: Floats) -> Evaluations:
    """The candidates of a batch that have come to an end."""
    ended = rollout.status() != Status.RUNNING
    return Evaluations(values[ended], rollout.cost()[ended], rollout.status()[ended], rollout.end_time()[ended])


def _joined(parts: list[Evaluations], parameters: int) -> Evaluations:
    """Evaluations one behind the other."""
    if not parts:
        return Evaluations(np.zeros((0, parameters)), np.zeros(0), np.zeros(0, dtype=np.int32), np.zeros(0))
    return Evaluations(
        params=np.concatenate([part.params for part in parts]),
        cost=np.concatenate([part.cost for part in parts]),
        status=np.concatenate([part.status for part in parts]),
        end_time=np.concatenate([part.end_time for part in parts]),
    )
