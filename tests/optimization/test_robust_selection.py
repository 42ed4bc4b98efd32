"""The candidate that holds up best is chosen by disturbed runs, not by the cost of the search."""

import dataclasses

import msgspec
import numpy as np

from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.robust_selection import RUNS, most_robust
from warpmuscle.scene.parameters import free_parameters, start_values


def test_candidate_that_falls_when_disturbed_is_passed_over(tmp_path, monkeypatch):
    monkeypatch.setattr("warpmuscle.optimization.robust_selection.DURATION", 1.5)
    scene = msgspec.structs.replace(load("fwalk"), duration=0.2)
    result = optimize(scene, 4, 1, "cpu", output=tmp_path / "r.h5", threads=1)
    start = start_values(scene)
    params = np.tile(start, (4, 1))
    names = [parameter.name for parameter in free_parameters(scene)]
    for column, name in enumerate(names):
        if ".feedback." in name or name.endswith(".kp"):
            params[:2, column] = [free_parameters(scene)[column].min] * 2  # these two hardly feel that they fall
    evaluations = dataclasses.replace(result.evaluations, params=params, cost=np.array([1.0, 2.0, 3.0, 4.0]))
    row, held = most_robust(scene, evaluations, 4)
    np.testing.assert_array_equal(params[row], start)
    assert held == RUNS
    assert most_robust(scene, evaluations, 2)[0] < 2
