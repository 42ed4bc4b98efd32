"""Sweep files: which optimisations, or which trainings of policies, a sweep consists of.

Example:
    scene = "walk56"             # a shipped scene, or a TOML file relative to this one
    seed = 1                            # of the searches

    [search]                            # as the options of `warpmuscle optimize`
    strategy = "cma"
    candidates = 3000

    [set]                               # in all runs
    duration = 5
    "objective.speed" = 10

    [grid]                              # every combination of the values of these axes
    seed = [1, 2, 3]
    "objective.target_speed" = [0.8, 1.0, 1.2]
    weakness = { keys = ["character.muscles.?SOL.f_max"], factors = [1, 0.75, 0.5, 0.25] }

    [[run]]                             # each of these with every combination
    name = "normal"

    [[run]]
    name = "short shanks"
    "scale.?Lowerleg" = 0.9

What stands in `[grid]` is an axis: a key with a list of values, or a name with several keys that change together, by
`values`, the same for all keys, or by `factors`. Several `[[grid]]` are swept one after the other, each by itself and
with every entry of `[[run]]`; where a run has no value of an axis of factors, it counts as 1. Keys are those of
`overrides.py`, and in axes and runs besides `scene`, `seed` and `search.OPTION`; what a run or an axis sets comes after
what `[set]` does. `keep = "best"` keeps only the first and the best candidate of each run, as studies do without being
told, and `keep = "all"` all of them. With `[training]` instead of `[search]`, runs are trainings, see `trainings.py`,
and axes may have `training.OPTION`. A run is named by what sets it apart, such as
`normal,seed=2,target_speed=0.8,weakness=0.25`.
"""

from __future__ import annotations

import itertools
import math
import re
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

import msgspec

from warpmuscle.core.array_types import Floats
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.names import file_name
from warpmuscle.formats import load
from warpmuscle.formats.overrides import Changed, Override, changed, sound
from warpmuscle.formats.toml import Source
from warpmuscle.optimization import stages
from warpmuscle.optimization.options import GREATEST_SEED, check_options
from warpmuscle.optimization.usual_objective import warn_of_speed_in_vain
from warpmuscle.optimization.usual_search import usual_strategy
from warpmuscle.results.brief import ALL, BEST
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.stage_scene import without_only_stage
from warpmuscle.scene.trusted_code import trust, trusts_everything
from warpmuscle.scene.units import unit_at
from warpmuscle.scene.validation.checks import near
from warpmuscle.scene.validation.start import warn_of_changed_starts
from warpmuscle.sweep.axes import Choice, axes_of, entries_of
from warpmuscle.sweep.pruning.rule import PruneTable, Rule, rule_of
from warpmuscle.sweep.refinement.options import WITHOUT_POINTS, Refinement, refinement_of
from warpmuscle.sweep.samples import Sample, sampled
from warpmuscle.sweep.study.table import Study, StudyTable, study_of
from warpmuscle.sweep.training_plan import TrainingPlan, training_plan

OF_RUN = ("seed", "scene")  # keys of a run that are none of its scene

Search: Any = msgspec.defstruct(
    "Search",
    [  # no strategy: the usual one for the scene
        ("strategy", str | None, None)
        if option.name == "strategy"
        else (option.name, typing.get_type_hints(SearchOptions)[option.name], option.default)
        for option in fields(SearchOptions)
    ],
    forbid_unknown_fields=True,
)


class _File(msgspec.Struct, forbid_unknown_fields=True):
    """A sweep file."""

    scene: str = ""
    name: str = ""
    seed: int = 1
    set: dict[str, Any] = {}
    search: Search = msgspec.field(default_factory=Search)
    training: dict[str, Any] | None = None
    grid: dict[str, Any] | list[dict[str, Any]] = {}
    run: list[dict[str, Any]] = []
    sample: Sample | None = None
    study: StudyTable | None = None
    keep: Literal["all", "best"] | None = None
    prune: PruneTable | None = None


@dataclass(frozen=True)
class SweepRun:
    """One optimisation or training of a sweep."""

    name: str  # unique in its sweep, fit for a file
    scene: Scene
    seed: int
    options: SearchOptions
    candidates: int  # in all its stages
    axes: Mapping[str, float | str]  # what sets it apart, by name of the axis
    units: Mapping[str, str] = field(default_factory=dict)  # of the axes that have any
    training: TrainingPlan | None = None  # of a policy, in place of a search


