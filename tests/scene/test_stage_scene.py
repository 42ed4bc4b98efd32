"""The scene of a stage: only what it frees is free, and what it replaces is replaced."""

import numpy as np
import pytest
from msgspec.structs import replace

from small_scene import sound_scene
from warpmuscle.scene import PD, Scene, SearchStage
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, pinned, start_values
from warpmuscle.scene.stage_scene import freed, stage_scene, without_only_stage
from warpmuscle.scene.validation.scene import check_scene

NAMES = ["failure.com_height", "objective.speed", "controller.states.0.time", "controller.pd.lHip.kp"]


@pytest.fixture
def scene() -> Scene:
    """A scene with four parameters, one of which rules two numbers."""
    scene = sound_scene()
    scene.controller.states[0].time = Free(0.7, 0.5, 0.9)
    scene.controller.pd["rHip"] = PD(Free(same_as="controller.pd.lHip.kp", factor=2.0), 1.0)
    scene.objective.speed = Free(1.0, 0.0, 3.0)
    scene.failure.com_height = Free(0.9, 0.5, 1.0)
    scene.stages = [
        SearchStage(
            "a", {"torque": 0.0, "speed": 2.0}, {"body_contact": True, "heading": 0.5}, 3.0, {"runs": 4, "slope": 0.1}
        ),
        SearchStage("b", free=["controller.pd.*", "objective.*"]),
        SearchStage("c", {"metabolic_model": "umberger"}, free=["*.com_h?ight"]),
    ]
    check_scene(scene)
    return scene


def values_of(scene: Scene, values: dict[str, float]):
    """Start values with other ones of some names."""
    return np.array([values.get(parameter.name, parameter.value) for parameter in free_parameters(scene)])


def test_patterns_say_what_is_free_but_not_what_the_stage_sets_itself(scene):
    assert set(NAMES) == {parameter.name for parameter in free_parameters(scene)}
    assert set(freed(scene, scene.stages[0])) == {*NAMES} - {"objective.speed"}
    assert freed(scene, scene.stages[1]) == ("controller.pd.lHip.kp", "objective.speed")
    assert freed(scene, scene.stages[2]) == ("failure.com_height",)
    for number, stage in enumerate(scene.stages):
        part = stage_scene(scene, number, start_values(scene))
        check_scene(part)
        assert tuple(parameter.name for parameter in free_parameters(part)) == freed(scene, stage)
        assert part.stages == []


def test_stage_replaces_what_it_says_and_keeps_the_rest(scene):
    part = stage_scene(scene, 0, start_values(scene))
    assert (part.objective.torque, part.objective.speed, part.duration) == (0.0, 2.0, 3.0)
    assert (part.failure.body_contact, part.failure.heading) == (True, 0.5)
    assert part.failure.com_height == scene.failure.com_height
    assert (part.robustness.runs, part.robustness.slope, scene.robustness.runs) == (4, 0.1, 1)
    assert (scene.objective.torque, scene.duration) == (1.0, 10.0)
    assert stage_scene(scene, 2, start_values(scene)).objective.metabolic_model == "umberger"


def test_free_parameters_start_from_the_values_and_the_others_and_their_followers_have_them(scene):
    values = values_of(scene, {"controller.pd.lHip.kp": 12.0, "controller.states.0.time": 0.6})
    free = stage_scene(scene, 1, values).controller
    assert free.pd["lHip"].kp == Free(12.0, 5.0, 20.0)
    assert free.pd["rHip"].kp == Free(same_as="controller.pd.lHip.kp", factor=2.0)
    assert free.states[0].time == 0.6
    fixed = pinned(scene, values, {"controller.states.0.time"}).controller
    assert (fixed.pd["lHip"].kp, fixed.pd["rHip"].kp, fixed.states[0].time) == (12.0, 24.0, Free(0.6, 0.5, 0.9))


def test_scene_without_stages_only_starts_from_other_values(scene):
    scene.stages = []
    values = values_of(scene, {"controller.pd.lHip.kp": 12.0})
    part = stage_scene(scene, 0, values)
    np.testing.assert_array_equal(start_values(part), values)
    assert stage_scene(scene, 0, start_values(scene)) == scene


def test_an_only_stage_is_taken_for_the_scene_unless_it_says_how_to_search(scene):
    assert without_only_stage(scene) is scene  # of three stages
    for number, stage in enumerate(scene.stages):
        alone = replace(scene, stages=[stage])
        assert without_only_stage(alone) == stage_scene(scene, number, start_values(scene))
    how = replace(scene, stages=[replace(scene.stages[1], population=8)])
    assert without_only_stage(how) is how
    plain = replace(scene, stages=[])
    assert without_only_stage(plain) is plain
