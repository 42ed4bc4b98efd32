"""The scene of a result with its best parameters."""

from dataclasses import replace

import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import ResultError
from warpmuscle.optimization.best_scene import best_scene
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results.records import Result
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


@pytest.fixture(scope="module")
def result() -> Result:
    """Of a short search for two gains."""
    scene = sound_scene()
    scene.duration, scene.controller.pd["root"].kp = 0.01, Free(10.0, 5.0, 20.0)
    return optimize(scene, 8, 3, "cpu", search="random", command="a command")


def test_free_numbers_start_from_the_best_and_it_is_said_how_they_were_found(result: Result):
    scene, how = best_scene(result)
    np.testing.assert_allclose(start_values(scene), result.best.params)
    assert [p.name for p in free_parameters(scene)] == list(result.parameters.name)
    assert how == f"cost {result.best.cost:.6g} after 8 candidates on cpu: a command"


def test_what_is_fixed_is_free_no_more_and_has_the_best_value(result: Result):
    scene, _ = best_scene(result, ["*.root.kp"])
    assert [p.name for p in free_parameters(scene)] == ["controller.pd.lHip.kp"]
    assert (
        scene.controller.pd["root"].kp
        == dict(zip(result.parameters.name, result.best.params, strict=True))["controller.pd.root.kp"]
    )


def test_the_most_robust_is_another_choice_which_is_said(result: Result, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "warpmuscle.optimization.robust_selection.most_robust", lambda scene, evaluations, count: (5, 18)
    )
    scene, how = best_scene(result, among=4)
    np.testing.assert_allclose(start_values(scene), result.evaluations.params[5])
    assert "the most robust of the best 4, upright in 18 of 20 runs" in how


def test_what_cannot_be_chosen_is_an_error(result: Result):
    with pytest.raises(ResultError, match=r"no free parameter of the name 'character\.\*'"):
        best_scene(result, ["character.*"])
    with pytest.raises(ResultError, match="holds no candidates"):
        best_scene(replace(result, best=None))
    with pytest.raises(ResultError, match="search without stages"):
        best_scene(replace(result, evaluations=None), among=3)
