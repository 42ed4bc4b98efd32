"""Activations of a walk beside recorded EMG."""

import sys
from pathlib import Path

import numpy as np
import pytest
import warp  # noqa: F401  what is tested launches kernels

from warpmuscle.core.errors import Error

TOOLS = Path(__file__).parents[2] / "tools" / "research"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import gait_activations  # noqa: E402


def test_likeness_is_the_correlation_over_the_cycle():
    wave = np.sin(np.linspace(0.0, 2.0 * np.pi, 101))
    assert gait_activations.likeness(wave, 3.0 * wave + 1.0) == pytest.approx(1.0)
    assert gait_activations.likeness(wave, -wave) == pytest.approx(-1.0)


def test_calves_work_in_late_stance_and_shins_in_swing_in_people_and_in_the_walk(monkeypatch, reference_data):
    monkeypatch.setattr(gait_activations, "DURATION", 4.0)
    for curves in (gait_activations.emg(reference_data), gait_activations.activation("walk56_person")):
        assert all(curve.shape == (101,) and curve.max() == 1.0 for curve in curves.values())
        assert 35 < np.argmax(curves["SOL"]) < 60
        assert curves["TA"][60:80].mean() > 3.0 * curves["TA"][20:40].mean()


def test_where_there_is_no_emg_it_says_where_to_look(tmp_path):
    with pytest.raises(Error, match="set WARPMUSCLE_REFERENCE_DATA"):
        gait_activations.main(["walk56_person"], data=tmp_path)
