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

What a file may hold is in `file`, how each of its runs is made in `runs`.

May import: sweep and all below.
To add: a key to `file`; what a run takes to `runs`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from warpmuscle.core.array_types import Floats
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import readable
from warpmuscle.formats.overrides import Override
from warpmuscle.formats.toml import Source
from warpmuscle.results.brief import ALL, BEST
from warpmuscle.scene import Scene
from warpmuscle.scene.trusted_code import trust, trusts_everything
from warpmuscle.scene.validation.start import warn_of_changed_starts
from warpmuscle.sweep.axes import Choice, axes_of, entries_of
from warpmuscle.sweep.plan.file import SweepFile
from warpmuscle.sweep.plan.runs import Runs, SweepRun
from warpmuscle.sweep.pruning.rule import Rule, rule_of
from warpmuscle.sweep.refinement.options import WITHOUT_POINTS, Refinement, refinement_of
from warpmuscle.sweep.samples import sampled
from warpmuscle.sweep.study.table import Study, study_of


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
        return _plan(path, source, _asked(to_type(source.data, SweepFile), seeds, options or {}), trusted)
    except SceneError as error:
        raise source.placed(error) from None


def _asked(file: SweepFile, seeds: int | None, options: Mapping[str, Any]) -> SweepFile:
    """The file with so many seeds and these options of its searches in place of its own."""
    for name, value in options.items():
        setattr(file.search, name, value)
    if seeds is not None:
        own = {"seed": list(range(1, seeds + 1))}
        file.grid = file.grid | own if isinstance(file.grid, dict) else [grid | own for grid in file.grid] or own
    return file


def _plan(path: Path, source: Source, file: SweepFile, trusted: bool) -> Plan:
    common = [Override(key, value, source.line(f"set.{key}")) for key, value in file.set.items()]
    base = Runs(path, file, common, trusted)

    def made(chosen: Floats | None) -> Plan:
        plan = _made(path, source, file, base, chosen, made)
        own = {id(run.scene): (run.name, run.scene) for run in reversed(plan.runs)}
        warn_of_changed_starts(str(path), reversed(own.values()), base.scenes)
        if trusted:
            plan.trust()
        return plan

    return made(None)


def _made(
    path: Path, source: Source, file: SweepFile, base: Runs, chosen: Floats | None, again: Callable[[Floats], Plan]
) -> Plan:
    """The plan of a file whose adaptive points are these beside the first ones; `again` makes one of others."""
    sample = None if file.sample is None else sampled(source, file.sample, chosen)
    runs = _runs(source, file, base, [] if sample is None else [sample.choices])
    name = file.name or readable(path.stem)
    if file.study is not None and file.training is not None:
        raise SceneError("a study measures the best motions of searches; trainings have none", key="study")
    study = None if file.study is None else study_of(file.study, name, [run.axes for run in runs])
    staged = any(run.scene.stages for run in runs)
    rule = rule_of(file.prune, [(run.axes, run.candidates) for run in runs], file.training, file.study, staged)
    refused = {name: getattr(file, name) is not None for name in WITHOUT_POINTS}
    refinement = None if file.sample is None or sample is None else refinement_of(file.sample, sample, again, refused)
    return Plan(path, name, source.text, tuple(runs), study, rule, refinement, _kept(file))


def _kept(file: SweepFile) -> str:
    """Which candidates of a run its result keeps: of studies, which need no others, the best; else all."""
    if file.keep is not None and file.training is not None:
        raise SceneError("trainings have no candidates", key="keep")
    if file.keep == BEST and file.prune is not None:
        raise SceneError("runs that compete are compared by all their candidates; leave it out", key="keep")
    return file.keep or (BEST if file.study is not None and file.prune is None else ALL)


def _runs(source: Source, file: SweepFile, base: Runs, points: list[list[Choice]]) -> list[SweepRun]:
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
