"""Results that show, draw and save themselves, as `optimize`, `resume` and `read` give them to users of Python."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, overload

from warpmuscle.core.arguments import answering, as_path
from warpmuscle.core.errors import ArgumentError, Error, ResultError, lacking
from warpmuscle.formats import scene_names
from warpmuscle.optimization.optimize import optimize as _optimize
from warpmuscle.optimization.resume import resume as _resume
from warpmuscle.plots import curve_of, plot
from warpmuscle.plots.one_curve import labelled_curve
from warpmuscle.results.records import Result
from warpmuscle.results.sweeps import Sweep
from warpmuscle.results.sweeps import read as _read
from warpmuscle.session.keeping import keep
from warpmuscle.view.notebook import show
from warpmuscle.view.page import Page

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

P = ParamSpec("P")
INSTEAD = {
    "cost": "best.cost is the lowest, evaluations.cost has all",
    "costs": "evaluations.cost has all",
    "best_scene": "wm.best_scene(result)[0] is the scene found",
    "params": "best.params are those of the best candidate",
    "best_parameters": "best.params are those of the best candidate",
    "best_params": "best.params are those of the best candidate",
    "x": "best.params are those of the best candidate",
    **dict.fromkeys(
        ("success", "message", "status"), "best is the best candidate, None where all failed; print(result)"
    ),
    **dict.fromkeys(("nfev", "nit", "n_evaluations"), "len(result.evaluations) are as many"),
    **dict.fromkeys(("scene_text", "to_scene"), "wm.best_scene(result)[0] is the scene found, result.scene its text"),
    "fun": "best.cost is the lowest cost",
    "recording": "replays has its motions",
    "recordings": "replays has its motions",
    "to_xarray": "replays[0].to_xarray() is the first motion",
    "to_dataframe": "replays[0].to_dataframe() is the first motion",
    "view": "show() shows its motions",
    "time": "replays[0].time is that of the first motion",
    "frames": "replays[0].frames are those of the first motion",
    "best_cost": "best.cost is the lowest",
    "history": "evaluations.cost has all, plot('convergence') draws them",
    "export": "save('walk.mot') writes OpenSim's files, save('walk.csv') a table",
    **dict.fromkeys(("simulate", "run"), "wm.simulate(wm.best_scene(result)[0]) runs the best"),
    "report": "save it as found.h5; `warpmuscle report found.h5` of the command line writes one",
}  # by what is often tried


@dataclass(frozen=True, repr=False)
class ShownResult(Result):
    """A result of a search or a simulation with what one does with it first."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            raise lacking("a result", name, dir(self), INSTEAD)

    def __getitem__(self, name: str) -> Any:
        """A curve of its first motion over time by its name, such as "hip flexion", as an `xarray.DataArray`.

        Raises:
            ArgumentError: nothing, or several curves, are called so, or there is no motion.
        """
        if not isinstance(name, str) or not self.replays:
            motions = "" if self.replays else ", and this one has no motion"
            raise ArgumentError(f"a result is asked for a curve of its motion, such as result['hip flexion']{motions}")
        try:
            title, unit, lines = curve_of(self, name)
        except Error as error:
            raise ArgumentError(str(error)) from None
        return labelled_curve(title, unit, self.replays[0].time, lines)

    def show(self, replay: int | None = None, *, meshes: str | PathLike[str] | None = None) -> Page:
        """Its motions as a page, see `warpmuscle.show`.

        Args:
            replay: the number of one of them. meshes: folder with the files that a model of OpenSim is drawn with.

        Raises:
            ResultError: there is no such motion.
        """
        return show(self, replay=replay, meshes=meshes)

    def plot(self, what: str | Sequence[str] = "", path: str | PathLike[str] | None = None) -> Figure:
        """A figure, such as "convergence", "parameters", "angles" or "hip flexion"; see `warpmuscle.plot`.

        Args:
            what: by default the convergence of a search, and the angles of what is none.

        Raises:
            Error: there is no such figure, matplotlib is not installed, or the file cannot be written.
        """
        what = what or ("" if self.evaluations is None else "convergence")
        return plot(self, what, None if path is None else as_path(path, "path"))

    def save(self, path: str | PathLike[str]) -> None:
        """Write it to an HDF5 file (`.h5`), its motions to a page (`.html`), or the first one as its name says.

        That is a table (`.mot`, `.sto`, `.csv`; see `warpmuscle export`), or a film (`.mp4`, `.gif`).

        Raises:
            Error: another ending, or it cannot be written.
        """
        keep(self, path, self.show)


