"""Inverse kinematics: the coordinates of a model that bring its markers closest to the recorded ones.

Weighted least squares in each frame, sum w |measured - modelled|^2 / sum w + sum v (q - target)^2 over markers seen and
coordinates with a target, as OpenSim's InverseKinematicsTool has it (Lu, O'Connor 1999, J Biomech 32: 129-134; Simbody,
Assembler's goals `Markers` and `QValue`). Coordinates keep within their ranges where
the model clamps them, locked ones stay, coupled ones follow; the root may go and turn anywhere.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, overload

import numpy as np

from warpmuscle.core.arguments import as_path
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.sequences import reaches_over
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.formats.opensim_setups import Tasks, read_tasks
from warpmuscle.inverse.chain import Chain, chain_of
from warpmuscle.inverse.files import read_coordinates, read_markers, write_columns, write_coordinates
from warpmuscle.inverse.fit_plan import Problem, Recorded
from warpmuscle.inverse.marker_checks import check_size, chosen_markers, doubts, misfits, notes_on
from warpmuscle.inverse.marker_fit import Fit, MarkerFitter
from warpmuscle.inverse.trial import Coordinates, Markers, TrialWarning
from warpmuscle.scene import Scene
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.kernel_cache import said

MarkersLike = Markers | str | PathLike[str]


@dataclass(frozen=True, repr=False)
class Kinematics(Tabulated):
    """What inverse kinematics found in F frames of one recording."""

    coordinates: Coordinates  # all of the model, also locked and coupled ones
    markers: tuple[str, ...]  # (K,) those that counted
    recorded: Recorded  # where they were
    missed: Floats  # (F, K, 3) m, float32: `errors` as the fit has them
    iterations: Integers  # (F,), negative where they were not enough
    notes: tuple[str, ...]  # what is to be known of them, a line each
    scene: Scene
    chain: Chain  # of the scene

    @property
    def measured(self) -> Floats:
        """Recorded positions (F, K, 3) of the markers that counted, m, ground axes; NaN where one was not seen."""
        return self.recorded.chosen()

    @property
    def errors(self) -> Floats:
        """Measured less modelled (F, K, 3), m, ground axes; NaN where a marker was not seen."""
        return self.missed.astype(np.float64)

    def modelled(self, frames: Integers) -> Floats:
        """Where the model has its markers in some frames (n, K, 3), m, ground axes, also those that were not seen."""
        found = self.recorded.chosen(frames) - self.missed[frames]
        hidden = np.flatnonzero(np.isnan(found[..., 0]).any(axis=1))
        if len(hidden):
            values = np.stack([self.coordinates.of(name)[frames[hidden]] for name in self.chain.coordinates], axis=1)
            places = [self.chain.markers[name] for name in self.markers]
            every = _turned(self.chain.places(self.chain.poses(values), places), TO_OPENSIM.T)
            found[hidden] = np.where(np.isnan(found[hidden]), every, found[hidden])
        return found

    @property
    def distances(self) -> Floats:
        """How far each marker misses (F, K), m."""
        return np.asarray(np.linalg.norm(self.errors, axis=2))

    @property
    def rms(self) -> Floats:
        """Root mean square over the markers of each frame (F,), m; NaN where none was seen."""
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", RuntimeWarning)
            return np.asarray(np.sqrt(np.nanmean(self.distances**2, axis=1)))

    @property
    def marker_rms(self) -> dict[str, float]:
        """Root mean square over all frames, m, by marker."""
        with np.errstate(all="ignore"):
            found = np.sqrt(np.nanmean(self.distances**2, axis=0))
        return {name: float(value) for name, value in zip(self.markers, found, strict=True)}

    def write(self, path: str | PathLike[str]) -> None:
        """Write the coordinates as `.mot` or `.csv`, angles in degrees, or `.sto`, in rad; see `write_coordinates`."""
        write_coordinates(Path(path), self.coordinates, self.scene)

    def write_errors(self, path: str | PathLike[str]) -> None:
        """Write `total_squared_error`, `marker_error_RMS` and `marker_error_max`, as OpenSim does, and each marker's.

        Raises:
            ResultError: see `files.write_columns`.
        """
        each = np.nan_to_num(self.distances)
        rms = np.nan_to_num(self.rms)
        table = np.column_stack([np.sum(each**2, axis=1), rms, each.max(axis=1), each])
        names = ("total_squared_error", "marker_error_RMS", "marker_error_max", *self.markers)
        write_columns(Path(path), self.scene.name, self.coordinates.times, names, table)


Files = str | PathLike[str]


@overload
def inverse_kinematics(
    model: SceneLike, markers: MarkersLike, weights: Mapping[str, float] | None = None, *,
    setup: Files | None = None, device: str | None = None,
) -> Kinematics: ...  # fmt: skip
@overload
def inverse_kinematics(
    model: SceneLike, markers: list[Any], weights: Mapping[str, float] | None = None, *,
    setup: Files | None = None, device: str | None = None,
) -> list[Kinematics]: ...  # fmt: skip
@said("finding coordinates")
def inverse_kinematics(
    model: SceneLike, markers: MarkersLike | list[Any], weights: Mapping[str, float] | None = None, *,
    setup: Files | None = None, device: str | None = None,
) -> Kinematics | list[Kinematics]:  # fmt: skip
    """The coordinates of a model in all frames of one recording, or of several at once.

    Args:
        model: a scene with markers, such as one made of an OpenSim model, or its file.
        markers: of a recording, or its file (see `files.read_markers`), or several of them.
        weights: by marker; those that are not named do not count. Without, all that model and recording have in common
            count once.
        setup: a set-up file of OpenSim's InverseKinematicsTool, whose weights, coordinate tasks and range of times
            count; `weights` take the place of its weights of markers.
        device: of Warp; by default a GPU, if there is one.

    Warns:
        TrialWarning: what is to be known of the result, see `Kinematics.notes`.

    Raises:
        SceneError: the model cannot be used. SignalError, ArgumentError: the markers cannot.
    """
    scene = scene_of(model, "model")
    given = recordings_of(markers)
    tasks = read_tasks(as_path(setup, "setup")) if setup is not None else None
    if weights is None and tasks is not None:
        weights = tasks.markers
    chain = chain_of(scene)
    if not chain.markers:
        raise ArgumentError(f"model: {scene.name!r} has no markers, of which a fit needs three")
    chooser = _Chooser(list(chain.markers), weights)
    trials = [_Trial(scene, chain, item, chooser, tasks) for item in given]
    place = find_device(device)
    found: list[Kinematics | None] = [None] * len(trials)
    alike: dict[tuple[tuple[str, float], ...], list[int]] = {}
    for k, trial in enumerate(trials):
        alike.setdefault(trial.key, []).append(k)
    for chosen in alike.values():
        for k, kinematics in zip(chosen, _fitted(scene, chain, [trials[k] for k in chosen], place), strict=True):
            found[k] = kinematics
    done = [one for one in found if one is not None]
    for trial, kinematics in zip(trials, done, strict=True):
        for note in kinematics.notes:
            warnings.warn(f"{trial.what}{note}", TrialWarning, stacklevel=2)
    return done if isinstance(markers, list | tuple) else done[0]


def recordings_of(markers: Any) -> list[MarkersLike]:
    """Recordings of markers or their files, one or several, as a list; raises ArgumentError where they are none."""
    found = list(markers) if isinstance(markers, list | tuple) else [markers]
    if not found:
        raise ArgumentError("markers: there must be one recording at least")
    return [one if isinstance(one, Markers) else as_path(one, "markers, unless it is Markers,") for one in found]


class _Chosen(NamedTuple):
    """Markers of a recording that count."""

    weights: dict[str, float]
    key: tuple[tuple[str, float], ...]  # the same
    columns: list[int]  # among those recorded


class _Chooser:
    """Which markers of recordings count, found once for those of the same names that are all seen at first."""

    def __init__(self, model: list[str], weights: Mapping[str, float] | None) -> None:
        self._model, self._weights = model, weights
        self._known: dict[tuple[str, ...], _Chosen] = {}

    def of(self, markers: Markers) -> _Chosen:
        """Raises SignalError, see `chosen_markers`."""
        whole = bool(np.isfinite(markers.positions[0]).all())
        if whole and markers.names in self._known:
            return self._known[markers.names]
        weights = chosen_markers(self._model, markers, self._weights)
        found = _Chosen(weights, tuple(weights.items()), [markers.names.index(name) for name in weights])
        if whole:
            self._known[markers.names] = found
        return found


class _Trial:
    """One recording, made ready for the fit."""

    def __init__(self, scene: Scene, chain: Chain, given: MarkersLike, chooser: _Chooser, tasks: Tasks | None) -> None:
        self.file = None if isinstance(given, Markers) else Path(given)
        self.what = "" if self.file is None else f"{given}: "
        markers = given if isinstance(given, Markers) else read_markers(Path(given))
        try:
            self.markers = _within(markers, tasks.times if tasks is not None else None)
            self.weights, self.key, columns = chooser.of(self.markers)
        except SignalError as error:
            raise SignalError(error.message, file=self.file or (tasks.file if tasks is not None else None)) from None
        self.recorded = Recorded(self.markers.positions, columns)
        self.task_weights, self.targets = _targets(scene, chain, tasks, self.markers.times)

    def placed(self, error: SignalError) -> SignalError:
        """An error with the file of the recording."""
        return SignalError(error.message, file=self.file)


def _turned(vectors: Floats, turn: Floats) -> Floats:
    """Vectors (F, K, 3) in other axes; as one product, since one a frame takes ten times as long."""
    return (vectors.reshape(-1, 3) @ turn).reshape(vectors.shape)


def _within(markers: Markers, times: tuple[float, float] | None) -> Markers:
    """The frames from the one nearest to a range's begin to the one nearest to its end, as OpenSim takes them."""
    if times is None:
        return markers
    step = float(np.median(np.diff(markers.times))) if len(markers.times) > 1 else 0.0
    if times[1] < markers.times[0] - 0.5 * step or times[0] > markers.times[-1] + 0.5 * step:
        raise SignalError(
            f"no frame lies within the range of times from {times[0]:g} to {times[1]:g} s; there are frames from "
            f"{markers.times[0]:g} to {markers.times[-1]:g} s"
        )
    first, last = (
        int(np.abs(markers.times - min(max(time, markers.times[0]), markers.times[-1])).argmin()) for time in times
    )
    return Markers(markers.names, markers.times[first : last + 1], markers.positions[first : last + 1])


