"""Scenes that differ in numbers share batches, and every optimisation remains what it is alone, to the last bit."""

from functools import partial

import numpy as np
import pytest

from same_values import assert_same
from small_scene import muscle_scene
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.formats.overrides import Override, overridden
from warpmuscle.optimization import evaluation
from warpmuscle.optimization.optimize import optimize, searched
from warpmuscle.scene import Actuation, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, leaves
from warpmuscle.sweep.shared_batches import run_in_one_batch
from warpmuscle.sweep.union import MergedScene, groups, number_leaves, searched_scenes, unchanged, weighed_scenes


def changed(scene: Scene, **values) -> Scene:
    return overridden(scene, [Override(key.replace("__", "."), value) for key, value in values.items()])


def muscles() -> Scene:
    """A small scene with muscles, a free number and one that follows it."""
    scene = muscle_scene()
    scene.failure.max_com_speed = 1000.0  # it starts deep in the ground, which throws it up
    scene.duration = 0.1
    scene.controller.pd["rHip"] = scene.controller.pd["lHip"].__class__(Free(same_as="controller.pd.lHip.kp"), 1.0)
    scene.character.muscles["HFL"].f_max = Free(1000.0, 500.0, 2000.0, scale="log")
    return scene


def variants() -> list[Scene]:
    scene = muscles()
    return [
        scene,
        changed(scene, character__bodies__pelvis__mass=12.5, gravity=9.0),
        changed(scene, **{"character.muscles.*.f_max": {"factor": 0.3}}),
        changed(scene, character__muscles__HFL__delay=0.033, objective__torque=2.5),
        changed(scene, controller__pd__lHip__kp=15.0),
        changed(scene, character__muscles__TFL__l_slack={"value": 0.2, "min": 0.1, "max": 0.3}),
        changed(scene, initial_state__root_velocity=[0.0, 0.1, 0.5], **{"scale.lFoot": 1.2}),
        changed(scene, controller__states={"0": {"time": {"value": 0.05, "min": 0.02, "max": 0.09, "step": 0.01}}}),
    ]


OPTIONS = {
    "random": {"search": "random", "population": 12},
    "nlopt": {"search": "nlopt:LN_BOBYQA", "searches": 3},
}


def batch_scene(scenes, device="cpu", tell=None, **options):
    """Results of optimisations that share batches."""
    found = [None] * len(scenes)

    def job(index, scene, batches):
        found[index] = optimize(scene, 30, seed=index, batches=batches, **options)

    jobs = [partial(job, index, scene) for index, scene in enumerate(scenes)]
    errors = run_in_one_batch(scenes, jobs, device, 2, tell)
    assert errors == [None] * len(scenes)
    return found


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_every_run_is_the_same_to_the_last_bit_as_alone(options):
    scenes = variants()
    assert groups(scenes) == [list(range(len(scenes)))]
    for scene, seed, result in zip(scenes, range(99), batch_scene(scenes, **options), strict=False):
        assert_same(result, optimize(scene, 30, seed=seed, device="cpu", **options))


def test_rounds_of_several_batches_and_a_target_are_as_alone(monkeypatch):
    monkeypatch.setattr(evaluation, "CPU_BATCH", 7)
    scenes = variants()[:3]
    options = {"search": "random", "population": 20}
    costs = optimize(scenes[1], 30, seed=1, device="cpu", **options).evaluations.cost
    options["target"] = float(costs.min())
    alone = [optimize(scene, 30, seed=seed, device="cpu", **options) for seed, scene in enumerate(scenes)]
    for result, expected in zip(batch_scene(scenes, **options), alone, strict=True):
        assert_same(result, expected)
    assert len({len(result.evaluations) for result in alone}) > 1


@pytest.mark.filterwarnings("ignore::warpmuscle.core.errors.UnusedParameterWarning")
def test_runs_in_which_nothing_uses_some_of_the_parameters_are_as_alone():
    scene = muscles()
    scene.actuation["lHip"] = Actuation("torque")  # so that nothing uses the muscles, whose f_max comes first
    scene.controller.pd["lHip"].kp = Free(10.0, 5.0, 20.0)
    scenes = [scene, changed(scene, gravity=9.0)]
    assert groups(scenes) == [[0, 1]]
    for scene, seed, result in zip(scenes, range(2), batch_scene(scenes, search="random"), strict=True):
        assert result.parameters.name == ("controller.pd.lHip.kp",)
        assert_same(result, optimize(scene, 30, seed=seed, device="cpu", search="random"))


def test_biped_with_weights_masses_and_lengths_is_as_alone():
    scene = changed(load("fwalk"), duration=0.1, objective__speed=3.0)
    scenes = [
        scene,
        changed(scene, objective__speed=30.0, objective__target_speed=1.3),
        changed(scene, **{"scale.?Lowerleg": 1.1, "character.bodies.*.mass": {"factor": 1.3}}),
    ]
    options = {"search": "cma", "population": 8}
    for result, seed in zip(batch_scene(scenes, **options), range(3), strict=True):
        assert_same(result, optimize(scenes[seed], 30, seed=seed, device="cpu", **options))


