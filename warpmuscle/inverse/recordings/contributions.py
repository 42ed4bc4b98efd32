"""What muscles, gravity and velocities each contribute to the accelerations of a recorded motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.arguments import as_truth
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import CoordinatesLike, Prepared, prepare
from warpmuscle.inverse.trial import Loads
from warpmuscle.scene.topology import coordinate_names
from warpmuscle.studies.inverse_dynamics import (
    body_accelerations,
    body_motions,
    body_points,
    inverse_dynamics,
    joint_space,
)

TOUCHES = 20.0  # N, from which on a load is a contact


@dataclass(frozen=True)
class Contributions:
    """Accelerations of S speeds and forces of L contacts in F frames, by contributor.

    Attributes:
        names: (N,) of contributors: muscles, then `gravity`, `velocity`, `reserves`, and `loads` where these are no
            contacts. speeds: (S,) `root.x` and so on, m/s^2 and rad/s^2, as a scene names them.
        acceleration: (F, N, S). ground: (F, N, L, 3) N, world axes. remainder: (F, S) measured, beyond the sum.
    """

    names: tuple[str, ...]
    speeds: tuple[str, ...]
    times: Floats
    acceleration: Floats
    ground: Floats
    remainder: Floats


def contributions(
    body: BodyModel, coordinates: CoordinatesLike, activations: Activations, loads: Loads | None = None,
    *, filter: float | None = None, exact_rates: bool = False, contacts: bool = False,
) -> Contributions:  # fmt: skip
    """Accelerations that every muscle would cause alone, in the poses of a motion.

    Args:
        coordinates, loads, filter, exact_rates: those with which the activations were found.
        contacts: let the point where a load of more than 20 N acts keep its place, so that each contributor brings its
            own force of the ground (Lin et al. 2011); else recorded loads are one contributor, and the sum is exact.

    Raises:
        ArgumentError: activations of another model, coordinates that follow others, or see `static_optimization`.
    """
    as_truth(contacts, "contacts")
    if activations.muscles != body.muscles:
        raise ArgumentError("the activations are of muscles of another model")
    trials = prepare(body, coordinates, loads, filter, activations.times, exact_rates, of_speeds=True).of_speeds
    states, scene = trials.states, body.scene
    space = joint_space(scene, states.coordinates)
    dynamics = body.dynamics(states, trials.loads)
    if np.abs(dynamics.followed).max(initial=0.0) > 0.0:
        raise ArgumentError("contributions to accelerations need a model none of whose coordinates follows another")
    pull = _pulls(body, trials, activations)
    velocity = -space.gravity - inverse_dynamics(scene, states.coordinates, states.speeds, np.zeros_like(states.speeds))
    others = {"gravity": space.gravity, "velocity": velocity, "reserves": dynamics.effort - pull.sum(axis=1)}
    if not contacts:
        whole = inverse_dynamics(scene, states.coordinates, states.speeds, states.rates)
        others["loads"] = whole - dynamics.effort
    forces = np.concatenate([pull, np.stack(list(others.values()), axis=1)], axis=1)
    found = np.swapaxes(np.linalg.solve(space.mass_matrix, np.swapaxes(forces, 1, 2)), 1, 2)
    names = (*body.muscles, *others)
    ground = np.zeros((*found.shape[:2], len(trials.loads.body), 3))
    if contacts:
        found, ground = _on_contacts(body, trials, space.mass_matrix, found, names.index("velocity"))
    speeds = coordinate_names(body.topology, scene.character)[1]
    return Contributions(names, speeds, activations.times, found, ground, states.rates - found.sum(axis=1))


def _pulls(body: BodyModel, trials: Prepared, activations: Activations) -> Floats:
    """Generalised forces (F, M, S) of muscles."""
    found = np.zeros((len(activations.times), len(body.muscles), body.topology.speeds))
    for part in body.chunks(len(found)):
        arms = body.muscle_frames(trials.states, part).moment_arm.numpy()[:, : len(body.lever_muscle)]
        pulls = arms * activations.force[part][:, body.lever_muscle]
        np.add.at(np.moveaxis(found[part], 0, 2), (body.lever_muscle, body.lever_speed), pulls.T)
    return found


def _on_contacts(body: BodyModel, trials: Prepared, mass: Floats, free: Floats, velocity: int) -> tuple[Floats, Floats]:
    """Accelerations (F, N, S) and forces (F, N, L, 3) where points of contact stay, of accelerations without them."""
    frames, count, speeds = free.shape
    jacobian, bias = _points(body, trials)
    touching = np.linalg.norm(trials.loads.force, axis=2) > TOUCHES  # (F, L)
    jacobian = (jacobian * touching[:, :, None, None]).reshape(frames, -1, speeds)
    spread = np.linalg.solve(mass, np.swapaxes(jacobian, 1, 2))  # (F, S, 3 L)
    moved = np.einsum("fcs,fns->fnc", jacobian, free)
    moved[:, velocity] += (bias * touching[:, :, None]).reshape(frames, -1)
    against = np.linalg.pinv(jacobian @ spread, rcond=1e-9, hermitian=True)
    force = -np.einsum("fcd,fnd->fnc", against, moved)
    return free + np.einsum("fsc,fnc->fns", spread, force), force.reshape(frames, count, -1, 3)


def _points(body: BodyModel, trials: Prepared) -> tuple[Floats, Floats]:
    """Accelerations (F, L, 3, S) of points of loads by a unit of each speed's, and (F, L, 3) by the speeds alone."""
    states, scene = trials.states, body.scene
    still = np.zeros_like(states.speeds)
    names = [body.topology.bodies[number] for number in trials.loads.body]
    places = body_points(scene, states.coordinates)

    def of(speeds: Floats, rates: Floats) -> Floats:
        bodies = body_accelerations(scene, states.coordinates, speeds, rates)
        motions = body_motions(scene, states.coordinates, speeds)
        found = np.zeros((len(still), len(names), 3))
        for k, name in enumerate(names):
            arm, spin = trials.loads.point[:, k] - places[name][0], motions[name].angular_velocity
            place, turn = bodies[name]
            found[:, k] = place + np.cross(turn, arm) + np.cross(spin, np.cross(spin, arm))
        return found

    by_unit = [of(still, still + unit) for unit in np.eye(still.shape[1])]
    return np.stack(by_unit, axis=-1), of(states.speeds, still)