def _targets(scene: Scene, chain: Chain, tasks: Tasks | None, times: Floats) -> tuple[Floats, Floats]:
    """Weights (C,) and targets (F or 1, C) of coordinates."""
    weights, targets = np.zeros(len(chain.coordinates)), np.array([chain.neutral])
    if tasks is None:
        return weights, targets
    recorded: Coordinates | None = None
    for name, task in tasks.coordinates.items():
        if name in chain.opensim.locked or name in chain.opensim.couplers:
            continue
        if name not in chain.coordinates:
            listed = ", ".join(chain.coordinates)
            raise SignalError(
                f"a task is of the coordinate {name!r}, which the model does not have: {listed}", file=tasks.file
            )
        number = chain.coordinates.index(name)
        weights[number] = task.weight
        if task.kind == "from_file":
            recorded = recorded or _recorded(scene, tasks, times)
            column = np.interp(times, recorded.times, recorded.of(name))
            targets = np.repeat(targets, len(times), axis=0) if len(targets) == 1 else targets
            targets[:, number] = column
        elif task.kind == "manual_value":
            targets[:, number] = task.value
    return weights, targets


def fit_pose(scene: Scene, still: Markers, tasks: Tasks, device: str | None) -> tuple[Chain, Floats, Floats]:
    """The chain of a scene, its coordinates (1, C) in one frame, and the errors (1, K, 3) there, m.

    Raises:
        SignalError, ArgumentError: see `inverse_kinematics`.
    """
    chain = chain_of(scene)
    trial = _Trial(
        scene, chain, still, _Chooser(list(chain.markers), tasks.markers or None), replace(tasks, times=None)
    )
    fit = _fit(chain, [trial], find_device(device))[1]
    return chain, fit.values, _turned(fit.errors.astype(np.float64), TO_OPENSIM)


