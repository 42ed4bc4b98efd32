"""Computed muscle control: excitations with which a simulation follows recorded motions.

As OpenSim's CMC (Thelen, Anderson, Delp 2003), window by window: accelerations that lead back to the motion,
generalised forces that they need, forces that muscles can come to by the window's end under least and full excitation,
static optimisation within these, and excitations that lead to the forces. Unlike OpenSim's,
it adds to the accelerations what those of the windows before fell short by. All trials are instances of one simulation.

As everything is simulated by the same step, the excitations run the motion again by themselves. `track` does so, and
says how far that run is from the recording.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import overload

import numpy as np

from warpmuscle.core.arguments import as_number
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import (
    CoordinatesLike,
    LoadsLike,
    Several,
    are_several,
    prepare,
    trials_of,
    wanted_times,
)
from warpmuscle.inverse.simulated_ground.follow import ground_tracker
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.tracking.tracker import Tracker, TrackingOptions
from warpmuscle.inverse.trial import Coordinates, Loads, TrialWarning
from warpmuscle.simulation.kernel_cache import said


@overload
def track(
    model: SceneLike | BodyModel, coordinates: CoordinatesLike, loads: LoadsLike = None, *,
    filter: float | None = None, begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None, device: str | None = None, **options: object,
) -> Tracked: ...  # fmt: skip
@overload
def track(
    model: SceneLike | BodyModel, coordinates: Several, loads: LoadsLike = None, *,
    filter: float | None = None, begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None, device: str | None = None, **options: object,
) -> list[Tracked]: ...  # fmt: skip
@said("following the motion")
def track(
    model: SceneLike | BodyModel,
    coordinates: CoordinatesLike | Sequence[CoordinatesLike],
    loads: Loads | Sequence[Loads | None] | None = None,
    *,
    filter: float | None = None,
    begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None,
    device: str | None = None,
    **options: object,
) -> Tracked | list[Tracked]:
    """Muscle excitations with which a model tracks recorded motions, for one trial or many at once.

    Args:
        model, coordinates, loads, filter, device: see `inverse_dynamics`.
        begin, end: s, which part of the motions, by default all; one number or one a trial.
        options: see `TrackingOptions`: window, kp, kv, reserve, reserves, residuals, ground.

    Raises:
        ArgumentError: see `inverse_dynamics`; an option that is none; a part shorter than a window.
        SceneError: the model cannot be read, or has no muscles.
    """
    many = are_several(coordinates)
    body = model if isinstance(model, BodyModel) else BodyModel(model, device)
    unknown = next((name for name in options if name not in TrackingOptions.__dataclass_fields__), None)
    if unknown is not None:
        raise ArgumentError(f"no option {unknown!r}; there are {', '.join(TrackingOptions.__dataclass_fields__)}")
    motions = trials_of(coordinates, body.scene)
    chosen = TrackingOptions(**options)  # type: ignore[arg-type]
    found = track_trials(body, motions, loads, chosen, filter, begin, end)
    return found if many else found[0]


def track_trials(
    body: BodyModel,
    motions: Sequence[Coordinates],
    loads: Loads | Sequence[Loads | None] | None,
    options: TrackingOptions,
    cutoff: float | None = None,
    begin: float | Sequence[float] | None = None,
    end: float | Sequence[float] | None = None,
    recorded: bool = False,
) -> list[Tracked]:
    """The same of a list of trials, whose runs are kept as motions if `recorded`."""
    options.check()
    if not body.muscles:
        raise ArgumentError("the model has no muscles")
    step = body.scene.time_step
    window = max(round(options.window / step), 1) * step
    trials = prepare(body, motions, loads, cutoff, window_times(motions, window, begin, end))
    tracker = (ground_tracker if options.ground else Tracker)(body, trials, options, recorded)
    tracker.follow()
    tracker.repeat()
    found = tracker.results()
    lost = [k for k, one in enumerate(found) if one.lost is not None]
    if lost:
        first = found[lost[0]]
        warnings.warn(
            TrialWarning(f"{number_of(len(lost), 'trial')} of {len(found)} could not be followed, trial {lost[0] + 1} "
                         f"only until {first.lost:.3g} s: its simulation diverged, and is left out from there on"),
            stacklevel=3,
        )  # fmt: skip
    return found


def window_times(
    motions: Sequence[Coordinates],
    window: float,
    begin: float | Sequence[float] | None,
    end: float | Sequence[float] | None,
) -> list[Floats]:
    """Times between windows of each motion; raises ArgumentError if there is no whole window."""
    firsts, lasts = (list(one) if isinstance(one, (list, tuple)) else [one] * len(motions) for one in (begin, end))
    if len(firsts) != len(motions) or len(lasts) != len(motions):
        raise ArgumentError(f"begin and end are one number, or one for each of {number_of(len(motions), 'motion')}")
    found = []
    for motion, first, last in zip(motions, firsts, lasts, strict=True):
        start, stop = float(motion.times[0]), float(motion.times[-1])
        start = start if first is None else max(as_number(first, "begin", infinite=True), start)
        stop = stop if last is None else min(as_number(last, "end", infinite=True), stop)
        if not stop - start >= 0.999 * window:
            raise ArgumentError(
                f"no window of {window:g} s lies between {start:g} and {stop:g} s; the motion is of "
                f"{motion.times[0]:g} to {motion.times[-1]:g} s"
            )
        count = int((stop - start) / window + 1e-3)
        found.append(wanted_times(motion, np.minimum(start + window * np.arange(count + 1), motion.times[-1])))
    return found
