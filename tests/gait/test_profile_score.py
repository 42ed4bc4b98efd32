"""The Gait Profile Score against its formulas, on curves with known differences from the norm."""

import numpy as np
import pytest

from warpmuscle.gait.profile_score import DEVIATION, LEAST_DIFFERENCE, OF_PELVIS, people, profile_scores, variable_score


def test_a_curve_that_is_off_by_a_constant_has_that_as_its_score():
    for norm in people().values():
        assert norm.shape == (101,)
        assert variable_score(norm, norm) == 0.0
        assert variable_score(norm - 3.5, norm) == pytest.approx(3.5)


def test_a_curve_that_is_off_by_a_wave_has_the_root_mean_square_of_it():
    wave = 4.0 * np.sin(2.0 * np.pi * np.arange(101) / 100.0)
    assert variable_score(people()["Knee flexion"] + wave, people()["Knee flexion"]) == pytest.approx(
        4.0 / np.sqrt(2.0)
    )


def test_scores_of_several_variables_are_the_root_of_the_mean_of_squares_and_the_pelvis_counts_once():
    scores = {name: {"left": 3.0, "right": 4.0} for name in ("Hip flexion", "Knee flexion", "Ankle dorsiflexion")}
    scores |= {name: {"left": 6.0, "right": 100.0} for name in OF_PELVIS}
    found = profile_scores(scores)
    assert found["left"] == pytest.approx(np.sqrt((3 * 9.0 + 2 * 36.0) / 5))
    assert found["right"] == pytest.approx(np.sqrt((3 * 16.0 + 2 * 1e4) / 5))
    assert found["both"] == pytest.approx(np.sqrt((3 * 9.0 + 3 * 16.0 + 2 * 36.0) / 8))
    assert profile_scores({}) == {}


def test_what_differences_mean_is_as_published():
    assert (LEAST_DIFFERENCE, DEVIATION) == (1.6, 1.4)  # Baker 2012, Gait & Posture 35:612, abstract
