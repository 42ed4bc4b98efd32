"""Candidates simulated once or several times each, as a scene's robustness asks, and what becomes of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.status import Status
from warpmuscle.scene import Scene
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.perturbations import combined, drawn


@dataclass(frozen=True)
class Outcomes:
    """What candidates came to, (candidates,) each."""

    cost: Floats
    status: Integers
    end_time: Floats  # s
    terms: dict[str, Floats]  # of the objective, by name


class CandidateBatch:
    """A batch of candidates, each with the same runs: one undisturbed run, or those of the scene's robustness.

    A candidate has ended when all its runs have. Its status and end time are those of the run of greatest cost, which
    is one that failed if any did; its terms are those of that run where the worst cost counts, else their means.

    Attributes:
        candidates: how many. runs: simulations of each. undisturbed: each has one, that of the scene as it is.
        batch: all runs, those of a candidate next to each other.
    """

    def __init__(
        self,
        scene: Scene,
        candidates: int,
        device: str | None = None,
        *,
        record: bool = False,
        threads: int | None = None,
        lanes: int | None = None,
    ) -> None:
        """Prepare; see `make_rollout` for device, threads and lanes, and for what it raises.

        Args:
            record: the motion of all runs, see `Rollout.recording`.
        """
        self.candidates, self.runs = candidates, scene.robustness.runs
        count = candidates * self.runs
        recorded = range(count) if record else ()
        self.batch = make_rollout(scene, count, device, record=recorded, threads=threads, lanes=lanes)
        runs = drawn(scene.robustness, scene.duration, len(scene.character.bodies))
        commands = scene.robustness.commands
        self.undisturbed = self.runs == 1 and not runs.any and not commands
        if commands:
            of_runs = {name: np.resize(values, self.runs) for name, values in commands.items()}
            self.batch.set_commands({name: np.tile(values, candidates) for name, values in of_runs.items()})
        if runs.any:
            self.batch.disturb(runs.tiled(candidates))

    def set_parameters(self, values: Floats) -> None:
        """Set the parameters of all candidates, (candidates, P), and start again."""
        self.batch.set_parameters(np.repeat(values, self.runs, axis=0))

    def run(self, duration: float | None = None, progress: Callable[[CandidateBatch], None] | None = None) -> None:
        """See `Rollout.run`; progress is called with these trials."""
        self.batch.run(duration, None if progress is None else lambda _: progress(self))

    def ended(self) -> NDArray[np.bool_]:
        """Whether a candidate has come to its end, (candidates,)."""
        status = self.batch.status().reshape(-1, self.runs)
        return np.asarray(np.all(status != Status.RUNNING, axis=1) | (self.batch.time >= self.batch.scene.duration))

    def cost(self) -> Floats:
        """Cost of every candidate, (candidates,)."""
        return combined(self.batch.cost().reshape(-1, self.runs), self.batch.scene.robustness)

    def outcomes(self) -> Outcomes:
        """What became of every candidate so far."""
        cost, robustness = self.batch.cost().reshape(-1, self.runs), self.batch.scene.robustness
        worst = np.arange(self.candidates) * self.runs + cost.argmax(axis=1)
        terms = self.batch.terms()
        if robustness.cost == "worst":
            terms = {name: values[worst] for name, values in terms.items()}
        else:
            terms = {name: values.reshape(-1, self.runs).mean(axis=1) for name, values in terms.items()}
        return Outcomes(combined(cost, robustness), self.batch.status()[worst], self.batch.end_time()[worst], terms)
