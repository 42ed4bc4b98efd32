"""What was done as OpenSim does it or as mechanics says, and by how much the other way would change a result."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.inverse.activations import ActivationOptions, widths_left_out
from warpmuscle.inverse.as_opensim.turned_axes import turned_joints
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.inverse.tracking.timed_forces import without_timed
from warpmuscle.inverse.trial import Coordinates, Loads

TRIALS, FRAMES = 4, 10  # looked at, of all trials and of each: between them a change may be greater


class Choice(NamedTuple):
    """A way in which OpenSim and mechanics differ, and a sentence on which was taken."""

    name: str  # of an attribute of a result's file
    sentence: str


def choices(
    body: BodyModel,
    steps: Sequence[str],
    motions: Sequence[Coordinates],
    loads: Sequence[Loads | None],
    times: Sequence[Floats],
    *,
    filter: float | None = None,
    options: ActivationOptions | None = None,
    exact_rates: bool = False,
) -> list[Choice]:
    """Which ways were taken in trials, and by how much others would change them in some of their frames.

    Nothing is said where both are the same, as in models without muscles of Millard or De Groote, or turned knees.

    Args:
        steps, motions, loads, filter, options, exact_rates: see `steps.run_steps`. times: of each trial.
    """
    some = [at[np.unique(np.linspace(0, len(at) - 1, FRAMES).astype(int))] for at in times[:TRIALS]]
    trials = list(motions[:TRIALS]), list(loads[:TRIALS])
    found = []
    if set(steps) & {"id", "so", "jr"} and (count := len(without_timed(body.scene.forces))):
        found.append(_of_model_forces(count, body.model_forces))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that have been said
        if set(steps) & {"id", "so", "jr"} and turned_joints(body):
            found.append(_of_rates(body, *trials, some, filter, exact_rates))
        if "so" in steps and options is not None and widths_left_out(body)[1].any() and not options.elastic:
            found.append(_of_pennation(body, *trials, some, filter, options, exact_rates))
    return found


def _of_model_forces(count: int, act: bool) -> Choice:
    """On what of a model acts besides its muscles."""
    words = f"{number_of(count, 'force')} of the model beside its muscles, such as springs and limits,"
    one = "s" if count == 1 else ""
    if act:
        return Choice("model_forces", f"{words} act{one}, as in OpenSim")
    return Choice(
        "model_forces", f"{words} play{one} no part; in OpenSim they do unless excluded, and with --model-forces"
    )


def _of_rates(
    body: BodyModel, motions: list[Coordinates], loads: list[Loads | None], times: list[Floats], cutoff: float | None,
    exact: bool,
) -> Choice:  # fmt: skip
    """On accelerations beyond knees that turn about three axes."""
    opensims, right = (
        inverse_dynamics(body, motions, loads, filter=cutoff, times=times, exact_rates=one) for one in (False, True)
    )
    off = np.concatenate([np.abs(a.values - b.values) for a, b in zip(opensims, right, strict=True)]).max(axis=0)
    turns = [k for k, unit in enumerate(opensims[0].units) if unit == "N m"]
    worst = max(turns, key=lambda k: float(off[k]))
    other = f"moments would differ by up to {off[worst]:.2g} N m ({body.map.names[worst]})"
    if exact:
        return Choice("rates", f"accelerations beyond knees are exact; with those of OpenSim {other}")
    return Choice("rates", f"accelerations beyond knees are OpenSim's; with exact ones (--exact-rates) {other}")


def _of_pennation(
    body: BodyModel, motions: list[Coordinates], loads: list[Loads | None], times: list[Floats], cutoff: float | None,
    options: ActivationOptions, exact: bool,
) -> Choice:  # fmt: skip
    """On the pennation of Millard's and De Groote's muscles."""
    alone = replace(options, rates=False, emg_weight=0.0)  # frames far from each other are solved by themselves
    without, counted = (
        static_optimization(body, motions, loads, filter=cutoff, times=times, exact_rates=exact,
                            **vars(replace(alone, pennation=one)))
        for one in (False, True)
    )  # fmt: skip
    off = np.concatenate([np.abs(a.activation - b.activation) for a, b in zip(without, counted, strict=True)])
    most = off.max(axis=0)
    other = f"activations would differ by up to {most.max():.2g} ({body.muscles[int(np.argmax(most))]})"
    of_muscles = "the pennation of " + number_of(int(np.count_nonzero(widths_left_out(body)[1])), "muscle")
    if options.pennation:
        return Choice("pennation", f"{of_muscles} is taken into account; without it, as in OpenSim, {other}")
    return Choice("pennation", f"{of_muscles} is left out, as in OpenSim; with it (--pennation) {other}")
