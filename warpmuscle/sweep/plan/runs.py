"""How the runs of a sweep are made: each a scene with what an entry and axes set, and a search or a training of it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.names import file_name
from warpmuscle.formats import load
from warpmuscle.formats.overrides import Changed, Override, changed, sound
from warpmuscle.optimization import stages
from warpmuscle.optimization.options import GREATEST_SEED, check_options
from warpmuscle.optimization.usual_objective import warn_of_speed_in_vain
from warpmuscle.optimization.usual_search import usual_strategy
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.stage_scene import without_only_stage
from warpmuscle.scene.units import unit_at
from warpmuscle.scene.validation.checks import near
from warpmuscle.sweep.axes import Choice
from warpmuscle.sweep.plan.file import Search, SweepFile
from warpmuscle.sweep.training_plan import TrainingPlan, training_plan

OF_RUN = ("seed", "scene")  # keys of a run that are none of its scene


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


class Runs:
    """What all runs of a sweep have in common."""

    def __init__(self, path: Path, file: SweepFile, common: Sequence[Override], trusted: bool) -> None:
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