def test_scenes_that_differ_in_more_than_numbers_are_kept_apart():
    scene = muscles()
    scenes = [
        scene,
        changed(scene, duration=0.2),
        changed(scene, gravity=5.0),
        changed(scene, objective__speed=1.0),  # another term
        changed(scene, ground__stiffness=0.0),  # no contacts
        changed(scene, actuation__rHip={"stiffness": 0.0, "damping": 0.0}),  # no spring
        changed(scene, muscle_model__tendon="compliant"),
        changed(scene, actuation__rHip={"stiffness": 20.0}),
    ]
    assert groups(scenes) == [[0, 2, 7], [1], [3], [4], [5], [6]]


def test_intervals_that_no_single_scene_can_have_keep_scenes_apart():
    scene = muscles()
    limits = "character.joints.lHip.limits.0"
    apart = [
        changed(scene, **{limits: [-1.0, -0.5]}),
        changed(scene, **{limits: [0.5, 1.0]}),
    ]
    assert groups(apart) == [[0], [1]]


def test_union_has_a_parameter_for_each_number_that_differs_or_is_free():
    scene = muscles()
    union = MergedScene([scene, changed(scene, gravity=5.0)])
    names = [parameter.name for parameter in free_parameters(union.scene)]
    assert sorted(names) == [
        "character.muscles.HFL.f_max", "controller.pd.lHip.kp", "controller.pd.rHip.kp", "gravity",
    ]  # fmt: skip
    values = dict(zip(names, union.values(1, np.array([[1234.0, 17.0]])).T, strict=True))
    assert values == {
        "gravity": [5.0], "character.muscles.HFL.f_max": [1234.0], "controller.pd.lHip.kp": [17.0],
        "controller.pd.rHip.kp": [17.0],
    }  # fmt: skip


def test_number_leaves_are_what_a_search_may_change():
    scene = load("walk56")
    paths = dict(number_leaves(scene))
    assert {"gravity", "objective.speed", "controller.states.0.time", "character.joints.lKnee.limits.0.1"} <= set(paths)
    assert not {"duration", "time_step", "objective.failure_cost", "controller.states.0.next"} & set(paths)
    assert {path for path, leaf in leaves(scene) if isinstance(leaf, Free)} <= set(paths)


def test_error_of_one_run_is_its_own_and_an_interrupt_ends_all():
    scenes = variants()[:2]

    def fails(batches):
        raise Error("no")

    done = []

    def works(batches):
        done.append(optimize(scenes[1], 10, batches=batches, population=5))

    errors = run_in_one_batch(scenes, [fails, works], "cpu", 1)
    assert [str(error) if error else "" for error in errors] == ["no", ""]
    assert len(done[0].evaluations) == 10

    def interrupt(progress):
        if progress.done > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_in_one_batch(scenes, [works, works], "cpu", 1, interrupt)
    assert [result.searched.ended for result in done[1:]] == ["interrupted"] * 2


def test_interrupt_of_a_run_by_itself_is_not_taken_for_its_end():
    def interrupt(progress):
        raise KeyboardInterrupt

    def job(batches):
        optimize(scene, 10, batches=batches, progress=interrupt if not done else None)
        done.append(True)

    scene, done = variants()[0], []
    with pytest.raises(KeyboardInterrupt):
        run_in_one_batch([scene], [job], "cpu", 1)


@pytest.mark.filterwarnings("ignore:nothing uses")
def test_what_nothing_uses_is_found_for_many_as_for_each_alone():
    half = muscles()  # a torque drives the joint of the muscle whose force is free: nothing uses it
    half.actuation["lHip"] = Actuation("torque")
    half.controller.pd["lHip"].kp = Free(10.0, 5.0, 20.0)
    scenes = [
        *variants(),
        half,
        changed(half, character__bodies__pelvis__mass=12.5),
        changed(half, objective__torque=2.5, gravity=9.0),
        changed(half, controller__pd__lHip__kp=10.0),  # so that nothing is left to search for
    ]
    weighed = weighed_scenes(scenes)
    with unchanged(scene for scene in weighed if isinstance(scene, Scene)):
        assert len(groups([scene for scene in weighed if isinstance(scene, Scene)])) < len(scenes) - 3
        found = searched_scenes(weighed)
    *sound, hopeless = zip(scenes, found, strict=True)
    for scene, own in sound:
        assert own == searched(scene)
    fewer = [len(free_parameters(own)) < len(free_parameters(scene)) for scene, own in sound]
    assert sum(fewer) == 3
    with pytest.raises(Error) as caught:
        searched(hopeless[0])
    assert isinstance(hopeless[1], Error)
    assert str(hopeless[1]) == str(caught.value)