@dataclass(frozen=True)
class Plan:
    """All optimisations of a sweep, in order."""

    file: Path
    name: str
    text: str  # of the file
    runs: tuple[SweepRun, ...]
    study: Study | None = None  # that the runs are to show something in
    prune: Rule | None = None  # by which runs that are behind are stopped
    refinement: Refinement | None = None  # by which further points are chosen
    keep: str = ALL  # or best: of the candidates of a run, see `results.brief`

    @property
    def trains(self) -> bool:
        """Whether its runs are trainings."""
        return any(run.training is not None for run in self.runs)

    def trust(self) -> None:
        """Let code run that its scenes name."""
        for scene in self.scenes:
            trust(scene, self.file.absolute().parent)

    @property
    def scenes(self) -> list[Scene]:
        """The scenes of its runs, each once."""
        return list({id(run.scene): run.scene for run in self.runs}.values())


def read(
    path: str | Path, trusted: bool = False, seeds: int | None = None, options: Mapping[str, Any] | None = None
) -> Plan:
    """The plan of a sweep file.

    Args:
        trusted: let code run that its scenes name, once they are simulated.
        seeds: so many, from 1 on, in place of those of the file.
        options: of the searches, in place of those of the file.

    Raises:
        SceneError: it cannot be read or used, with file, line and key.

    Warns:
        SceneWarning: it sets a speed that its searches do not ask for, or a run starts with a body in the ground.
    """
    path, trusted = Path(path), trusted or trusts_everything()
    source = Source.read(path)
    try:
        return _plan(path, source, _asked(to_type(source.data, _File), seeds, options or {}), trusted)
    except SceneError as error:
        raise source.placed(error) from None


def _asked(file: _File, seeds: int | None, options: Mapping[str, Any]) -> _File:
    """The file with so many seeds and these options of its searches in place of its own."""
    for name, value in options.items():
        setattr(file.search, name, value)
    if seeds is not None:
        own = {"seed": list(range(1, seeds + 1))}
        file.grid = file.grid | own if isinstance(file.grid, dict) else [grid | own for grid in file.grid] or own
    return file


def _plan(path: Path, source: Source, file: _File, trusted: bool) -> Plan:
    common = [Override(key, value, source.line(f"set.{key}")) for key, value in file.set.items()]
    base = _Base(path, file, common, trusted)

    def made(chosen: Floats | None) -> Plan:
        plan = _made(path, source, file, base, chosen, made)
        own = {id(run.scene): (run.name, run.scene) for run in reversed(plan.runs)}
        warn_of_changed_starts(str(path), reversed(own.values()), base.scenes)
        if trusted:
            plan.trust()
        return plan

    return made(None)


def _made(
    path: Path, source: Source, file: _File, base: _Base, chosen: Floats | None, again: Callable[[Floats], Plan]
) -> Plan:
    """The plan of a file whose adaptive points are these beside the first ones; `again` makes one of others."""
    sample = None if file.sample is None else sampled(source, file.sample, chosen)
    runs = _runs(source, file, base, [] if sample is None else [sample.choices])
    name = file.name or path.stem
    if file.study is not None and file.training is not None:
        raise SceneError("a study measures the best motions of searches; trainings have none", key="study")
    study = None if file.study is None else study_of(file.study, name, [run.axes for run in runs])
    staged = any(run.scene.stages for run in runs)
    rule = rule_of(file.prune, [(run.axes, run.candidates) for run in runs], file.training, file.study, staged)
    refused = {name: getattr(file, name) is not None for name in WITHOUT_POINTS}
    refinement = None if file.sample is None or sample is None else refinement_of(file.sample, sample, again, refused)
    return Plan(path, name, source.text, tuple(runs), study, rule, refinement, _kept(file))


def _kept(file: _File) -> str:
    """Which candidates of a run its result keeps: of studies, which need no others, the best; else all."""
    if file.keep is not None and file.training is not None:
        raise SceneError("trainings have no candidates", key="keep")
    if file.keep == BEST and file.prune is not None:
        raise SceneError("runs that compete are compared by all their candidates; leave it out", key="keep")
    return file.keep or (BEST if file.study is not None and file.prune is None else ALL)


