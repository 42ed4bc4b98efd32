"""A generic model made one of a subject: its bodies scaled, its markers put where the subject wears them.

By measurements, as OpenSim's ScaleTool: distances of markers in a static trial over those of the model give factors of
bodies, and a fit of the static pose then says where markers are. Or by all frames of any trials: factors and places of
markers that fit best, see `size_fit`.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.arguments import as_number, as_path, as_truth
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, SceneError, SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.opensim_setups import Measurement, ScaleSetup, read_scale_setup
from warpmuscle.formats.osim.build import build
from warpmuscle.formats.osim.read import read
from warpmuscle.formats.osim.records import Model
from warpmuscle.inverse.chain import chain_of
from warpmuscle.inverse.files import read_markers
from warpmuscle.inverse.kinematics import MarkersLike, fit_pose, recordings_of
from warpmuscle.inverse.marker_checks import check_size, chosen_markers
from warpmuscle.inverse.size_fit import fit_sizes
from warpmuscle.inverse.sized_chain import SizedChain
from warpmuscle.inverse.trial import Markers, TrialWarning
from warpmuscle.scene import Scene
from warpmuscle.scene.scaling import multiplied, muscle_length_factors
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.devices import find_device
from warpmuscle.simulation.kernel_cache import said

SAME = 1.0e-6  # s, between times that are one
HEAVIEST = 1.0e4  # kg
LARGEST_MOVE = 0.05  # m, of a marker on its body, beyond which it is told
UNUSUAL = 0.6, 1.6  # factors outside of which a subject is of another kind than the model


@dataclass(frozen=True)
class Scaled:
    """A model of a subject."""

    scene: Scene
    factors: dict[str, tuple[float, float, float]]  # by body, along its x, y and z axes in the model's file
    mass: float  # kg, of the whole body
    moved: dict[str, float]  # m, how far each marker was moved on its body
    rms: float  # m, of the markers of the frames that counted
    notes: tuple[str, ...]  # what is to be known, a line each


@said("scaling")
def scale(
    model: str | PathLike[str], markers: MarkersLike | list[Any], *, mass: float | None = None,
    setup: str | PathLike[str] | None = None, weights: Mapping[str, float] | None = None, symmetric: bool = True,
    move_markers: bool = True, keep_mass_distribution: bool | None = None, device: str | None = None,
) -> Scaled:  # fmt: skip
    """Scale a generic model to a subject.

    Optimal fibre and slack lengths change as the paths of their muscles do in the pose that the model starts in, as in
    OpenSim; strengths stay.

    Args:
        model: an OpenSim model, `.osim`, with markers.
        markers: of recordings, or their files: with a set-up of one static trial, else of any, which count together.
        mass: of the subject, kg; by default that of the set-up, or as the factors make it.
        setup: a set-up file of OpenSim's ScaleTool, whose measurements, factors given by hand, weights, coordinate
            tasks and ranges of times count.
        weights: by marker, of the fit without a set-up; those that are not named do not count.
        symmetric: whether left and right get the same factors in the fit without a set-up.
        move_markers: whether markers are put where the subject wears them, but for those that the model says are fixed.
        keep_mass_distribution: whether each body keeps its part of the mass, rather than one that goes with its volume;
            by default as the set-up says. Without one, parts are kept if `mass` is told: markers tell little of how
            wide segments are.

    Warns:
        TrialWarning: what is to be known of the result, see `Scaled.notes`.

    Raises:
        SceneError: the model or the set-up cannot be used. SignalError, ArgumentError: the markers or numbers cannot.
    """
    path = as_path(model, "model")
    if path.suffix.lower() != ".osim":
        raise ArgumentError(f"model: an OpenSim model, .osim, can be scaled, not {path.name!r}")
    if mass is not None and not as_number(mass, "mass", most=HEAVIEST) > 0.0:
        raise ArgumentError(f"mass: must be greater than 0 kg, not {mass:g}")
    for name, truth in (("symmetric", symmetric), ("move_markers", move_markers)):
        as_truth(truth, name)
    if keep_mass_distribution is not None:
        as_truth(keep_mass_distribution, "keep_mass_distribution")
    trials = [item if isinstance(item, Markers) else read_markers(Path(item)) for item in recordings_of(markers)]
    record = read(path, Notes())
    if not record.markers:
        raise ArgumentError(f"model: {path.name!r} has no markers, by which it could be scaled")
    if setup is not None:
        found = _by_setup(
            record,
            trials,
            read_scale_setup(as_path(setup, "setup")),
            mass,
            move_markers,
            keep_mass_distribution,
            device,
        )
    else:
        keep = mass is not None if keep_mass_distribution is None else keep_mass_distribution
        found = _by_frames(record, trials, mass, weights, symmetric, move_markers, keep, device)
    for note in found.notes:
        warnings.warn(note, TrialWarning, stacklevel=2)
    return found


def _by_frames(
    record: Model, trials: list[Markers], mass: float | None, weights: Mapping[str, float] | None, symmetric: bool,
    move_markers: bool, keep: bool, device: str | None,
) -> Scaled:  # fmt: skip
    """By all frames of all recordings."""
    names = [one.name for one in record.markers]
    chosen = [chosen_markers(names, trial, weights) for trial in trials]
    common = [name for name in chosen[0] if all(name in other for other in chosen)]
    if len(common) < 3:
        raise SignalError(
            f"the recordings have {number_of(len(common), 'marker')} in common; three at least are needed"
        )
    positions = np.concatenate(
        [trial.positions[:, [trial.names.index(name) for name in common]] @ TO_OPENSIM for trial in trials]
    )
    chain = SizedChain(record, common, symmetric)
    usual = chain.chain(chain.usual)
    check_size(usual, common, positions)
    fixed = {one.name for one in record.markers if one.fixed}
    movable = np.array([move_markers and name not in fixed for name in common])
    found = fit_sizes(chain, positions, np.array([chosen[0][name] for name in common]), movable, find_device(device))
    notes = (
        []
        if found.converged
        else [f"the sizes did not settle within {number_of(found.steps, 'step')}; their fit may be poor"]
    )
    sized = chain.sized(record, found.sizes, mass, keep)
    moved = dict(zip(common, np.linalg.norm(found.sizes.offsets, axis=1).tolist(), strict=True))
    factors = {name: _three(factor) for name, factor in chain.factors(found.sizes).items()}
    return _scaled(record, sized, factors, moved, found.fit.errors, notes)


def _by_setup(
    record: Model, trials: list[Markers], setup: ScaleSetup, mass: float | None, move_markers: bool,
    keep: bool | None, device: str | None,
) -> Scaled:  # fmt: skip
    """As OpenSim's ScaleTool."""
    if len(trials) != 1:
        raise ArgumentError(
            f"markers: a set-up scales by one static trial, not by {number_of(len(trials), 'recording')}"
        )
    scaled_by = _measured(record, _during(trials[0], setup.times, setup), setup)
    keep = setup.keep_mass_distribution if keep is None else keep
    sized = scaled_model(record, scaled_by, mass if mass is not None else setup.mass, keep)
    factors = {body.name: _three(scaled_by.get(body.name, np.ones(3))) for body in record.bodies}
    moved: dict[str, float] = {}
    notes: list[str] = []
    errors = np.full((1, 1, 3), np.nan)
    if setup.place and move_markers:
        if setup.placer_file != setup.marker_file:
            measured, placed = (one or "nothing" for one in (setup.marker_file, setup.placer_file))
            notes.append(
                f"in {setup.file.name} the scaler has {measured}, the placer {placed}; here one recording serves both"
            )
        still = _averaged(_during(trials[0], setup.tasks.times, setup))
        sized, moved, errors = _placed(sized, still, setup, device)
    return _scaled(record, sized, factors, moved, errors, notes)


