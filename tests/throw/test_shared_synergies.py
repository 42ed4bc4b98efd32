"""Synergies that bind muscles make the torques that motions need."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.shared_synergies import _not_negative, activation_basis
from warpmuscle.throw.signals import Knots, to_activation


@pytest.fixture(scope="module")
def job() -> Job:
    """The sample motion, by the arm of eighteen muscles."""
    return Job(load("throw18"), [], JobOptions(count=5))


def test_knots_become_activations_as_excitations_do(job: Job):
    knots = Knots(job.motions.time)
    values, start = np.random.default_rng(0).random((1, 1, len(knots))), np.array([[0.3]])
    excitation = knots.sampled(values)
    basis = activation_basis(knots, 0.05, len(job.motions.time))
    mine = basis @ np.append(values[0, 0], start)
    np.testing.assert_allclose(mine, to_activation(job.arm, excitation, start)[0, :, 0], atol=1e-12)


def test_five_synergies_of_eighteen_muscles_make_the_torques_and_none_is_one_muscle(job: Job):
    assert job.shared is not None
    weights = job.shared.weights
    assert job.shared.torque_r2.min() > 0.99
    assert job.shared.explained > 0.8
    assert np.all(weights >= 0.0)
    np.testing.assert_allclose(weights.max(axis=0), 1.0)
    assert (weights.max(axis=0) / weights.sum(axis=0)).max() < 0.6
    assert np.all((job.shared.values >= 0.0) & (job.shared.values <= 1.0))


def test_few_muscles_keep_the_synergies_of_their_activations():
    assert Job(load("throw"), [], JobOptions()).shared is None


def test_least_squares_within_bounds_are_scipys():
    rng = np.random.default_rng(0)
    matrix, target = rng.normal(size=(30, 8)), rng.normal(size=30)
    found = _not_negative(matrix.T @ matrix, matrix.T @ target)
    np.testing.assert_allclose(found, lsq_linear(matrix, target, (0.0, np.inf)).x, atol=1e-3)