def _runs(source: Source, file: _File, base: _Base, points: list[list[Choice]]) -> list[SweepRun]:
    """The runs of a file: each of its entries, at each point of a sample, with each combination of each grid."""
    if source.data.get("grid") in ([], {}):
        raise SceneError("there is no axis in it; name one, or leave it out", key="grid")
    tables = {"grid": file.grid} if isinstance(file.grid, dict) else _numbered("grid", file.grid)
    grids = [[*points, *axes] for axes in [axes_of(source, place, table) for place, table in tables.items()] or [[]]]
    count = max(len(file.run), 1) * sum(math.prod(map(len, axes)) for axes in grids)
    check_size("sweep", count, lambda text: SceneError(text, key="grid" if file.grid else "run"))
    entries: list[tuple[Choice, ...]] = [(entry,) for entry in entries_of(source, file.run)]
    combinations = [choices for axes in grids for choices in itertools.product(*axes)]
    taken: dict[str, int] = {}  # names, and the last number that was put behind each
    runs = [base.run([*entry, *choices], taken) for entry in entries or [()] for choices in combinations]
    normal = {axis[0].axis: 1.0 for axes in grids for axis in axes if axis[0].factor}
    return [replace(run, axes=normal | dict(run.axes)) for run in runs] if normal else runs