def _during(markers: Markers, times: tuple[float, float] | None, setup: ScaleSetup) -> Markers:
    """The frames from the last one before a range of times begins to the first one once it has ended, as in OpenSim."""
    low, high = times if times is not None else (-np.inf, np.inf)
    if low > markers.times[-1] or high < markers.times[0]:
        raise SignalError(
            f"no frame lies within the range of times from {low:g} to {high:g} s; there are frames from "
            f"{markers.times[0]:g} to {markers.times[-1]:g} s", file=setup.file,
        )  # fmt: skip
    first = max(int(np.searchsorted(markers.times, low + SAME, side="right")) - 1, 0)
    last = min(int(np.searchsorted(markers.times, high - SAME)), len(markers.times) - 1)
    return Markers(markers.names, markers.times[first : last + 1], markers.positions[first : last + 1])


def _averaged(markers: Markers) -> Markers:
    """The mean positions of all markers as one frame."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        mean = np.nanmean(markers.positions, axis=0)
    return Markers(markers.names, np.zeros(1), mean[None])


def _measured(record: Model, still: Markers, setup: ScaleSetup) -> dict[str, Floats]:
    """Factors (3,) by body, from distances of markers and by hand, in the order of the set-up."""
    chain = chain_of(_scene(record, skeleton_only=True))
    places = chain.places(chain.poses(np.array([chain.neutral])), list(chain.markers.values()))[0]
    model = dict(zip(chain.markers, places, strict=True))
    there = dict(zip(still.names, still.positions.transpose(1, 0, 2), strict=True))
    bodies = {body.name for body in record.bodies}
    found: dict[str, Floats] = {}
    for kind in setup.order:
        if kind == "measurements":
            for one in setup.measurements:
                factor = _ratio(one, model, there, setup)
                for body, axes in one.bodies.items():
                    if body not in bodies:
                        message = f"measurement {one.name!r} scales the body {body!r}, which the model does not have"
                        raise SceneError(message, file=setup.file, line=one.line)
                    own = found.setdefault(body, np.ones(3))
                    own[["XYZ".index(axis) for axis in axes]] = factor
        elif kind == "manualScale":
            found |= {body: np.array(factors) for body, factors in setup.factors.items()}
        else:
            raise SceneError(f"scaling_order knows measurements and manualScale, not {kind!r}", file=setup.file)
    return found


def _ratio(one: Measurement, model: Mapping[str, Floats], there: Mapping[str, Floats], setup: ScaleSetup) -> float:
    """The mean over pairs of markers of their distance in the recording, in mean, over that in the model."""
    ratios = []
    for pair in one.pairs:
        for name in pair:
            lacks = [where for where, known in (("model", model), ("recording", there)) if name not in known]
            if not lacks and np.isnan(there[name]).any(axis=1).all():
                lacks = ["recording within the range of times"]
            if lacks:
                message = f"measurement {one.name!r} is of the marker {name!r}, which the {lacks[0]} does not have"
                raise SceneError(message, file=setup.file, line=one.line)
        own = float(np.linalg.norm(model[pair[0]] - model[pair[1]]))
        apart = float(np.nanmean(np.linalg.norm(there[pair[0]] - there[pair[1]], axis=1)))
        if not min(own, apart) > 0.0:
            message = f"measurement {one.name!r}: {' and '.join(pair)} are at the same place"
            raise SceneError(message, file=setup.file, line=one.line)
        ratios.append(apart / own)
    return float(np.mean(ratios)) if ratios else 1.0


def _placed(
    sized: Model, still: Markers, setup: ScaleSetup, device: str | None
) -> tuple[Model, dict[str, float], Floats]:
    """Markers put where they are in the pose that fits a static trial best; how far, and the errors before."""
    scene = _scene(sized, skeleton_only=True)
    chain, values, errors = fit_pose(scene, still, setup.tasks, device)
    poses = chain.poses(values)
    axes = SizedChain(sized, list(chain.markers), symmetric=False)
    frames = axes.by_offset(poses)[0]
    at = chain.places(poses, list(chain.markers.values()))[0]
    there = dict(zip(still.names, still.positions[0] @ TO_OPENSIM, strict=True))
    offsets = {
        name: frames[k].T @ (there[name] - at[k])
        for k, name in enumerate(chain.markers)
        if name in there and np.isfinite(there[name]).all()
    }
    placed = replace(sized)
    fixed = {one.name for one in sized.markers if one.fixed}
    offsets = {name: offset for name, offset in offsets.items() if name not in fixed}
    placed.markers = [
        replace(one, location=_three(np.asarray(one.location) + offsets.get(one.name, 0.0))) for one in sized.markers
    ]
    return placed, {name: float(np.linalg.norm(offset)) for name, offset in offsets.items()}, errors


def _scene(record: Model, skeleton_only: bool = False, notes: Notes | None = None) -> Scene:
    """A scene of a model's records, which stay as they are."""
    copied = scaled_model(record, {})
    if skeleton_only:
        copied = replace(copied, muscles=[], forces=[], surfaces={}, contacts={}, lost=[], lost_shapes={})
    return build(copied, notes or Notes())


