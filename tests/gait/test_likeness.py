"""Distances from published norms: none inside their span, in standard deviations outside, at the speed of the gait."""

import json
from pathlib import Path

import numpy as np
import pytest

from small_result import walk_scene
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.likeness import (
    CLASSES,
    TRENDS,
    dimensionless_speed,
    from_norm,
    leg_length,
    means_at,
    norms_of,
    outside_span,
    trend,
)
from warpmuscle.scene.norms import LEG_ANGLES
from warpmuscle.scene.parameters import start_values, substitute


@pytest.mark.parametrize("name", LEG_ANGLES)
def test_nothing_between_the_norms_is_outside_and_beyond_them_their_standard_deviation_counts(name: str):
    means, sds = means_at([norm.angles[name] for norm in norms_of(running=False)])
    for part in (0.0, 0.3, 1.0):
        assert outside_span(part * means[0] + (1.0 - part) * means[1], means, sds) == 0.0
    above = means.max(axis=0) + 2.0 * sds.mean(axis=0)
    below = means.min(axis=0) - 0.5 * sds.mean(axis=0)
    assert outside_span(above, means, sds) == pytest.approx(2.0)
    assert outside_span(below, means, sds) == pytest.approx(0.5)
    assert from_norm(means[1] - 0.7 * sds[1], means[1], sds[1]) == pytest.approx(0.7)


def test_published_norms_differ_from_each_other_so_that_none_is_the_judge():
    apart = {}
    for name in LEG_ANGLES:
        means, sds = means_at([norm.angles[name] for norm in norms_of(running=False)])
        apart[name] = float(np.mean((np.abs(means[0] - means[1]) / sds.mean(axis=0))[:-1]))
    assert apart["Ankle dorsiflexion"] > 1.0 > apart["Hip flexion"]


@pytest.mark.parametrize("mode", ["walk", "run"])
def test_measured_norms_are_the_published_numbers(mode: str, reference_data: Path):
    data = json.loads((reference_data / "gait_norms/fukuchi.json").read_text())
    (norm,) = [norm for norm in norms_of(mode == "run") if norm.source.startswith("Fukuchi")]
    percent = np.array(data["percent_of_stride"], dtype=float)
    for name, joint in zip(LEG_ANGLES, ("hip", "knee", "ankle"), strict=True):
        np.testing.assert_array_equal(norm.angles[name].mean(percent), data[mode][joint]["mean"])
        np.testing.assert_array_equal(norm.angles[name].sd(percent), data[mode][joint]["sd"])
    assert f"{data[mode]['speed_m_s']:g} m/s" in norm.what


@pytest.mark.parametrize("name", LEG_ANGLES)
def test_norms_move_by_the_trend_of_their_extremes_and_not_at_free_speed(name: str):
    assert np.abs(trend(name, CLASSES[2])).max() == 0.0
    for index, speed in enumerate(CLASSES):
        moved = trend(name, speed)
        for percent, values in TRENDS[name]:
            expected = 0.0 if values is None else values[index] - values[2]
            assert moved[percent == PERCENT] == pytest.approx(expected)
    np.testing.assert_array_equal(trend(name, 0.0), trend(name, CLASSES[0]))
    np.testing.assert_array_equal(trend(name, 9.0), trend(name, CLASSES[-1]))
    between = trend(name, 0.5 * (CLASSES[1] + CLASSES[2]))
    np.testing.assert_allclose(between, 0.5 * trend(name, CLASSES[1]), atol=1e-12)


def test_a_leg_reaches_from_the_hip_to_the_sole_and_gives_its_speed_a_scale():
    scene = substitute(walk_scene(), start_values(walk_scene()))
    length = leg_length(scene)
    # Of the scene: thigh 0.21 + 0.26 m, shank from (0.21, 0) to (-0.25, 0.01), the sole 0.033 below a foot's middle.
    assert length == pytest.approx(0.47 + np.hypot(0.46, 0.01) + 0.02 + 0.033)
    assert dimensionless_speed(-1.2, length) == pytest.approx(1.2 / np.sqrt(9.81 * length))
