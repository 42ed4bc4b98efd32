"""Scenes as small files on other scenes: what is read back is the scene that was written."""

import msgspec
import numpy as np
import pytest

from small_scene import muscle_scene, sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import derived, toml
from warpmuscle.scene import PD, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, leaves, start_values, substitute, with_values

KP = "controller.pd.lHip.kp"


def read_on(base: Scene, text: str, folder) -> Scene:
    """The scene of a text whose base lies in the same folder."""
    toml.write(base, folder / "base.toml")
    (folder / "mine.toml").write_text(text)
    return toml.read(folder / "mine.toml")


def changed(scene: Scene) -> Scene:
    """Other values of free parameters, of a number in a list, of a text, and a number that is free no more."""
    scene = with_values(scene, start_values(scene) * 1.1)
    scene.controller.pd["root"] = PD(Free(same_as=KP, factor=0.5), 1.0)
    scene.ground.normal = (0.0, 1.0, 0.1)
    scene.controller.states[0].time = Free(0.65, 0.5, 0.7, 0.01)
    return msgspec.structs.replace(scene, name="mine", description="changed", implicit_pd=True)


@pytest.mark.parametrize("make", [sound_scene, muscle_scene])
def test_scene_on_another_reads_back_as_it_is_and_says_only_what_differs(make, tmp_path):
    base, mine = make(), changed(make())
    text = derived.on_base(mine, base, "base.toml", ["why"])
    assert read_on(base, text, tmp_path) == mine
    assert text.startswith("# why\n\nname = ")
    assert len(text.splitlines()) < 40
    assert derived.on_base(base, base, "base.toml").splitlines() == [
        f'name = "{base.name}"', 'base = "base.toml"', f'description = "{base.description}"',
    ]  # fmt: skip


def test_number_that_followed_and_is_free_now_reads_back_so(tmp_path):
    base, mine = sound_scene(), sound_scene()
    base.controller.pd["rHip"] = PD(Free(same_as=KP), 1.0)
    mine.controller.pd["rHip"] = PD(Free(3.0, 1.0, 9.0), 1.0)
    assert read_on(base, derived.on_base(mine, base, "base.toml"), tmp_path) == mine
    assert read_on(mine, derived.on_base(base, mine, "base.toml"), tmp_path) == base


def test_numbers_of_several_scenes_follow_the_one_that_sets_them_apart(tmp_path):
    speed = "objective.target_speed"
    base = sound_scene()
    base.controller.pd["rHip"] = PD(Free(same_as=KP, factor=2.0), 1.0)
    scenes = []
    for at, kp in ((1.5, 8.0), (0.5, 6.0), (1.0, 9.0)):
        scene = with_values(base, np.array([kp]))
        scene.objective.target_speed = at
        scenes.append(scene)
    mine = read_on(base, derived.over(scenes, speed, base, "base.toml"), tmp_path)
    assert [parameter.name for parameter in free_parameters(mine)] == [speed]
    for scene in scenes:
        wanted = dict(leaves(substitute(scene, start_values(scene))))
        got = dict(leaves(substitute(mine, np.array([scene.objective.target_speed]))))
        assert got == wanted
    between = substitute(mine, np.array([0.75])).controller.pd
    assert (between["lHip"].kp, between["rHip"].kp) == (7.5, 15.0)


def test_number_in_a_list_that_the_base_has_by_default_can_follow(tmp_path):
    base, scenes = sound_scene(), [sound_scene(), sound_scene()]
    scenes[0].ground.normal, scenes[1].ground.normal = (0.0, 1.0, -0.1), (0.0, 1.0, 0.1)
    scenes[1].controller.pd["root"] = PD(12.0, 1.0)
    mine = read_on(base, derived.over(scenes, "ground.normal.2", base, "base.toml"), tmp_path)
    assert mine.ground.normal == (0.0, 1.0, Free(-0.1, -0.1, 0.1))
    values = [0.0 if parameter.name == "ground.normal.2" else parameter.value for parameter in free_parameters(mine)]
    assert substitute(mine, np.array(values)).controller.pd["root"].kp == 11.0


def test_scenes_that_differ_in_more_are_refused_with_the_key():
    base, mine = sound_scene(), sound_scene()
    mine.controller.pd["rHip"] = PD(1.0, 1.0)
    with pytest.raises(SceneError, match=r"controller\.pd\.rHip\.[\w.]+: this is not in both"):
        derived.on_base(mine, base, "base.toml")
    with pytest.raises(SceneError, match=r"objective\.target_speed: each of two or more scenes needs a number"):
        derived.over([base, base], "objective.target_speed", base, "base.toml")
    other = sound_scene()
    other.objective.target_speed, other.implicit_pd = 2.0, True
    with pytest.raises(SceneError, match="implicit_pd: the scenes differ in more than numbers"):
        derived.over([base, other], "objective.target_speed", base, "base.toml")
