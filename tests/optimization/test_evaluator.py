"""A scene as a function for optimisers of other libraries: costs and files are those of a search, in any form."""

import msgspec
import numpy as np
import pytest

import warpmuscle as wm
from small_scene import sound_scene
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.optimization.best_scene import best_scene
from warpmuscle.optimization.evaluator import Evaluator
from warpmuscle.optimization.unit_cube import from_unit
from warpmuscle.scene.parameters import start_values


@pytest.fixture(scope="module")
def scene():
    return msgspec.structs.replace(load("fwalk"), duration=0.2)


@pytest.fixture(scope="module")
def evaluator(scene):
    return Evaluator(scene, device="cpu")


def candidates(of: Evaluator, count: int) -> np.ndarray:
    return np.random.default_rng(4).uniform(of.lower, of.upper, (count, len(of.names)))


def test_costs_are_those_of_a_rollout_and_depend_on_no_neighbour(scene, evaluator):
    values = candidates(evaluator, 3)
    values[0] = evaluator.start
    cost = evaluator(values)
    rollout = wm.Rollout(scene, 3, "cpu")
    rollout.set_parameters(values)
    rollout.run()
    np.testing.assert_array_equal(cost, rollout.cost())
    np.testing.assert_array_equal(evaluator(values[1:2]), cost[1:2])
    np.testing.assert_array_equal(evaluator.start, start_values(scene))


def test_one_candidate_has_one_cost_as_row_or_table_by_name(evaluator):
    start = dict(zip(evaluator.names, evaluator.start.tolist(), strict=True))
    alone = evaluator(evaluator.start)
    assert isinstance(alone, float)
    assert evaluator(start) == alone
    np.testing.assert_array_equal(evaluator([start, dict(reversed(start.items()))]), [alone, alone])


def test_the_unit_cube_is_that_of_a_search(scene):
    cube = Evaluator(scene, unit_cube=True, device="cpu")
    points = candidates(cube, 2)
    assert cube.lower.tolist() == [0.0] * len(cube.names)
    found = cube.evaluate(points)
    np.testing.assert_array_equal(found.params, from_unit(wm.Rollout(scene).parameters, points))


def test_what_was_evaluated_is_kept_call_by_call_and_written_as_a_search_is(scene, tmp_path):
    evaluator = Evaluator(scene, device="cpu")
    first, second = candidates(evaluator, 3), evaluator.start[None]
    costs = np.concatenate([evaluator(first), evaluator(second)])
    evaluator.write(tmp_path / "mine.h5", "mine.py")
    result = wm.read(tmp_path / "mine.h5")
    np.testing.assert_array_equal(result.evaluations.cost, costs)
    assert result.evaluations.generation.tolist() == [0, 0, 0, 1]
    assert np.all(result.evaluations.status == Status.COMPLETED)
    assert result.best.cost == costs.min()
    assert result.command == "mine.py"
    best, _ = best_scene(result)
    np.testing.assert_array_equal(start_values(best), result.best.params)
    rollout = wm.Rollout(best, device="cpu", record=[0])
    rollout.run()
    np.testing.assert_array_equal(rollout.recording().coordinate, result.replays[0].coordinate)


def test_rounding_at_a_limit_is_forgiven_and_no_more(evaluator):
    beyond = evaluator.start.copy()
    beyond[0] = evaluator.upper[0] * (1.0 + 1e-12)
    assert evaluator.evaluate(beyond).params[0, 0] == evaluator.upper[0]
    beyond[0] = evaluator.upper[0] + 1.0
    with pytest.raises(ArgumentError, match=rf"candidates\[0\]: {evaluator.names[0]} must lie between "):
        evaluator(beyond)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ([[1.0, 2.0]], r"candidates have shape \(1, 2\); this evaluator takes \(n, \d+\)"),
        ([np.nan], r"candidates\[0\]: .* must lie between .*, not nan"),
        ("walk", "candidates must be an array of numbers, not 'walk'"),
        ({"nothing": 1.0}, r"candidates\[0\]: there is no parameter nothing; the parameters are "),
        ({}, r"candidates\[0\]: no value of "),
        ([{}, 3.0], r"candidates\[0\]: no value of "),
        (None, "candidates must be an array of numbers"),
    ],
)
def test_what_is_no_candidate_is_refused_in_one_line(evaluator, wrong, told):
    if wrong == [np.nan]:
        wrong = np.full(len(evaluator.names), np.nan)
    with pytest.raises(ArgumentError, match=told) as error:
        evaluator(wrong)
    assert "\n" not in str(error.value)


def test_no_candidates_have_no_costs_and_nothing_to_write(scene, tmp_path):
    evaluator = Evaluator(scene, device="cpu")
    assert evaluator([]).shape == (0,)
    with pytest.raises(Error, match="no candidate was evaluated yet"):
        evaluator.write(tmp_path / "mine.h5")
    assert not (tmp_path / "mine.h5").exists()


def test_numbers_are_freed_and_changed_by_their_paths():
    free = {"value": 16.0, "min": 10.0, "max": 20.0}
    evaluator = Evaluator(
        "moment_arm_angle", set={"duration": 0.01, "character.bodies.pelvis.mass": free}, device="cpu"
    )
    assert "character.bodies.pelvis.mass" in evaluator.names


def test_scenes_without_free_numbers_or_with_stages_are_refused():
    fixed = sound_scene()
    fixed.controller.pd["lHip"] = fixed.controller.pd["root"]
    with pytest.raises(Error, match="no free parameters"):
        Evaluator(fixed, device="cpu")
    with pytest.raises(Error, match="has stages, which have a cost each; search it with optimize"):
        Evaluator("walk56_curriculum", device="cpu")
