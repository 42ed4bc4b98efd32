"""Contributions to accelerations add up to those of the motion, and contacts keep their place."""

import numpy as np
import pytest

from small_leg import loads, motion, small_leg
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.recordings.contributions import contributions
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.studies.inverse_dynamics import body_accelerations, body_points, inverse_dynamics

pytestmark = [
    pytest.mark.usefixtures("unoptimized_kernels"),
    pytest.mark.filterwarnings("ignore:the force .* acts .* away"),
]


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    body, walk = BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu"), motion(6)
    forces = loads(walk.times)
    return body, walk, static_optimization(body, walk, forces, reserve=10.0), forces


def test_contributions_add_up_to_the_recorded_accelerations(trial):
    found = contributions(*trial)
    assert found.names[-4:] == ("gravity", "velocity", "reserves", "loads")
    assert found.acceleration.shape == (6, len(found.names), len(found.speeds))
    assert np.abs(found.acceleration.sum(axis=1)).max() > 1.0
    np.testing.assert_allclose(found.remainder, 0.0, atol=1e-3 * np.abs(found.acceleration).max())


def test_a_muscles_acceleration_needs_its_moments(trial):
    body, walk, activations, forces = trial
    found = contributions(*trial)
    states = prepare(body, walk, forces, None, activations.times, False, of_speeds=True).of_speeds.states
    still = np.zeros_like(states.speeds)
    k = found.names.index("rectus")
    held = inverse_dynamics(body.scene, states.coordinates, still, still)
    moments = inverse_dynamics(body.scene, states.coordinates, still, found.acceleration[:, k]) - held
    arms = body.muscle_frames(states, slice(0, 6)).moment_arm.numpy().astype(float)
    expected = np.zeros_like(moments)
    for lever in np.flatnonzero(body.lever_muscle == k):
        expected[:, body.lever_speed[lever]] += arms[:, lever] * activations.force[:, k]
    assert np.abs(expected).max() > 0.01
    np.testing.assert_allclose(moments, expected, atol=1e-6 * np.abs(expected).max())


def test_with_contacts_every_contributor_brings_its_own_force_of_the_ground(trial):
    found, free = contributions(*trial, contacts=True), contributions(*trial)
    assert found.names == free.names[:-1]
    assert found.ground.shape == (6, len(found.names), 1, 3)
    k = found.names.index("gravity")
    assert found.ground[:, k, 0, 1].min() > 0.0  # the ground carries
    body, walk, activations, forces = trial
    ready = prepare(body, walk, forces, None, activations.times, False, of_speeds=True)
    q, still = ready.states.coordinates, np.zeros_like(ready.states.speeds)
    foot = body.topology.bodies[ready.loads.body[0]]
    arm = ready.loads.point[:, 0] - body_points(body.scene, q)[foot][0]

    def moved(by: np.ndarray) -> np.ndarray:
        place, turn = body_accelerations(body.scene, q, still, by)[foot]
        return np.abs(place + np.cross(turn, arm))

    assert moved(free.acceleration[:, k]).max() > 1.0
    for name in ("gravity", "rectus", "reserves"):
        assert moved(found.acceleration[:, found.names.index(name)]).max() < 1e-6


def test_activations_of_another_model_are_refused(trial):
    body, walk, activations, _ = trial
    other = BodyModel(body.scene, "cpu")
    other.muscles = other.muscles[1:]
    with pytest.raises(ArgumentError, match="another model"):
        contributions(other, walk, activations)
