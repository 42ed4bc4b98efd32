"""The candidate of a search that holds up best: good ones simulated again, disturbed in more ways than before."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.core.status import Status
from warpmuscle.results.records import Evaluations
from warpmuscle.scene import Robustness, Scene
from warpmuscle.simulation.candidates import CandidateBatch

RUNS = 20
DURATION = 10.0  # s
VELOCITY_NOISE = 0.05  # m/s
SEED = 7  # of the noise, another one than searches have by default


def most_robust(scene: Scene, evaluations: Evaluations, count: int, threads: int | None = None) -> tuple[int, int]:
    """Of the candidates of least cost the one of least mean cost in runs of 10 s with velocity noise of 0.05 m/s.

    Runs are at the commands of the search, where it has any. A run that fails costs so much that the number of those
    that do not decides first.

    Args:
        scene: of the search, without stages. evaluations: its candidates. count: how many of them to compare, at most.

    Returns:
        Its row of the evaluations, and how many of 20 runs it came through.
    """
    order = np.argsort(evaluations.cost, kind="stable")[:count]
    params = np.asarray(evaluations.params[order], dtype=np.float64)
    asked = scene.robustness.commands  # of 20 runs, too
    robustness = Robustness(runs=RUNS, velocity_noise=VELOCITY_NOISE, commands=asked, seed=SEED)
    harder = msgspec.structs.replace(scene, duration=DURATION, robustness=robustness)
    trials = CandidateBatch(harder, len(params), "cpu", threads=threads)
    trials.set_parameters(params)
    trials.run()
    best = int(trials.cost().argmin())
    held = trials.batch.status().reshape(-1, RUNS)[best] == Status.COMPLETED
    return int(order[best]), int(held.sum())
