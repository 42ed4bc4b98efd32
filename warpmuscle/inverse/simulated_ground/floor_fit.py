"""A recording is put onto the ground: how high its floor lies, how thick the soles are, and whether a belt moved.

Soles and a slow change of the root's height are those with which spheres at the recorded places of the feet push as the
plates measured, with their centre of pressure. What is left of the errors of markers and models, some mm, is left to
the plan. The belt of a treadmill moves as the points of the feet do that carry most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyLoads, BodyModel, Dynamics
from warpmuscle.inverse.recordings.belt import FEW, loaded_velocity
from warpmuscle.inverse.simulated_ground.foot_contact import HERTZ, Foot, places
from warpmuscle.scene.joints import root_type

EVERY = 0.25  # s, between heights of the root
SOLE = 0.01  # m, in the mean
UNEVEN, STEP = 0.003, 0.005  # m, by which soles differ from one another, and heights from those before
FIRMER = 0.5  # logarithm of a factor by which the ground may well be firmer or softer than published spheres
TRUST = 0.1, 0.005  # of the greatest force, and times m, by which forces and their moments may be missed
FRAMES = 3  # that a trial's count as: errors of neighbours are alike
CARRIED = 20.0  # N, that one of the feet carries at some time at least
LOW = 0.1  # quantile of a point's heights that is on the floor


class Recorded(NamedTuple):
    """Where the feet of a trial are, and what plates measured below them."""

    times: Floats  # (n,) s
    place: Floats  # (n, 2, P, 3) m, of points
    force: Floats  # (n, 2, 3) N, world axes
    moment: Floats  # (n, 2, A) N m, upward force times its place along A axes of the world
    axes: tuple[int, ...]  # these, that the model's root moves along


class Floor(NamedTuple):
    """How a recording lies on the ground."""

    sole: Floats  # (P,) m, see `foot_contact.scene_on_ground`
    firmness: float  # of published spheres
    times: Floats  # (H,) s
    lift: Floats  # (H,) m, by which the root is lifted then
    belt: Floats  # (3,) m/s, of the ground below the recording, world axes


def recorded(body: BodyModel, feet: tuple[Foot, Foot], times: Floats, dynamics: Dynamics, loads: BodyLoads) -> Recorded:
    """What a trial says of its floor; raises ArgumentError if no loads act on the feet."""
    axes = tuple(axis for axis in root_type(body.scene.character).moving if axis != 1)
    force, moment = np.zeros((len(times), 2, 3)), np.zeros((len(times), 2, len(axes)))
    for side, foot in enumerate(feet):
        near = {foot.body, body.topology.parents[foot.body]}
        near |= {k for k, parent in enumerate(body.topology.parents) if parent == foot.body}
        own = [k for k, number in enumerate(loads.body) if number in near]
        force[:, side] = loads.force[:, own].sum(axis=1)
        up = loads.force[:, own, 1]
        moment[:, side] = np.einsum("nl,nlk->nk", up, loads.point[:, own][..., axes])
    if force[..., 1].max(initial=0.0) < CARRIED:
        raise ArgumentError("a motion is put onto the ground by the forces under its feet; give loads, or find them "
                            "without plates")  # fmt: skip
    return Recorded(times, np.stack([places(foot, dynamics) for foot in feet], axis=1), force, moment, axes)


def fit_floor(trial: Recorded, known: Floor | None = None) -> Floor:
    """The floor of a trial; soles and firmness are those of another trial, if one is given."""
    from scipy.optimize import least_squares

    count, times = trial.place.shape[2], trial.times
    knots = np.linspace(times[0], times[-1], max(round((times[-1] - times[0]) / EVERY), 1) + 1)
    most = float(trial.force[..., 1].max())
    fewer = np.sqrt(max(len(times) / FRAMES, 1.0))
    own = count + 1 if known is None else 0  # numbers of the feet, before those of heights

    def parts(x: Floats) -> tuple[Floats, float, Floats]:
        return (x[:count], float(x[count]), x[own:]) if known is None else (known.sole, np.log(known.firmness), x)

    def forces(x: Floats) -> Floats:
        soles, firmer, lifts = parts(x)
        deep = np.maximum(soles - trial.place[..., 1] - np.interp(times, knots, lifts)[:, None, None], 0.0)
        return np.asarray(HERTZ * np.exp(firmer) * deep**1.5)

    def errors(x: Floats) -> Floats:
        soles, firmer, lifts = parts(x)
        force = forces(x)
        moment = np.einsum("nfp,nfpk->nfk", force, trial.place[..., trial.axes])
        return np.concatenate(
            [
                (soles - SOLE) / UNEVEN, [firmer / FIRMER], np.diff(lifts) / STEP,
                ((force.sum(axis=2) - trial.force[..., 1]) / (TRUST[0] * most * fewer)).ravel(),
                ((moment - trial.moment) / (TRUST[1] * most * fewer)).ravel(),
            ]
        )  # fmt: skip

    start = np.full(len(knots), SOLE - float(np.quantile(trial.place[..., 1], LOW, axis=0).mean()))
    feet = [] if known is not None else [np.full(count, SOLE), np.zeros(1)]
    x = least_squares(errors, np.concatenate([*feet, start])).x
    soles, firmer, lifts = parts(x)
    return Floor(soles, float(np.exp(firmer)), knots, lifts, _belt(trial, forces(x)))


def fit_floors(trials: list[Recorded]) -> list[Floor]:
    """The floors of several trials of one subject, with the same soles."""
    first = [fit_floor(trial) for trial in trials]
    if len(first) == 1:
        return first
    sole = np.asarray(np.mean([one.sole for one in first], axis=0))
    firmness = float(np.exp(np.mean(np.log([one.firmness for one in first]))))
    return [fit_floor(trial, first[0]._replace(sole=sole, firmness=firmness)) for trial in trials]


def _belt(trial: Recorded, force: Floats) -> Floats:
    """Velocity (3,) of the points, of which half of the force is carried by slower ones; none along what is slow."""
    if len(trial.times) < FEW or force.max(initial=0.0) <= 0.0:
        return np.zeros(3)
    return loaded_velocity(np.gradient(trial.place, trial.times, axis=0), force)
