"""A scene's cost as a function of its free parameters, for optimisers of other libraries: many candidates a call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_array, as_path, as_text, as_truth
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike, scene_of, toml
from warpmuscle.formats.overrides import with_values
from warpmuscle.optimization.evaluation import BatchEvaluator, Generation
from warpmuscle.optimization.options import required_parameters
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.replay import Replayer
from warpmuscle.optimization.unit_cube import from_unit, to_unit
from warpmuscle.optimization.usual_objective import with_usual_objective
from warpmuscle.results.records import ANY_NUMBER, Evaluations, Result, best_of, joined, parameter_table
from warpmuscle.results.result import write
from warpmuscle.scene.parameters import start_values
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.batch_input import checked_threads

ROUNDING = 1e-9  # of a parameter's interval: so far beyond its limits a library may be by rounding
Candidates = ArrayLike | Mapping[str, float] | Sequence[Mapping[str, float]]


class Evaluator:
    """Cost of candidates of a scene, simulated in batches, for optimisers of other libraries to call.

    A call is one generation: all of its candidates are simulated at once, so ask for as many as the library offers.
    A candidate's cost does not depend on the other candidates of the call. Everything that was evaluated
    is kept, and `write` puts it into a result file like that of `optimize`.

    Attributes:
        scene: with its free parameters. names: of these, (P,). units: of theirs.
        lower, upper: (P,), their limits. start: (P,), their values in the scene. unit_cube: whether candidates are
            points of the unit cube.
        device: on which candidates are simulated. largest: so many of them fit a batch; more take several.
    """

    def __init__(
        self,
        scene: SceneLike,
        *,
        set: Mapping[str, Any] | None = None,
        unit_cube: bool = False,
        device: str | None = None,
        threads: int | None = None,
        trust: bool = False,
    ) -> None:
        """Prepare; nothing is simulated yet.

        Args:
            scene: with free parameters; or its name or file. One that weighs no term is asked for a gait, as by
                `optimize`.
            set: other values of numbers by their paths, as of `load`; a table with min and max makes one free.
            unit_cube: candidates are points of the unit cube, 0 at a parameter's min and 1 at its max, and snapped to
                its step; else they are values in the parameters' units.
            device: see `make_rollout`. threads: CPU threads, by default one a core.
            trust: let code run that the scene names; not needed where `load` was told so.

        Raises:
            SceneError: the scene is inconsistent. Error: it has no free parameters, or it has stages, which have a
                cost each. RolloutError: there is no such device.
        """
        self.unit_cube = as_truth(unit_cube, "unit_cube")
        self.scene = with_usual_objective(with_values(scene_of(scene, trust=trust), set))
        check_scene(self.scene)
        if self.scene.stages:
            raise Error("this scene has stages, which have a cost each; search it with optimize")
        self._parameters = required_parameters(self.scene)
        self._batches = BatchEvaluator(self.scene, device, checked_threads(threads))
        self._tracker = Tracker(ANY_NUMBER, None, None)
        self._done: list[Evaluations] = []
        self.names = tuple(parameter.name for parameter in self._parameters)
        self.units = tuple(parameter.unit for parameter in self._parameters)
        self.device, self.largest = self._batches.device, self._batches.largest
        self.lower, self.upper, self.start = self._limits()

    def _limits(self) -> tuple[Floats, Floats, Floats]:
        """Lower and upper limits and start values, as candidates have them."""
        start, count = start_values(self.scene), len(self._parameters)
        if self.unit_cube:
            return np.zeros(count), np.ones(count), to_unit(self._parameters, start)
        lower, upper = ([getattr(p, name) for p in self._parameters] for name in ("min", "max"))
        return np.array(lower, dtype=np.float64), np.array(upper, dtype=np.float64), start

    @overload
    def __call__(self, candidates: Mapping[str, float]) -> float: ...

    @overload
    def __call__(self, candidates: ArrayLike | Sequence[Mapping[str, float]]) -> Floats: ...

    def __call__(self, candidates: Candidates) -> Floats | float:
        """The cost of candidates; of lower ones there is less.

        Args:
            candidates: (n, P), or a list of tables with a value of each parameter by name; or one of these alone.

        Returns:
            (n,); of a candidate alone a number.

        Raises:
            ArgumentError: they are no such numbers, or beyond a parameter's limits.
        """
        cost: Floats = np.asarray(self.evaluate(candidates).cost, dtype=np.float64)
        return float(cost[0]) if _alone(candidates) else cost

    def evaluate(self, candidates: Candidates) -> Evaluations:
        """Simulate candidates: their cost, status, end time and each term of the objective.

        Args:
            candidates: see `__call__`.

        Raises:
            ArgumentError: see `__call__`. KeyboardInterrupt: as it comes; those that had ended are kept.
        """
        values = self._values(candidates)
        number = len(self._done)
        generation = Generation(number, np.zeros(len(values), np.int32), values, self._batches.term_names)
        if len(values):
            try:
                self._batches.evaluate(generation, len(values), self._tracker, lambda: False)
            finally:
                self._done.append(generation.evaluations())
        return generation.evaluations()

    def _values(self, candidates: Candidates) -> Floats:
        """Candidates as an array, (n, P), in the parameters' units, of numbers within their limits."""
        table = self._table(candidates)
        bounded = np.clip(table, self.lower, self.upper)
        outside = np.argwhere(~(np.abs(table - bounded) <= ROUNDING * (self.upper - self.lower)))
        if len(outside):
            row, column = outside[0]
            raise ArgumentError(
                f"candidates[{row}]: {self.names[column]} must lie between {self.lower[column]:.12g} and "
                f"{self.upper[column]:.12g}, not {table[row, column]:.12g}"
            )
        return from_unit(self._parameters, bounded) if self.unit_cube else bounded

    def _table(self, candidates: Candidates) -> Floats:
        """Candidates as they were given, as rows."""
        count = len(self.names)
        if isinstance(candidates, Mapping):
            candidates = [candidates]
        if isinstance(candidates, Sequence) and any(isinstance(one, Mapping) for one in candidates):
            candidates = [self._row(number, one) for number, one in enumerate(candidates)]
        table: Floats = as_array(candidates, "candidates").astype(np.float64)
        if table.shape == (count,):
            table = table[None]
        if table.size == 0:
            return np.zeros((0, count))
        if table.ndim != 2 or table.shape[1] != count:
            raise ArgumentError(f"candidates have shape {table.shape}; this evaluator takes (n, {count}) or ({count},)")
        return table

    def _row(self, number: int, candidate: Any) -> list[Any]:
        """The values of a table by name, in the order of the parameters."""
        if not isinstance(candidate, Mapping):
            raise ArgumentError(f"candidates[{number}] is not a table of values by name, as others are")
        unknown, missing = candidate.keys() - set(self.names), set(self.names) - candidate.keys()
        if unknown or missing:
            what = f"there is no parameter {min(map(str, unknown))}" if unknown else f"no value of {min(missing)}"
            raise ArgumentError(f"candidates[{number}]: {what}; the parameters are {', '.join(self.names)}")
        return [candidate[name] for name in self.names]

    @property
    def evaluations(self) -> Evaluations:
        """All candidates so far, each call a generation."""
        nobody = Generation(0, np.zeros(0, np.int32), np.zeros((0, len(self.names))), self._batches.term_names)
        return joined([nobody.evaluations(), *self._done])

    def result(self, command: str = "") -> Result:
        """All evaluations so far and the motion of the best candidate, as `optimize` returns them.

        Args:
            command: put into the result as what made it.

        Raises:
            Error: nothing was evaluated yet.
        """
        command = as_text(command, "command")
        evaluations = self.evaluations
        best = best_of(evaluations)
        if best is None:
            raise Error("no candidate was evaluated yet: nothing to keep")
        motion, parts = Replayer(self.scene, self.device).replay(np.asarray(best.params, dtype=np.float64))
        return Result(
            scene=toml.dumps(self.scene),
            device=self.device,
            command=command,
            seed=0,
            parameters=parameter_table(self._parameters),
            evaluations=evaluations,
            best=best,
            replays=(motion,),
            parts=parts,
        )

    def write(self, path: str | PathLike[str], command: str = "") -> None:
        """Write `result` to an HDF5 file; raises Error if nothing was evaluated, or if it cannot be written."""
        write(as_path(path, "path"), self.result(command))

    def __repr__(self) -> str:
        done = sum(len(part) for part in self._done)
        parameters = number_of(len(self.names), "parameter")
        return f"Evaluator({self.scene.name!r} on {self.device}, {parameters}, {number_of(done, 'candidate')} so far)"


def _alone(candidates: Any) -> bool:
    """Whether this is one candidate, no list of them."""
    if isinstance(candidates, Mapping):
        return True
    return np.ndim(candidates) == 1 and len(candidates) > 0 and not isinstance(candidates[0], Mapping)