def _recorded(scene: Scene, tasks: Tasks, times: Floats) -> Coordinates:
    """The coordinates that tasks of a set-up take from a file beside it, which must reach over these times."""
    if not tasks.coordinate_file:
        raise SignalError("a task takes its value from a file, but there is no <coordinate_file>", file=tasks.file)
    path = tasks.file.parent / tasks.coordinate_file
    if not path.is_file():
        raise SignalError(f"<coordinate_file>: there is no such file as {tasks.coordinate_file!r}", file=tasks.file)
    found = read_coordinates(path, scene)
    if not reaches_over(found.times, times[0], times[-1]):
        raise SignalError(
            f"reaches from {found.times[0]:g} to {found.times[-1]:g} s, the markers from {times[0]:g} to "
            f"{times[-1]:g} s; a task takes its values from it", file=path,
        )  # fmt: skip
    return found


def _fitted(scene: Scene, chain: Chain, trials: list[_Trial], device: object) -> list[Kinematics]:
    """Trials of the same markers and weights, fitted together."""
    problem, fit = _fit(chain, trials, device)
    names, starts = tuple(trials[0].weights), problem.starts
    doubt = doubts(chain, names, fit, starts)
    listed, values = chain.all_values(fit.values)
    found = []
    for k, (trial, first, doubtful) in enumerate(zip(trials, starts.tolist(), doubt.any.tolist(), strict=True)):
        part = slice(first, first + len(trial.markers.times))
        coordinates = Coordinates(listed, trial.markers.times, values[part])
        one = Kinematics(coordinates, names, trial.recorded, fit.errors[part], fit.iterations[part], (), scene, chain)
        if doubtful:
            notes = notes_on(names, chain, doubt, k, one.recorded, one.missed, one.iterations, fit.loose[part])
            one = replace(one, notes=tuple(notes))
        found.append(one)
    return found


def _fit(chain: Chain, trials: list[_Trial], device: object) -> tuple[Problem, Fit]:
    """Trials of the same markers as one problem, and what comes of it.

    Raises:
        SignalError: a recorded body is of another size than the model, or no frame shows three markers.
    """
    names = list(trials[0].weights)
    targets = trials[0].targets
    if any(len(trial.targets) > 1 for trial in trials):
        counts = [len(trial.markers.times) for trial in trials]
        targets = np.concatenate(
            [np.broadcast_to(t.targets, (n, targets.shape[1])) for t, n in zip(trials, counts, strict=True)]
        )
    recordings, weights = [trial.recorded for trial in trials], np.array(list(trials[0].weights.values()))
    problem = Problem(recordings, weights, trials[0].task_weights, targets, TO_OPENSIM)
    fitter = MarkerFitter(chain, [chain.markers[name] for name in names], device)
    recorded = fitter.recorded(problem)
    for k in misfits(chain, names, recordings, recorded.seen, recorded.far, problem.starts).tolist():
        try:
            check_size(chain, names, _turned(recordings[k].chosen(), TO_OPENSIM))
        except SignalError as error:
            raise trials[k].placed(error) from None
    return problem, fitter.fit(problem, recorded)
