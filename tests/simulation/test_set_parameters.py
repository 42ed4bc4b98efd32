"""A batch whose parameters change in place has the model that it would have if it were built anew."""

import numpy as np
import pytest
import warp as wp

from short_walks import short_walk
from warpmuscle.core.arrays import arrays_of, repeat_rows, times_repeated
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load, scene_names
from warpmuscle.model.build import build_model, parts_of
from warpmuscle.optimization.unit_cube import from_unit
from warpmuscle.scene.parameters import free_numbers, free_parameters, substitute
from warpmuscle.simulation.rollout import Rollout

DRAWN = np.random.default_rng(5)


def values_of(struct) -> list[bytes]:
    return [array.numpy().tobytes() for array in arrays_of(struct)]


@pytest.mark.parametrize("name", scene_names())
def test_models_of_new_values_are_those_built_anew(name: str):
    scene = load(name)
    paths = [path for path, _, _ in free_numbers(scene)]
    parts = parts_of(paths) if paths else None
    if parts is None:
        return  # nothing is free, or something for which the whole model is made again
    candidates, runs, parameters = 3, 2, free_parameters(scene)
    rollout = Rollout(scene, candidates * runs, "cpu")
    for _ in range(2):
        values = from_unit(parameters, DRAWN.uniform(size=(candidates, len(parameters))))
        every = np.repeat(values, runs, axis=0)
        rollout.set_parameters(every)
        anew = build_model(substitute(rollout.scene, every), rollout.structure, "cpu", rollout._inputs.of_model)
        assert values_of(rollout.model) == values_of(anew)
        numeric = build_model(rollout.numeric, rollout.structure, "cpu", rollout._inputs.of_model)
        assert values_of(numeric) == values_of(anew)


@pytest.mark.parametrize(
    ("name", "parts"),
    [("run56_search", ("controller",)), ("walk56_search", ("muscle laws", "excitations", "controller"))],
)
def test_there_are_scenes_with_free_muscles_and_with_controllers_alone(name: str, parts: tuple[str, ...]):
    assert parts_of([path for path, _, _ in free_numbers(load(name))]) == parts


def test_numbers_of_bodies_and_paths_may_be_anywhere():
    assert parts_of(["controller.pd.kp", "character.bodies.torso.mass"]) is None
    assert parts_of(["character.muscles.soleus.path.0.position"]) is None
    assert parts_of(["character.muscles.soleus.l_opt"]) == ("muscle laws", "excitations")


@pytest.mark.parametrize(
    ("counts", "expected"), [([3, 3, 3], 3), ([4], 4), ([1, 1], 1), ([2, 3, 1], 1), ([2, 2, 3], 1), ([1, 2, 3], 1)]
)
def test_repeated_rows_are_found_where_all_are_repeated_equally(counts: list[int], expected: int):
    rows = np.repeat(np.arange(2 * len(counts), dtype=float).reshape(-1, 2), counts, axis=0)
    assert times_repeated(rows) == expected


@pytest.mark.parametrize("device", [str(device) for device in wp.get_devices()])
def test_rows_are_repeated_and_other_arrays_stay(device: str):
    values = DRAWN.uniform(size=(5, 3, 4)).astype(np.float32)
    array = repeat_rows(wp.array(values, dtype=wp.vec4, device=device), 5, 3)
    np.testing.assert_array_equal(array.numpy(), np.repeat(values, 3, axis=0))
    for other in (wp.zeros(5, dtype=float, device=device), wp.zeros((4, 2), dtype=float, device=device)):
        assert repeat_rows(other, 5, 3) is other


@pytest.mark.parametrize("shape", [(3,), (2, 3), (4, 2), (1, 3, 2), ()])
def test_parameters_of_another_shape_are_refused(shape: tuple):
    with pytest.raises(RolloutError, match=r"this rollout takes \(3, 2\) or \(2,\)"):
        Rollout(short_walk(), 3, "cpu").set_parameters(np.ones(shape))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_parameters_that_are_not_finite_are_refused(value: float):
    with pytest.raises(RolloutError, match="not a finite number"):
        Rollout(short_walk(), 1, "cpu").set_parameters([300.0, value])
