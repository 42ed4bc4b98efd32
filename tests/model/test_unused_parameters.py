"""A free parameter that changes nothing is pointed out before a search spends itself on it."""

import msgspec
import pytest

from same_values import assert_same
from small_scene import muscle_scene, sound_scene
from warpmuscle.core.errors import Error, UnusedParameterWarning
from warpmuscle.formats import load, scene_names, toml
from warpmuscle.model.unused_parameters import unused_parameters
from warpmuscle.optimization.optimize import optimize
from warpmuscle.scene import Actuation, Command, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters


def test_properties_of_muscles_on_torque_driven_joints_are_unused():
    scene = muscle_scene()
    scene.character.muscles["HFL"].f_max = Free(1000.0, 500.0, 2000.0)
    assert unused_parameters(scene) == []
    scene.actuation["lHip"] = Actuation("torque")
    assert unused_parameters(scene) == ["character.muscles.HFL.f_max"]
    scene.controller.pd["lHip"].kp = 10.0
    with pytest.raises(Error, match=r"nothing to search for: character\.muscles\.HFL\.f_max"):
        optimize(scene, 4, device="cpu")


def half_used() -> Scene:
    """A scene whose gain is searched for, and a muscle of a joint that a torque drives, which nothing uses."""
    scene = muscle_scene()
    scene.failure.max_com_speed = 1000.0  # it starts deep in the ground, which throws it up
    scene.duration = 0.1
    scene.actuation["lHip"] = Actuation("torque")
    scene.character.muscles["HFL"].f_max = Free(1000.0, 500.0, 2000.0)
    assert [parameter.name for parameter in free_parameters(scene)][-1] == "controller.pd.lHip.kp"
    return scene


def test_a_search_leaves_what_nothing_uses_as_given_and_says_so():
    with pytest.warns(UnusedParameterWarning, match=r"nothing uses character\.muscles\.HFL\.f_max: left as given"):
        result = optimize(half_used(), 6, device="cpu")
    assert result.parameters.name == ("controller.pd.lHip.kp",)
    assert toml.loads(result.scene).character.muscles["HFL"].f_max == 1000.0
    alone = half_used()
    alone.character.muscles["HFL"].f_max = 1000.0
    assert_same(result, optimize(alone, 6, device="cpu"))


def test_a_parameter_used_only_through_one_that_follows_it_is_used():
    scene = muscle_scene()
    scene.character.muscles["HFL"].f_max = Free(1000.0, 500.0, 2000.0)
    scene.character.muscles["TFL"].f_max = Free(same_as="character.muscles.HFL.f_max")
    scene.actuation["lHip"] = Actuation("torque")
    assert unused_parameters(scene) == []


def test_weights_and_initial_states_are_used():
    scene = sound_scene()
    scene.objective.torque = Free(1.0, 0.5, 2.0)
    scene.initial_state = msgspec.structs.replace(scene.initial_state, root_velocity=(0.0, 0.0, Free(1.0, 0.5, 2.0)))
    assert len(free_parameters(scene)) == 3
    assert unused_parameters(scene) == []


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_free_nothing_in_vain(name):
    scene = load(name)
    if free_parameters(scene):
        assert unused_parameters(scene) == []


def test_motions_and_collisions_count_as_what_uses_a_parameter():
    scene = load("fwalk")
    scene.failure.self_collision = Free(0.05, 0.01, 0.1)
    assert unused_parameters(scene) == []
    scene = load("throw")
    scene.actuation["wrist"].drive = "kinematic"
    scene.motion["wrist"].value[3] = Free(0.2, 0.1, 0.3)
    assert not [name for name in unused_parameters(scene) if name.startswith("motion")]


def test_what_is_added_per_command_is_used_where_the_number_is_and_the_command_can_differ():
    scene = load("fwalk")
    scene.commands = {"speed": Command(1.0, 1.0, 1.5), "fixed": Command(1.0, 1.0, 1.0)}
    scene.controller.states[0].time = Free(0.6, per={"speed": Free(0.0, -0.1, 0.1), "fixed": Free(0.0, -0.1, 0.1)})
    assert unused_parameters(scene) == ["controller.states.0.time.per.fixed"]
