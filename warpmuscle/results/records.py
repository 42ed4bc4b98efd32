"""What a run leaves behind, as tables of plain arrays; `warpmuscle.results.result` keeps it in files."""

from __future__ import annotations

import platform
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import obtained_by
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ResultError, lacking
from warpmuscle.core.html_table import html_table
from warpmuscle.core.labelled import Labelled, to_dataframe
from warpmuscle.core.machine import this_machine
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import counted, words
from warpmuscle.results.learned import Learned
from warpmuscle.results.recording import Recording
from warpmuscle.scene.parameters import Parameter

if TYPE_CHECKING:
    import pandas

PACKAGES = {"warpmuscle": "warpmuscle", "warp": "warp-lang", "numpy": "numpy", "h5py": "h5py"}


@cache
def version_of(package: str) -> str:
    """Version of an installed package; "unknown" for one without metadata."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def installed_versions() -> dict[str, str]:
    """Versions of what produces a result here, by name."""
    return {"python": platform.python_version()} | {name: version_of(package) for name, package in PACKAGES.items()}


def made_by(command: str) -> str:
    """What pages say of how they were made: the command, and the versions of what it ran on."""
    return f"{command}; {', '.join(f'{name} {version}' for name, version in sorted(installed_versions().items()))}"


@dataclass(frozen=True, repr=False)
class ParameterTable:
    """The free parameters of a scene: P dimensions of a search."""

    name: tuple[str, ...]  # path in the scene
    unit: tuple[str, ...]
    min: Floats  # (P,)
    max: Floats  # (P,)
    step: Floats  # (P,), 0 means continuous
    value: Floats  # (P,), of the scene as stored in the same file
    scale: tuple[str, ...]  # "linear" or "log", from min at 0 to max at 1 of the unit interval that a search sees

    def __repr__(self) -> str:
        return f"ParameterTable({number_of(len(self.name), 'parameter')})"


@dataclass(frozen=True, repr=False)
class Evaluations:
    """N candidates: generation by generation, and within one search by search."""

    params: Floats  # (N, P)
    cost: Floats  # (N,)
    status: Integers  # (N,), numbers of `Status`
    end_time: Floats  # (N,), s, simulated time at which the instance ended
    search: Integers  # (N,), number of the search that asked for it, -1 for the scene as given
    generation: Integers  # (N,)
    stage: Integers  # (N,), number of the scene's stage, 0 where it has none
    terms: Floats  # (N, T), of the objective; not a number where a diverged instance or its stage has none
    term_names: tuple[str, ...] = ()  # T names

    def __len__(self) -> int:
        """Number of candidates."""
        return len(self.cost)

    def __repr__(self) -> str:
        return f"Evaluations({number_of(len(self), 'candidate')}: {counted(self.status)})"

    def status_names(self) -> tuple[str, ...]:
        """What became of each candidate, such as `completed` and `fell`."""
        return words(self.status)

    def to_dataframe(self, parameter_names: Sequence[str]) -> pandas.DataFrame:
        """A row a candidate; see `Result.to_dataframe`."""
        columns = [Labelled("status", ("candidate",), np.array(self.status_names(), dtype=object))]
        columns += [Labelled(name, ("candidate",), getattr(self, name)) for name in ("cost", "end_time", *_ORIGIN)]
        numbers = dict(zip((f"term.{name}" for name in self.term_names), self.terms.T, strict=True))
        numbers |= dict(zip(parameter_names, self.params.T, strict=True))
        columns += [Labelled(name, ("candidate",), values) for name, values in numbers.items()]
        return to_dataframe(Labelled("candidate", ("candidate",), np.arange(len(self))), columns, {})

    def rows(self, chosen: NDArray[Any] | slice) -> Evaluations:
        """The chosen rows."""
        columns: dict[str, Any] = {name: getattr(self, name)[chosen] for name in TABLE}
        return Evaluations(**columns, term_names=self.term_names)


_ORIGIN = ("search", "generation", "stage")
COLUMNS = ("params", "cost", "status", "end_time", "search", "generation", "stage")
TABLE = (*COLUMNS, "terms")  # arrays of evaluations that have a row a candidate


OF_THE_BEST = {
    **dict.fromkeys(("parameters", "x", "values"), "params has its values, in the order of result.parameters"),
    **dict.fromkeys(("recording", "motion", "replay"), "result.replays has the motions"),
    **dict.fromkeys(("scene", "to_scene", "save"), "wm.best_scene(result)[0] is its scene"),
    **dict.fromkeys(("show", "view", "plot"), "result.show() shows its motion, result.plot() draws it"),
    **dict.fromkeys(("fun", "value", "score", "fitness"), "cost is its cost"),
}  # what is often tried of the best candidate


@dataclass(frozen=True, repr=False)
class Best:
    """The candidate of lowest cost; of those of the last stage that has any, since stages have costs of their own."""

    params: Floats  # (P,)
    cost: float
    index: int  # row of the evaluations

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            raise lacking("the best candidate", name, dir(type(self)), OF_THE_BEST)

    def __repr__(self) -> str:
        return f"Best(candidate {self.index}, cost {self.cost:.6g}, {number_of(len(self.params), 'parameter')})"


@dataclass(frozen=True, repr=False)
class History:
    """What each generation of each search brought, H rows; complete generations only."""

    generation: Integers  # (H,)
    search: Integers  # (H,)
    best: Floats  # (H,), least cost of that search in that generation
    median: Floats  # (H,), of its costs
    spread: Floats  # (H,), standard deviation of its candidates in the unit cube, root mean square over parameters
    sigma: Floats  # (H,), step size after the generation; not a number for a search that has none
    asks_crc32: Integers  # (H,), of its candidates in the unit cube, (n, P) of float64, to tell a resumed search by
    stage: Integers  # (H,)

    def __repr__(self) -> str:
        return f"History({number_of(len(self.generation), 'generation')} of searches)"


ANY_NUMBER = 10**9  # of candidates, of an optimisation that ends by its time


@dataclass(frozen=True)
class SearchOptions:
    """What an optimisation was asked for, all that it needs to go on except the scene and the seed."""

    strategy: str = "cma"
    searches: int = 1  # how many at the same time
    population: int | None = None  # candidates a generation of a search; None for the strategy's own
    sigma: float | None = None  # first step size in the unit cube; None for the strategy's own
    restarts: str = "none"
    candidates: int = 5000  # to be evaluated in all
    until: float | None = None  # s of wall time
    target: float | None = None  # cost

    @property
    def limited(self) -> bool:
        """Whether the number of candidates ends it."""
        return self.candidates < ANY_NUMBER


@dataclass(frozen=True)
class Staged:
    """How a stage of an optimisation went."""

    name: str
    free: tuple[str, ...]  # names of the parameters that it changes, the dimensions of its searches
    options: SearchOptions  # its own: candidates and until are its parts, the target that of its cost
    ended: str = ""  # why the next stage began; empty while it has not
    best: Best | None = None  # of its candidates


@dataclass(frozen=True, repr=False)
class Searched:
    """How an optimisation went: what was asked, why it ended, each generation, and what its searches know."""

    options: SearchOptions
    ended: str  # why; empty for one that was still going on, and so can only be resumed from here
    history: History
    states: tuple[Mapping[str, Floats], ...] = ()  # of each search, arrays by name; with stages, of those of this one
    stages: tuple[Staged, ...] = ()  # of the scene, begun or not
    stage: int = 0  # number of the last one begun
    elsewhere: int = 0  # so many first generations were asked for on other machines, see `SearchLoop`
    evaluated: int = 0  # candidates in all, where the evaluations are only some of them; 0 where they are all

    def __repr__(self) -> str:
        stages = f", {number_of(len(self.stages), 'stage')}" if self.stages else ""
        return f"Searched({self.options.searches} x {self.options.strategy}{stages}, {self.ended or 'not ended'})"


@dataclass(frozen=True)
class Fit:
    """How a fit of simulated motions to n recorded ones went, over S stages."""

    joints: tuple[str, ...]  # J that were compared
    stages: tuple[str, ...]  # names
    r2: Floats  # (S, n, J), share of the variance of angles that is met
    seconds: Floats  # (S,) since the begin, at the end of each stage


@obtained_by('wm.read("walk.h5") reads one, and wm.optimize makes one')
@dataclass(frozen=True, repr=False)
class Result:
    """The contents of a result file; evaluations, best and searched are None where nothing was searched."""

    scene: str  # TOML text
    device: str
    command: str
    seed: int
    parameters: ParameterTable
    evaluations: Evaluations | None = None
    best: Best | None = None
    replays: tuple[Recording, ...] = ()
    searched: Searched | None = None
    versions: Mapping[str, str] = field(default_factory=installed_versions)
    machine: Mapping[str, str] = field(default_factory=this_machine)  # processor and BLAS; empty in older files
    replay_names: tuple[str, ...] = ()  # of the motions, if they have any
    parts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # of terms, by joint or muscle, undisturbed
    fit: Fit | None = None  # of motions to recorded ones, which are then their `joint_target`
    learned: Learned | None = None  # a policy that drives the scene
    file: str = field(default="", compare=False)  # that it was read from

    def __repr__(self) -> str:
        parts = [f"seed {self.seed} on {self.device}" if self.device else ""]
        if self.evaluations is not None:
            parts.append(f"{number_of(self.evaluated, 'candidate')}")
        if self.best is not None:
            parts.append(f"best cost {self.best.cost:.6g}")
        if self.learned is not None:
            parts.append(repr(self.learned))
        parts.append(f"{number_of(len(self.replays), 'motion')}")
        return f"Result({', '.join([repr(self.scene_name), *filter(None, parts)])})"

    def _repr_html_(self) -> str:
        """What notebooks show: a table."""
        rows = [("scene", self.scene_name), ("motions", str(len(self.replays)))]
        if self.evaluations is not None:
            found = "" if self.is_brief else f": {counted(self.evaluations.status)}"
            rows.append(("candidates", f"{self.evaluated}{found}"))
        if self.best is not None:
            rows.append(("best", f"candidate {self.best.index}, cost {self.best.cost:.6g}"))
        rows += [("made by", self.command), ("on", self.device), ("seed", str(self.seed))]
        return html_table(("result", ""), [row for row in rows if row[1]])

    def to_dataframe(self) -> pandas.DataFrame:
        """A `pandas.DataFrame` with one row per candidate.

        Columns are `status` in words, `cost`, `end_time` in s, `search`, `generation`, `stage`, `term.` and the name
        of each term of the objective, unweighted, and each parameter by its path in the scene, in its unit.

        Raises:
            ResultError: nothing was searched. Error: pandas is not installed.
        """
        if self.evaluations is None:
            raise ResultError("this result has no candidates; its motions are tables, as `replays[0].to_dataframe()`")
        return self.evaluations.to_dataframe(self.parameters.name)

    @property
    def is_brief(self) -> bool:
        """Whether it holds only some of the candidates that were evaluated: the first one and the best."""
        return self.searched is not None and self.searched.evaluated > 0

    @property
    def evaluated(self) -> int:
        """How many candidates were evaluated, whether it holds them all or not."""
        if self.searched is not None and self.searched.evaluated > 0:
            return self.searched.evaluated
        return 0 if self.evaluations is None else len(self.evaluations)

    @property
    def scene_name(self) -> str:
        """Name of the scene."""
        line = re.search(r"^name = .*$", self.scene, re.MULTILINE)  # the first one is the scene's own
        try:
            return str(tomllib.loads(line[0])["name"]) if line else ""
        except tomllib.TOMLDecodeError:
            return ""


def parameter_table(parameters: list[Parameter]) -> ParameterTable:
    """Free parameters as a result file keeps them."""
    return ParameterTable(
        name=tuple(p.name for p in parameters),
        unit=tuple(p.unit for p in parameters),
        min=np.array([p.min for p in parameters]),
        max=np.array([p.max for p in parameters]),
        step=np.array([p.step for p in parameters]),
        value=np.array([p.value for p in parameters]),
        scale=tuple(p.scale for p in parameters),
    )


def joined(parts: Sequence[Evaluations]) -> Evaluations:
    """Evaluations of the same scene one behind the other; at least one part."""
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in TABLE}
    return Evaluations(**columns, term_names=parts[0].term_names)


def best_of(evaluations: Evaluations, stage: int | None = None) -> Best | None:
    """The first candidate of lowest cost of a stage, by default of the last one that has any, if there is any."""
    if len(evaluations) == 0:
        return None
    mine = evaluations.stage == (evaluations.stage.max() if stage is None else stage)
    if not mine.any():
        return None
    index = int(np.argmin(np.where(mine, evaluations.cost, np.inf)))
    return Best(evaluations.params[index], float(evaluations.cost[index]), index)
