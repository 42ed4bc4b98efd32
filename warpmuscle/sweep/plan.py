"""Sweep files: which optimisations, or which trainings of policies, a sweep consists of.

Example:
    scene = "walk56"             # a shipped scene, or a TOML file relative to this one
    seed = 1                            # of the searches

    [search]                            # as the options of `warpmuscle optimize`
    strategy = "cma"
    candidates = 3000

    [set]                               # in all runs
    duration = 5

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
what `[set]` does. With `[training]` instead of `[search]`, runs are trainings, see `trainings.py`, and axes may have
`training.OPTION`. A run is named by what sets it apart: `normal,seed=2,target_speed=0.8,weakness=0.25`.
"""

from __future__ import annotations

import itertools
import math
import re
import typing
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import msgspec

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import shown
from warpmuscle.core.limits import check_size
from warpmuscle.core.names import file_name
from warpmuscle.formats import load
from warpmuscle.formats.toml import Source
from warpmuscle.optimization import stages
from warpmuscle.optimization.options import check_options, usual_strategy
from warpmuscle.results.records import Options
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.trusted_code import trust, trusts_everything
from warpmuscle.scene.validation.checks import near
from warpmuscle.sweep.overrides import Override, is_factor, overridden
from warpmuscle.sweep.training_plan import TrainingPlan, training_plan

OWN = ("seed", "scene")  # keys of a run that are none of its scene

Search: Any = msgspec.defstruct(
    "Search",
    [  # no strategy: the usual one for the scene
        (field.name, typing.get_type_hints(Options)[field.name], "" if field.name == "strategy" else field.default)
        for field in fields(Options)
    ],
    forbid_unknown_fields=True,
)


class _Axis(msgspec.Struct, forbid_unknown_fields=True):
    """Keys that change together."""

    keys: list[str]
    values: list[Any] = []
    factors: list[float] = []


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


@dataclass(frozen=True)
class Run:
    """One optimisation or training of a sweep."""

    name: str  # unique in its sweep, fit for a file
    scene: Scene
    seed: int
    options: Options
    candidates: int  # in all its stages
    axes: Mapping[str, float | str]  # what sets it apart, by name of the axis
    training: TrainingPlan | None = None  # of a policy, in place of a search


@dataclass(frozen=True)
class Plan:
    """All optimisations of a sweep, in order."""

    file: Path
    name: str
    text: str  # of the file
    runs: tuple[Run, ...]

    @property
    def trains(self) -> bool:
        """Whether its runs are trainings."""
        return any(run.training is not None for run in self.runs)

    def trust(self) -> None:
        """Let code run that its scenes name."""
        for run in self.runs:
            trust(run.scene, self.file.absolute().parent)


@dataclass(frozen=True)
class _Choice:
    """One value of an axis, or one entry of the list of runs: changes with a label."""

    axis: str
    value: float | str
    overrides: tuple[Override, ...]
    factor: bool = False  # of an axis of factors

    @property
    def label(self) -> str:
        value = self.value if isinstance(self.value, str) else shown(self.value)
        return f"{self.axis}={value}" if self.axis else value


def read(path: str | Path, trusted: bool = False) -> Plan:
    """The plan of a sweep file.

    Args:
        trusted: let code run that its scenes name, once they are simulated.

    Raises:
        SceneError: it cannot be read or used, with file, line and key.
    """
    path, trusted = Path(path), trusted or trusts_everything()
    source = Source.read(path)
    try:
        plan = _plan(path, source, to_type(source.data, _File), trusted)
    except SceneError as error:
        raise source.placed(error) from None
    if trusted:
        plan.trust()
    return plan


