"""All steps from coordinates to muscles and joints, for many trials of a model at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.activations import ActivationOptions
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Moments, prepare
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.kinematics import Kinematics
from warpmuscle.inverse.output import Trial
from warpmuscle.inverse.reactions.joint_reactions import reactions_of
from warpmuscle.inverse.recordings.belt import belt_of, on_belt
from warpmuscle.inverse.recordings.measured import measured_of
from warpmuscle.inverse.recordings.motion import recorded_motions
from warpmuscle.inverse.static_optimization import activations_of
from warpmuscle.inverse.tracking.track import track_trials
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.tracking.tracker import TrackingOptions
from warpmuscle.inverse.trial import Coordinates, Loads
from warpmuscle.results.recording import Recording

STEPS = ("ik", "id", "so", "jr", "track")


def steps_of(words: str) -> tuple[str, ...]:
    """The steps that a text such as `id,so` names; raises ArgumentError for others."""
    found = tuple(word.strip() for word in words.split(",") if word.strip())
    unknown = next((word for word in found if word not in STEPS), None)
    if unknown is not None or not found:
        raise ArgumentError(f"steps are {', '.join(STEPS)}, not {unknown or words!r}")
    return found


def run_steps(
    body: BodyModel,
    steps: Sequence[str],
    names: Sequence[str],
    motions: Sequence[Coordinates],
    loads: Sequence[Loads | None],
    *,
    filter: float | None = None,
    times: Floats | Sequence[Floats] | None = None,
    emg: Sequence[Emg | None] | None = None,
    options: ActivationOptions | None = None,
    on: str = "child",
    frame: str = "child",
    tracking: TrackingOptions | None = None,
    recorded: bool = False,
    fitted: Sequence[Kinematics | None] | None = None,
    exact_rates: bool = False,
) -> list[Trial]:
    """What the steps find of all trials.

    Args:
        steps: of `STEPS`; joint reactions count muscles if there is static optimisation. names: of the trials.
        motions, loads, filter, times, exact_rates: see `inverse_dynamics`. emg, options: see `static_optimization`.
        on, frame: see `joint_reactions`. tracking: see `track`; each trial is followed from its first time on.
        recorded: whether trials get their motion as a `Recording`, too, and what was measured.
        fitted: what the motions were found from, if that is markers.

    Raises:
        ArgumentError: see these.
    """
    acting = "so" in steps or "jr" in steps
    trials = prepare(body, list(motions), list(loads), filter, times, exact_rates, of_speeds=acting)
    dynamics = body.dynamics(trials.states, trials.loads)
    units = tuple("N m" if unit == "rad" else "N" for unit in body.map.units)
    forces = trials.split(body.map.forces(dynamics.effort, trials.states))
    moments = [
        Moments(body.map.names, units, at, values, body.map.roots)
        for at, values in zip(trials.times, forces, strict=True)
    ]
    nothing: list[None] = [None] * len(names)
    activations = None
    pulled = trials.of_speeds
    needed = body.dynamics(pulled.states, pulled.loads) if acting else dynamics
    if "so" in steps:
        effort = needed.effort + needed.followed
        signals = nothing if emg is None else list(emg)
        activations = activations_of(body, pulled, options or ActivationOptions(), signals, effort)
    reactions = reactions_of(body, pulled, activations, on, frame, needed) if "jr" in steps else nothing
    tracked: Sequence[Tracked | None] = nothing
    if "track" in steps:
        begin, end = ([float(at[k]) for at in trials.times] for k in (0, -1))
        tracked = track_trials(body, motions, list(loads), tracking or TrackingOptions(), filter, begin, end, recorded)
    shown: Sequence[Recording | None] = nothing
    if recorded:
        shown = made = recorded_motions(body, trials, dynamics.effort, activations)
        tracked = [_on_belt_of(run, own) for run, own in zip(tracked, made, strict=True)]
    markers = nothing if fitted is None else list(fitted)
    seen = [measured_of(body, trials, k, markers[k]) if recorded else None for k in range(len(names))]
    found = zip(names, motions, moments, activations or nothing, reactions, tracked, shown, seen, strict=True)
    return [
        Trial(name, motion, own if "id" in steps else None, acting, reaction, followed, recording, measured)
        for name, motion, own, acting, reaction, followed, recording, measured in found
    ]


def _on_belt_of(run: Tracked | None, motion: Recording) -> Tracked | None:
    """A run that plates carry, which is on the belt of the motion that it follows."""
    if run is None or run.motion is None or run.ground is not None:
        return run
    return replace(run, motion=on_belt(run.motion, belt_of(motion)))


def frames_of(motion: Coordinates, first: float, last: float, every: int) -> Floats:
    """Times of every Nth frame of a motion between two times; raises ArgumentError if there is none."""
    found = motion.times[(motion.times >= first - 1e-9) & (motion.times <= last + 1e-9)][::every]
    if not len(found):
        raise ArgumentError(
            f"no frame lies between {first:g} and {last:g} s; the motion is of {motion.times[0]:g} to "
            f"{motion.times[-1]:g} s"
        )
    return np.asarray(found)
