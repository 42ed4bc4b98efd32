"""What recordings of a subject say, as one HTML page: angles, moments, muscles, joints, and how far to trust them.

Limits of residuals, of reserves and of errors are those of Hicks et al. 2015 ("Is my model good enough?", J Biomech Eng
137:020905): residual forces up to 5 % of the greatest net external force, residual moments up to 1 % of that times the
height of the centre of mass, reserves up to 5 % of the greatest moment of a joint, tracking within 2 degrees and 2 cm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.inverse.activations import FLAGGED
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.emg import Emg
from warpmuscle.inverse.output import Trial
from warpmuscle.inverse.trial import Loads
from warpmuscle.report.gait_cycles import RecordedTrial, cycles_of, side_of
from warpmuscle.report.images import data_uris
from warpmuscle.report.page import Figure, template
from warpmuscle.report.subject_figures import (
    Panel,
    activation_panels,
    angle_panels,
    draw_panels,
    force_panels,
    joint_panels,
    moment_panels,
    muscle_force_panels,
)
from warpmuscle.studies.inverse_dynamics import body_points

FORCE_LIMIT, MOMENT_LIMIT = 0.05, 0.01  # of the greatest net external force, and of that times the height
ANGLE_LIMIT, PLACE_LIMIT = 2.0, 0.02  # degrees and m, of tracking errors, RMS
ROOM = 750_000  # bytes of the page's figures
MOST_CHECKS, MOST_NOTES = 200, 50  # that a page shows


class Check(NamedTuple):
    """A number beside its limit."""

    trial: str
    what: str
    value: float
    limit: float
    unit: str

    @property
    def kept(self) -> bool:
        """Whether it is within its limit."""
        return self.value <= self.limit


class Body(NamedTuple):
    """What residuals are compared with."""

    mass: float  # kg
    weight: float  # N
    height: float  # m, of the centre of mass


def subject_html(
    body: BodyModel,
    trials: Sequence[Trial],
    loads: Sequence[Loads | None],
    emg: Sequence[Emg | None] | None = None,
    about: Sequence[tuple[str, str]] = (),
    tell: Callable[[str], None] = lambda what: None,
) -> str:
    """The page of a subject's trials.

    Args:
        body: the model. loads, emg: of the trials. about: further lines on how it was made, names and values.
        tell: called with what is being made.

    Raises:
        Error: jinja2 or matplotlib are not installed.
    """
    page = template("subject.html")
    signals = list(emg) if emg is not None else [None] * len(trials)
    whole = _body(body, trials[0])
    recorded = [_recorded(body, *one) for one in zip(trials, loads, signals, strict=True)]
    checks = [check for one in recorded for check in _checks(one, whole)]
    parts: list[tuple[str, list[Panel]]] = [
        ("Angles", [*angle_panels(recorded), *force_panels(recorded, whole.weight)]),
        ("Moments", moment_panels(recorded, whole.mass)),
        ("Activations by static optimisation", activation_panels(recorded)),
        ("Activations of the simulation that follows", activation_panels(recorded, tracked=True)),
        ("Forces of muscles", muscle_force_panels(recorded)),
        ("Forces in joints", joint_panels(recorded, whole.weight)),
    ]
    drawn = {}
    for title, panels in parts:
        if panels:
            tell(title.lower())
            drawn[title] = draw_panels(title, panels, recorded)
    sources = data_uris(list(drawn.values()), ROOM)
    sections = [Figure(title, source) for title, source in zip(drawn, sources, strict=True)]
    return str(
        page.render(
            name=body.scene.name, headline=_headline(recorded, whole), checks=_worst(checks),
            more=len(checks) - MOST_CHECKS, beyond=sum(not check.kept for check in checks), sections=sections,
            notes=_notes(recorded)[:MOST_NOTES], about=[*about, ("muscles", str(len(body.muscles)))],
        )
    )  # fmt: skip


def _worst(checks: Sequence[Check]) -> list[Check]:
    """As many checks as a page shows, those that are farthest beyond their limits; in the order of trials."""
    ranked = sorted(range(len(checks)), key=lambda k: -checks[k].value / max(checks[k].limit, 1e-12))
    return [checks[k] for k in sorted(ranked[:MOST_CHECKS])]


def _body(body: BodyModel, trial: Trial) -> Body:
    bodies = body.scene.character.bodies
    masses = {name: first_number(one.mass) for name, one in bodies.items()}
    mass = sum(masses.values())
    prepared = prepare(
        body, trial.coordinates, None, None, trial.coordinates.times[:: max(len(trial.coordinates.times) // 20, 1)]
    )
    places = body_points(body.scene, prepared.states.coordinates)
    height = sum(masses[name] * places[name][0][:, 1].mean() for name in bodies) / mass
    return Body(mass, mass * first_number(body.scene.gravity), max(float(height), 0.1))


def _recorded(body: BodyModel, trial: Trial, loads: Loads | None, emg: Emg | None) -> RecordedTrial:
    """A trial with the forces on its bodies at all of its frames, and the EMG of its time."""
    times = trial.coordinates.times
    if loads is not None:
        times = times[(times >= loads.times[0]) & (times <= loads.times[-1])]
    prepared = prepare(body, trial.coordinates, loads, None, times)
    sides = tuple(side_of(body.topology.bodies[number]) for number in prepared.loads.body)
    signals = {} if emg is None else {name: (emg.times, emg.values[:, k]) for k, name in enumerate(emg.muscles)}
    return RecordedTrial(trial, times, prepared.loads, sides, signals)


def _checks(one: RecordedTrial, whole: Body) -> list[Check]:
    """Numbers of a trial beside the limits of Hicks et al. 2015."""
    trial, found = one.found, []
    external = np.linalg.norm(one.loads.force.sum(axis=1), axis=1).max(initial=0.0) or whole.weight
    moments = trial.moments
    if moments is not None and moments.residuals:
        force, moment = (
            _greatest(moments.values[:, : moments.residuals], moments.units, unit) for unit in ("N", "N m")
        )
        found.append(Check(trial.name, "residual force at the root", force, FORCE_LIMIT * external, "N"))
        found.append(
            Check(trial.name, "residual moment at the root", moment, MOMENT_LIMIT * external * whole.height, "N m")
        )
    acts = trial.activations
    if acts is not None:
        peak = np.maximum(np.abs(acts.moments.values).max(axis=0, initial=0.0), 1e-9)
        known = [k for k, name in enumerate(acts.moments.names) if name not in acts.unmuscled]
        share = (np.abs(acts.reserve).max(axis=0, initial=0.0) / peak)[known]
        worst = int(np.argmax(share))
        name = acts.moments.names[known[worst]]
        found.append(
            Check(trial.name, f"reserve of {name}, of its peak", 100.0 * float(share[worst]), 100.0 * FLAGGED, "%")
        )
    tracked = trial.tracked
    if tracked is not None:
        for unit, factor, limit, word in (("rad", 180.0 / np.pi, ANGLE_LIMIT, "degrees"), ("m", 1.0, PLACE_LIMIT, "m")):
            own = [k for k, other in enumerate(tracked.units) if other == unit]
            if own:
                worst = max(own, key=lambda k: float(tracked.rms[k]))
                value = factor * float(tracked.rms[worst])
                found.append(
                    Check(trial.name, f"simulation from the recording, {tracked.names[worst]}, RMS", value, limit, word)
                )
    return found


def _greatest(values: Floats, units: Sequence[str], unit: str) -> float:
    own = [k for k in range(values.shape[1]) if units[k] == unit]
    return float(np.linalg.norm(values[:, own], axis=1).max(initial=0.0))


def _headline(trials: Sequence[RecordedTrial], whole: Body) -> list[tuple[str, str]]:
    frames = sum(
        len((one.found.moments if one.found.moments is not None else one.found.coordinates).times) for one in trials
    )
    found = [(f"{whole.mass:.1f} kg", "mass of the model"), (str(len(trials)), "trials"), (str(frames), "frames")]
    cycles = sum(len(cycles_of(one)) for one in trials)
    if cycles:
        found.append((str(cycles), "strides on plates"))
    return found


def _notes(trials: Sequence[RecordedTrial]) -> list[str]:
    """What is to be known before numbers are used."""
    found = []
    for one in trials:
        acts, tracked = one.found.activations, one.found.tracked
        if acts is not None and acts.unconverged:
            found.append(
                f"{one.found.name}: static optimisation did not converge in {number_of(len(acts.unconverged), 'frame')}"
            )
        if tracked is not None and tracked.lost is not None:
            found.append(f"{one.found.name}: the simulation diverged at {tracked.lost:.3g} s")
    return found