def shown(result: Result) -> ShownResult:
    """The same result with what one does with it first."""
    return ShownResult(**{one.name: getattr(result, one.name) for one in fields(Result)})


ARGUMENTS = {
    **dict.fromkeys(("max_iter", "budget", "trials", "n_trials", "max_evals"), "candidates=1000 are as many in all"),
    **dict.fromkeys(("verbose", "disp"), "on a terminal and in a notebook a line says how far it is"),
    **dict.fromkeys(("bounds", "x0"), "free parameters of the scene have them: {'value': 0.6, 'min': 0.5, 'max': 0.7}"),
    "callback": "progress=print is told several times a second",
    **dict.fromkeys(("save", "path", "file", "filename"), "output='found.h5' writes it as it goes on"),
    **dict.fromkeys(
        ("parameters", "free", "variables"),
        "wm.load(scene, set={'gravity': {'value': 9.8, 'min': 9, 'max': 10}}) frees a number",
    ),
    "generations": "candidates=1000 are as many in all, population=20 a generation",
    "iterations": "candidates=1000 are as many in all, population=20 a generation",
    "maxiter": "candidates=1000 are as many in all, population=20 a generation",
    "n": "candidates=1000 are as many in all", "evaluations": "candidates=1000 are as many in all",
    "popsize": "population=20 is that of a generation", "method": "search='cma' names it",
    "algorithm": "search='cma' names it", "optimizer": "search='cma' names it",
    "timeout": "until=60 ends it after a minute", "time": "until=60 ends it after a minute",
    "objective": "the scene has it: wm.load(scene, set={'objective.target_speed': 1.5})",
    "cost": "the scene has it: wm.load(scene, set={'objective.target_speed': 1.5})",
    "set": "wm.optimize(wm.load(scene, set={...})) changes the scene",
    "duration": "wm.optimize(wm.load(scene, set={'duration': 5})) changes the scene",
    "workers": "threads=2 are those of the CPU", "n_jobs": "threads=2 are those of the CPU",
}  # fmt: skip


def _showing(make: Callable[P, Result]) -> Callable[P, ShownResult]:
    """A function whose result shows itself."""

    @answering(ARGUMENTS)
    @functools.wraps(make)
    def made(*args: P.args, **kwargs: P.kwargs) -> ShownResult:
        return shown(make(*args, **kwargs))

    return made


optimize = _showing(_optimize)
resume = _showing(_resume)


if TYPE_CHECKING:

    class ReadFile(ShownResult, Sweep):
        """A result or a sweep, which only the file tells: checkers and editors know what either has."""

        best: Any  # the best candidate of a search, or the name of the best run of a sweep

        def to_dataframe(self, candidates: bool = False) -> pandas.DataFrame:
            """The table of what it has; `candidates` is of sweeps."""
else:
    ReadFile = ShownResult | Sweep


@overload
def read(path: str | Path, run: str, *, replay: int | None = None) -> ShownResult: ...
@overload
def read(path: str | Path, run: None = None, *, replay: int | None = None) -> ReadFile: ...
@functools.wraps(_read)
def read(path: str | Path, run: str | None = None, *, replay: int | None = None) -> Any:
    """See `results.sweeps.read`."""
    if isinstance(path, str) and path in scene_names():
        raise ResultError(f"{path} is a scene: wm.simulate({path!r}) runs it, wm.load({path!r}) reads it")
    found = _read(path, run, replay=replay) if run is not None else _read(path, replay=replay)
    return shown(found) if type(found) is Result else found
