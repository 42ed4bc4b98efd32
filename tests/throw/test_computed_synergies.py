"""Activations, excitations and synergies that are computed from motions."""

import numpy as np

from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.computed_synergies import computed_excitation, computed_synergies, sparsest
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion import ArmMotion, resample
from warpmuscle.throw.signals import computed_activation, to_activation, to_excitation


def test_computed_activations_make_the_torques_that_the_motion_needs(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, motion = arm_and_motion
    strong = Job(arm.scene, [], JobOptions()).strong
    motions = resample([motion])
    unknowns = np.zeros(0)
    activation, found = computed_activation(strong, motions, unknowns)
    angle, speed = motions.angles[0][0], motions.angles[1][0]
    made = strong.muscle_table(unknowns[None]).torques(activation[0], angle, speed)[0].sum(axis=1)
    needed = needed_torques(strong, motions)[0]
    np.testing.assert_allclose(made[found.feasible], needed[found.feasible], atol=1e-3)
    assert found.feasible.mean() > 0.97


def test_excitations_lead_back_to_the_activations_that_they_are_computed_from(arm_and_motion: tuple[Arm, ArmMotion]):
    arm, _ = arm_and_motion
    time = np.arange(0.0, 1.5, 0.01)
    activation = (0.4 + 0.3 * np.sin(4.0 * time))[None, :, None]
    back = to_activation(arm, to_excitation(arm, activation), activation[:, 0])
    np.testing.assert_allclose(back, activation, atol=0.03)


def test_activations_start_where_the_motion_has_them_and_not_at_the_first_excitation(
    arm_and_motion: tuple[Arm, ArmMotion],
):
    """A relaxing muscle is told less than it still does: what it is told before the file begins is in nothing else."""
    arm, motion = arm_and_motion
    motions = resample([motion])
    strong = Job(arm.scene, [], JobOptions()).strong
    activation, excitation, _ = computed_excitation(strong, motions)
    synergies, _ = computed_synergies(arm, motions, strong, 6)
    assert np.abs(excitation[0, 0] - activation[0, 0]).max() > 0.05
    np.testing.assert_allclose(synergies.excitation(synergies.start)[0], activation[0, 0], atol=0.02)


def test_ties_that_other_synergies_can_take_over_are_undone():
    """Of the first muscle and the last, which have synergies of their own; the other two share one and stay tied."""
    weights = np.array([[1.0, 0.47, 0.0], [0.0, 1.0, 0.0], [0.0, 0.4, 0.0], [0.02, 0.0, 1.0]])
    expected = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 1.0]]
    np.testing.assert_array_equal(sparsest(weights), expected)