def _numbered(key: str, tables: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Tables of a list by their places."""
    return {f"{key}.{index}": table for index, table in enumerate(tables)}


class _Base:
    """What all runs of a sweep have in common."""

    def __init__(self, path: Path, file: _File, common: Sequence[Override], trusted: bool) -> None:
        self._path, self._file, self._common, self._trusted = path, file, common, trusted
        self._scenes: dict[str, Scene] = {}
        # By what changes them, with what decides whether they can be searched: runs that differ in seeds share one.
        self._changed: dict[str, tuple[Scene, str]] = {}
        self._begun: dict[str, Changed] = {}
        self._found: dict[str, tuple[SearchOptions, int]] = {}
        self._units: dict[tuple[str, ...], str] = {}

    def run(self, chosen: Sequence[Choice], taken: dict[str, int]) -> SweepRun:
        """The run with these choices; its name differs from those that are taken."""
        changes = self._changes(chosen)
        search = asdict(SearchOptions(**msgspec.structs.asdict(self._file.search)))
        training = None if self._file.training is None else dict(self._file.training)
        for key, override in changes.items():
            if key.startswith("search."):
                self._set_option(search, override)
            elif key.startswith("training."):
                if training is None:
                    raise self._error("there is no [training] in this file", override)
                training[key.removeprefix("training.")] = override.value
        seed = self._seed(changes.get("seed"))
        scene, kind = self._scene_with(changes)
        axes: dict[str, float | str] = {}
        for choice in chosen:
            axes |= {choice.axis or "run": choice.value, **choice.beside}
        if training is not None:
            plan = self._trained(training, list(changes.values()))
            nothing = SearchOptions("", candidates=0)
            units = self._units_of(scene, chosen)
            return SweepRun(_name(chosen, taken), scene, seed, nothing, plan.iterations or 0, axes, units, plan)
        what = repr((kind, sorted(search.items(), key=lambda item: item[0])))
        if what not in self._found:
            self._found[what] = self._searched(search, scene, seed, changes, not taken)
        options, candidates = self._found[what]
        return SweepRun(
            _name(chosen, taken), scene, seed, options, candidates, axes, self._units_of(scene, chosen)
        )  # fmt: skip

    def _changes(self, chosen: Sequence[Choice]) -> dict[str, Override]:
        """What choices set, by key."""
        changes: dict[str, Override] = {}
        for override in itertools.chain.from_iterable(choice.overrides for choice in chosen):
            if override.key in changes:
                raise self._error("is set twice, in a run and an axis, or in two axes", override)
            changes[override.key] = override
        return changes

    def _seed(self, override: Override | None) -> int:
        """The seed of the file, or the one in its place, both of which have to be seeds."""
        given: list[tuple[Any, Override | None]] = [(self._file.seed, None)]
        given += [] if override is None else [(override.value, override)]
        for one, place in given:
            if not isinstance(one, int) or isinstance(one, bool) or not 0 <= one <= GREATEST_SEED:
                raise self._error(f"a seed is a whole number from 0 to 2^63 - 1, not {one!r}", place, key="seed")
        return int(given[-1][0])

    def _scene_with(self, changes: Mapping[str, Override]) -> tuple[Scene, str]:
        """The scene of a run, and what those have in common that can be searched alike."""
        name = changes["scene"].value if "scene" in changes else self._file.scene
        others = (one for one in changes.values() if not one.key.startswith(("search.", "training.")))
        in_scene = [one for one in others if one.key not in OF_RUN]
        what = repr((name, [(one.key, one.value) for one in in_scene]))
        if what not in self._changed:
            given = self._with_common(name, changes.get("scene"))
            own = sound(changed(given, in_scene, self._path), self._path)
            own = without_only_stage(own)  # what has stages shares no batches
            self._changed[what] = own, what if own.stages else repr([p.name for p in free_parameters(own)])
        return self._changed[what]

    def _with_common(self, name: Any, override: Override | None) -> Changed:
        """The scene of a name with what all runs change."""
        key = repr(name)
        if key not in self._begun:
            self._begun[key] = changed(Changed(self._scene(name, override), {}), self._common, self._path)
        return self._begun[key]

    def _searched(
        self, search: dict[str, Any], scene: Scene, seed: int, changes: dict[str, Override], first: bool
    ) -> tuple[SearchOptions, int]:
        """The options of a search of a scene, found to be possible, and its number of candidates."""
        if not free_parameters(scene):
            message = "this scene has no free parameters: write a number as { value = .., min = .., max = .. }"
            raise self._error(message, changes.get("scene"), key="scene")
        if first:  # of a sweep
            warn_of_speed_in_vain(scene, [*changes, *(override.key for override in self._common)])
        return self._checked(search, scene, seed, list(changes.values()))

    def _units_of(self, scene: Scene, chosen: Sequence[Choice]) -> dict[str, str]:
        """Units of the axes that change numbers of the scene."""
        found = {}
        for choice in chosen:
            for name, keys in choice.keys().items():
                if (name, *keys) not in self._units:
                    self._units[(name, *keys)] = unit_at(scene, keys[0]) if keys else "1"
                found[name] = self._units[(name, *keys)]
        return {name: unit for name, unit in found.items() if unit}

    def _set_option(self, search: dict[str, Any], override: Override) -> None:
        name = override.key.removeprefix("search.")
        if name not in search:
            raise self._error(f"unknown key{near(name, search)}; there are {', '.join(search)}", override)
        search[name] = override.value

    def _checked(
        self, search: dict[str, Any], scene: Scene, seed: int, changes: list[Override]
    ) -> tuple[SearchOptions, int]:
        """The options of a search, found to be possible, and its number of candidates."""
        guilty = next((change for change in changes if change.key.startswith("search.")), None)
        try:
            asked = to_type(search, Search, key="search")
            if asked.strategy is None:
                asked.strategy = usual_strategy(len(free_parameters(scene)))
            options = SearchOptions(**msgspec.structs.asdict(asked))
            check_options(options)
            if scene.stages:
                return options, stages.plan(scene, options)[0].candidates
            stages.searches_of(scene, options, seed)
            return options, options.candidates
        except SceneError as error:
            raise self._error(error.message, guilty, key=error.key) from None
        except Error as error:
            named = next((name for name in search if name in str(error).split()), "")
            if "step size" in str(error) and "sigma" in search:
                named = "sigma"
            raise self._error(str(error), guilty, key=f"search.{named}".rstrip(".")) from None

    def _trained(self, training: dict[str, Any], changes: list[Override]) -> TrainingPlan:
        """Options of a training, found to be possible."""
        try:
            return training_plan(training)
        except Error as error:
            guilty = next((change for change in changes if change.key.startswith("training.")), None)
            raise self._error(str(error), guilty, key="training") from None

    def _scene(self, name: Any, override: Override | None) -> Scene:
        if not isinstance(name, str) or not name:
            raise self._error('name the scene: scene = "walk56", or a TOML file', override, key="scene")
        if name not in self._scenes:
            path = self._path.parent / name
            try:
                self._scenes[name] = load(path if path.suffix == ".toml" else name, trust=self._trusted)
            except SceneError as error:
                if error.file is not None and error.line:
                    raise
                raise self._error(str(error), override, key="scene") from None
        return self._scenes[name]

    @property
    def scenes(self) -> list[Scene]:
        """The scenes that runs change."""
        return list(self._scenes.values())

    def _error(self, message: str, override: Override | None, key: str = "") -> SceneError:
        """An error at the place of an override, or else of a key of the file."""
        if override is None:
            return SceneError(message, key)
        return SceneError(message, override.key, self._path, override.line)


def _name(chosen: Sequence[Choice], taken: dict[str, int]) -> str:
    """A name that a file and a dataset of HDF5 can have, and no other run has; it is taken then."""
    name = ",".join(choice.label for choice in chosen) or "run"
    name = first = file_name(name, "run")
    key = first.casefold()  # some file systems tell no small letters from capitals
    while name.casefold() in taken:
        taken[key] += 1
        name = f"{re.sub(r'~[0-9]+$', '', first)}~{taken[key]}"
    taken[name.casefold()] = 1
    return name