def _scaled(
    record: Model, sized: Model, factors: dict[str, tuple[float, float, float]], moved: dict[str, float],
    errors: Floats, notes: list[str],
) -> Scaled:  # fmt: skip
    """The scene, with muscles as long as their paths ask for, and what is to be known."""
    remarks = Notes()
    try:
        before, after = _scene(record), _scene(sized, notes=remarks)
        scene = multiplied(after, muscle_length_factors(before, after))
        check_scene(scene)
    except SceneError as error:
        raise remarks.placed(error) from None
    odd = [f"{name} {min(three):.2f} to {max(three):.2f}" for name, three in factors.items()
           if min(three) < UNUSUAL[0] or max(three) > UNUSUAL[1]]  # fmt: skip
    if odd:
        notes.append(f"factors are unusual, of {', '.join(odd[:6])}: are markers and labels right?")
    far = [f"{name} by {100 * away:.0f} cm" for name, away in moved.items() if away > LARGEST_MOVE]
    if far:
        notes.append(f"markers were moved far on their bodies, {', '.join(far[:6])}: are labels and bodies right?")
    missed = np.linalg.norm(errors, axis=2)
    rms = float(np.sqrt(np.nanmean(missed**2))) if np.isfinite(missed).any() else float("nan")
    mass = float(sum(body.mass for body in sized.bodies))
    return Scaled(scene, factors, mass, moved, rms, tuple(notes))


def _three(numbers: Floats) -> tuple[float, float, float]:
    x, y, z = (float(number) for number in numbers)
    return x, y, z
