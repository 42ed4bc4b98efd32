"""Channels of EMG are calibrated together with muscles."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.scene.parameters import start_values
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.computed_synergies import computed_excitation
from warpmuscle.throw.measured import calibrate, driven
from warpmuscle.throw.motion import ArmMotions, resample
from warpmuscle.throw.recordings.arm_motions import motion_of

LATE = 0.03  # s, by which activations are behind the envelopes


@pytest.fixture(scope="module")
def arm() -> Arm:
    """With muscles as strong as groups, which are those of the truth."""
    return Arm(load("throw_groups"))


@pytest.fixture(scope="module")
def motions(arm: Arm) -> ArmMotions:
    return resample([motion_of(arm.scene, arm)])


def test_gains_and_delays_of_channels_are_found_again(arm: Arm, motions: ArmMotions):
    excitation = computed_excitation(arm, motions)[1]
    gain = np.array([0.5, 1.6, 0.6, 0.8, 1.5, 0.7])
    early = driven(motions, excitation, range(6), np.ones((1, 6)), np.full((1, 6), -LATE))[0]
    found = calibrate(arm, motions, early / gain, arm.unknowns(start_values(arm.scene)), [0])
    assert found.torque_r2[0].min() < 0.7
    assert found.torque_r2[1].min() > 0.97
    active = excitation[0].max(axis=0) > 0.1  # the others tell little of their channels
    assert active.sum() >= 4
    np.testing.assert_allclose(np.log(found.gain / gain)[active], 0.0, atol=0.35)  # strength may change as well
    np.testing.assert_allclose(found.delay[active], LATE, atol=0.015)


def test_a_delay_and_a_gain_move_and_scale_an_envelope(motions: ArmMotions):
    envelope = np.zeros((1, len(motions.time), 2))
    envelope[0, 50, 0] = 0.4
    made = driven(motions, envelope, [0, 1], np.array([[2.0, 1.0], [9.0, 1.0]]), np.array([[0.1, 0.0], [0.0, 0.0]]))
    assert made.shape == (2, 1, len(motions.time), 2)
    assert made[0, 0, :, 0].argmax() == 60
    assert made[0, 0, 60, 0] == pytest.approx(0.8)
    assert made[1].max() == 1.0  # never more than all
