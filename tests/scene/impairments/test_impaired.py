"""Impaired muscles against muscles with other numbers, and what is refused."""

import numpy as np
import pytest
from msgspec.structs import replace

from muscle_arm import arm, constant
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import Command, Impairment, MuscleModel, Scene
from warpmuscle.scene.impairments.impaired import in_words
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.sweep.union import MergedScene

FLEXOR = {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1, "delay": 0.02, "excitation": constant(0.5)}


def impaired_arm(**impairments: Impairment) -> Scene:
    scene = arm(flexor=FLEXOR, impairments=impairments)
    check_scene(scene)
    return scene


def numeric(scene: Scene, values=None):
    return substitute(scene, start_values(scene) if values is None else values)


def test_numbers_of_the_named_muscles_are_multiplied_and_no_others():
    scene = impaired_arm(weak=Impairment(["fl*"], f_max=0.5, l_opt=0.9, l_slack=1.1, delay=2.0))
    got, before = numeric(scene).character.muscles, scene.character.muscles
    flexor = got["flexor"]
    assert (flexor.f_max, flexor.l_opt, flexor.l_slack, flexor.delay) == (200.0, 0.9 * 0.15, 1.1 * 0.1, 0.04)
    assert got["extensor"] == before["extensor"]
    assert before["flexor"].f_max == 400.0


def test_impairments_are_told_with_their_muscles_and_what_is_not_1():
    scene = impaired_arm(weak=Impairment(["fl*"], f_max=0.5, delay=2.0), none=Impairment(["*"]))
    assert in_words(scene) == ["weak: f_max x 0.5, delay x 2 of flexor"]
    free = impaired_arm(search=Impairment(["*"], f_max=Free(0.5, 0.2, 1.0)))
    assert in_words(free) == ["search: f_max x a free or commanded number of flexor, extensor"]
    assert in_words(numeric(scene)) == []  # which muscles have in their numbers


def test_numbers_that_all_muscles_share_become_those_of_the_muscle():
    got = numeric(impaired_arm(old=Impairment(["*"], v_max=0.8, fall_time=1.2)))
    model = MuscleModel()
    for muscle in got.character.muscles.values():
        assert (muscle.v_max, muscle.fall_time) == (0.8 * model.v_max, 1.2 * model.fall_time)
        assert muscle.rise_time is None


def test_several_impairments_multiply_and_are_used_once():
    got = numeric(impaired_arm(old=Impairment(["*"], f_max=0.8), weak=Impairment(["flexor"], f_max=0.5)))
    assert got.character.muscles["flexor"].f_max == pytest.approx(160.0)
    assert got.character.muscles["extensor"].f_max == pytest.approx(320.0)
    assert numeric(got) == got


def test_a_factor_may_be_free_and_followed_and_commanded():
    scene = impaired_arm(
        left=Impairment(["flexor"], f_max=Free(0.5, 0.2, 1.0)),
        right=Impairment(["extensor"], f_max=Free(same_as="impairments.left.f_max")),
    )
    assert [p.name for p in free_parameters(scene)] == ["impairments.left.f_max"]
    got = numeric(scene, np.array([[0.25], [0.75]])).character.muscles
    assert np.array_equal(got["flexor"].f_max, [100.0, 300.0])
    assert np.array_equal(got["extensor"].f_max, [100.0, 300.0])
    scene = arm(
        commands={"age": Command(reference=20.0, min=20.0, max=80.0, unit="years")},
        impairments={"old": Impairment(["*"], f_max=Free(1.0, per={"age": -0.005}))},
    )
    check_scene(scene)
    assert substitute(scene, np.zeros(0), {"age": 60.0}).character.muscles["flexor"].f_max == pytest.approx(320.0)


def test_scenes_that_differ_in_an_impairment_share_a_batch():
    scenes = [impaired_arm(weak=Impairment(["*"], f_max=factor)) for factor in (1.0, 0.5)]
    merged = MergedScene(scenes)
    for index, scene in enumerate(scenes):
        values = merged.values(index, start_values(scene)[None])
        got = substitute(merged.scene, values).character.muscles["flexor"].f_max
        assert got == numeric(scene).character.muscles["flexor"].f_max


def test_a_text_gives_the_same_impairments():
    scene = impaired_arm(weak=Impairment(["fl*", "extensor"], f_max=Free(0.5, 0.2, 1.0), l_opt=0.9))
    assert toml.loads(toml.dumps(scene)) == scene


@pytest.mark.parametrize(
    ("change", "key", "word"),
    [
        ({"muscles": []}, "muscles", "names no muscles"),
        ({"muscles": ["flexer"]}, "muscles.0", "did you mean 'flexor'"),
        ({"f_max": 0.0}, "f_max", "greater than 0"),
        ({"f_max": Free(0.5, 0.0, 1.0)}, "f_max", "greater than 0"),
        ({"passive_strain": 0.8}, "passive_strain", "give muscle_model.passive_strain"),
        ({"delay": 1000.0}, "", "makes character.muscles.flexor.delay wrong"),
        ({"delay": Free(1.0, 1.0, 1000.0)}, "", "less than the scene's duration"),
        ({"muscles": ["extensor"], "delay": 2.0}, "delay", "has a delay"),
    ],
)
def test_what_makes_no_sense_is_refused_with_its_key(change: dict, key: str, word: str):
    impairment = replace(Impairment(["flexor"]), **change)
    with pytest.raises(SceneError, match=word) as caught:
        impaired_arm(weak=impairment)
    assert caught.value.key == f"impairments.weak.{key}".rstrip(".")