def _plan(path: Path, source: Source, file: _File, trusted: bool) -> Plan:
    tables = {"grid": file.grid} if isinstance(file.grid, dict) else _numbered("grid", file.grid)
    grids = [_axes(source, place, table) for place, table in tables.items()] or [[]]
    count = max(len(file.run), 1) * sum(math.prod(map(len, axes)) for axes in grids)
    check_size("sweep", count, lambda text: SceneError(text, key="grid" if file.grid else "run"))
    entries: list[tuple[_Choice, ...]] = [(_entry(source, index, entry),) for index, entry in enumerate(file.run)]
    base = _Base(
        path, file, [Override(key, value, source.line(f"set.{key}")) for key, value in file.set.items()], trusted
    )
    runs: list[Run] = []
    taken: set[str] = set()
    for entry in entries or [()]:
        for axes in grids:
            for choices in itertools.product(*axes):
                runs.append(base.run([*entry, *choices], taken))
                taken.add(runs[-1].name.casefold())  # some file systems tell no small letters from capitals
    normal = {axis[0].axis: 1.0 for axes in grids for axis in axes if axis[0].factor}
    every = [replace(run, axes=normal | dict(run.axes)) for run in runs]
    return Plan(path, file.name or path.stem, source.text, tuple(every))


def _numbered(key: str, tables: Sequence[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Tables of a list by their places."""
    return {f"{key}.{index}": table for index, table in enumerate(tables)}


def _axes(source: Source, place: str, table: Mapping[str, Any]) -> list[list[_Choice]]:
    """The axes of a grid that stands at a place."""
    axes = [_choices(source, f"{place}.{key}", key, value) for key, value in _flat(table)]
    names = [axis[0].axis for axis in axes]
    if twice := [name for name in names if names.count(name) > 1]:
        raise SceneError(f"two axes would be called {twice[0]!r}: name one as NAME = {{ keys = [..], .. }}", key=place)
    return axes


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """The axes of a grid: keys that are written without quotes, `objective.speed = [..]`, come as nested tables."""
    for name, value in table.items():
        key = f"{above}.{name}" if above else name
        if isinstance(value, dict) and "keys" not in value:
            yield from _flat(value, key)
        else:
            yield key, value


def _choices(source: Source, place: str, key: str, value: Any) -> list[_Choice]:
    """The values of an axis that stands at a place."""
    if isinstance(value, dict):
        axis = to_type(value, _Axis, key=place)
        if bool(axis.values) == bool(axis.factors) or not axis.keys:
            raise SceneError("an axis has keys, and either values or factors", key=place)
        name, keys = key, axis.keys
        values: list[Any] = axis.values or [{"factor": factor} for factor in axis.factors]
        part = "values" if axis.values else "factors"
    elif isinstance(value, list) and value:
        name, keys, values, part = _short(key), [key], value, ""
    else:
        raise SceneError("an axis is a list of values, or { keys = [..], factors = [..] }", key=place)
    choices = []
    for index, one in enumerate(values):
        line = source.line(f"{place}.{part}.{index}" if part else f"{place}.{index}")
        overrides = tuple(Override(each, one, line) for each in keys)
        choices.append(_Choice(name, _shown_value(one, index), overrides, part == "factors"))
    return choices


def _entry(source: Source, index: int, entry: Mapping[str, Any]) -> _Choice:
    """One of the list of runs."""
    flat: dict[str, Any] = {}
    for key, value in entry.items():
        if key in ("scale", "search") and isinstance(value, dict):  # written without quotes
            flat |= {f"{key}.{name}": one for name, one in value.items()}
        elif key != "name":
            flat[key] = value
    changes = [Override(key, value, source.line(f"run.{index}.{key}")) for key, value in flat.items()]
    label = entry.get("name", "")
    if not isinstance(label, str):
        raise SceneError("the name of a run is text", key=f"run.{index}.name")
    words = [f"{_short(change.key)}={_label(_shown_value(change.value, index))}" for change in changes]
    return _Choice("", label or ",".join(words) or f"run{index}", tuple(changes))


def _short(key: str) -> str:
    """The end of a key that says something: `pelvis.mass` of `character.bodies.pelvis.mass`."""
    names = key.split(".")
    if len(names) < 4:
        return names[-1] if names[0] != "scale" else key
    return ".".join(names[-2:])


def _shown_value(value: Any, index: int) -> float | str:
    """What stands for a value of an axis in names and tables."""
    if is_factor(value):
        value = value["factor"]
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return float(value)
    return value if isinstance(value, str) else f"#{index}"


def _label(value: float | str) -> str:
    return value if isinstance(value, str) else shown(value)


class _Base:
    """What all runs of a sweep have in common."""

    def __init__(self, path: Path, file: _File, common: Sequence[Override], trusted: bool) -> None:
        self._path, self._file, self._common, self._trusted = path, file, common, trusted
        self._scenes: dict[str, Scene] = {}

    def run(self, chosen: Sequence[_Choice], taken: set[str]) -> Run:
        """The run with these choices; its name differs from those that are taken."""
        changes: dict[str, Override] = {}
        for override in itertools.chain.from_iterable(choice.overrides for choice in chosen):
            if override.key in changes:
                raise self._error("is set twice, in a run and an axis, or in two axes", override)
            changes[override.key] = override
        search = asdict(Options(**msgspec.structs.asdict(self._file.search)))
        training = None if self._file.training is None else dict(self._file.training)
        seed: Any = self._file.seed
        scene_name: Any = self._file.scene
        for key, override in changes.items():
            if key == "seed":
                seed = override.value
            elif key == "scene":
                scene_name = override.value
            elif key.startswith("search."):
                self._set_option(search, override)
            elif key.startswith("training."):
                if training is None:
                    raise self._error("there is no [training] in this file", override)
                training[key.removeprefix("training.")] = override.value
        in_scene = [o for key, o in changes.items() if not key.startswith(("search.", "training.")) and key not in OWN]
        if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
            raise self._error(f"a seed is a whole number, not {seed!r}", changes.get("seed"), key="seed")
        scene = overridden(self._scene(scene_name, changes.get("scene")), [*self._common, *in_scene], self._path)
        axes = {choice.axis or "run": choice.value for choice in chosen}
        if training is not None:
            plan = self._trained(training, list(changes.values()))
            return Run(_name(chosen, taken), scene, seed, Options("", candidates=0), plan.iterations or 0, axes, plan)
        if not free_parameters(scene):
            message = "this scene has no free parameters: write a number as { value = .., min = .., max = .. }"
            raise self._error(message, changes.get("scene"), key="scene")
        options, candidates = self._checked(search, scene, seed, list(changes.values()))
        return Run(_name(chosen, taken), scene, seed, options, candidates, axes)

    def _set_option(self, search: dict[str, Any], override: Override) -> None:
        name = override.key.removeprefix("search.")
        if name not in search:
            raise self._error(f"unknown key{near(name, search)}; there are {', '.join(search)}", override)
        search[name] = override.value

    def _checked(self, search: dict[str, Any], scene: Scene, seed: int, changes: list[Override]) -> tuple[Options, int]:
        """The options of a search, found to be possible, and its number of candidates."""
        guilty = next((change for change in changes if change.key.startswith("search.")), None)
        try:
            options = Options(**msgspec.structs.asdict(to_type(search, Search, key="search")))
            options = replace(options, strategy=options.strategy or usual_strategy(scene))
            check_options(options)
            if scene.stages:
                return options, stages.plan(scene, options)[0].candidates
            stages.searches_of(scene, options, seed)
            return options, options.candidates
        except SceneError as error:
            raise self._error(error.message, guilty, key=error.key) from None
        except Error as error:
            raise self._error(str(error), guilty, key="search") from None

    def _trained(self, training: dict[str, Any], changes: list[Override]) -> TrainingPlan:
        """What a training is told, found to be possible."""
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

    def _error(self, message: str, override: Override | None, key: str = "") -> SceneError:
        """An error at the place of an override, or else of a key of the file."""
        if override is None:
            return SceneError(message, key)
        return SceneError(message, override.key, self._path, override.line)


def _name(chosen: Sequence[_Choice], taken: set[str]) -> str:
    """A name that a file and a group of HDF5 can have, and no other run has."""
    name = ",".join(choice.label for choice in chosen) or "run"
    name = file_name(name, "run")
    while name.casefold() in taken:
        number = int(name.rpartition("~")[2]) + 1 if re.search(r"~\d+$", name) else 2
        name = f"{re.sub(r'~[0-9]+$', '', name)}~{number}"
    return name
