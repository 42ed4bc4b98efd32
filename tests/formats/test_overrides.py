"""Overrides of a scene: single values, tables, patterns and factors, and what is said about those that cannot be."""

from pathlib import Path

import pytest

from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.overrides import Override, overridden
from warpmuscle.scene import PD, Actuation, Scene
from warpmuscle.scene.number import Free

SOURCE = "controller.pd.lHip.kp"


def scene() -> Scene:
    scene = muscle_scene()
    scene.controller.pd["rHip"] = PD(Free(same_as=SOURCE, factor=2.0), 1.0)
    return scene


def changed(key, value, base=None) -> Scene:
    return overridden(base or scene(), [Override(key, value, 7)], Path("a.toml"))


def test_nothing_to_change_changes_nothing():
    assert overridden(scene(), []) == scene()


@pytest.mark.parametrize(
    ("key", "value", "get"),
    [
        ("duration", 2.0, lambda s: s.duration),
        ("objective.speed", 3.0, lambda s: s.objective.speed),
        ("controller.states.0.time", 0.3, lambda s: s.controller.states[0].time),
        ("initial_state.root_position.1", 1.5, lambda s: s.initial_state.root_position[1]),
        ("initial_state.heading", 0.5, lambda s: s.initial_state.heading),
        ("muscle_model.tendon", "compliant", lambda s: s.muscle_model.tendon),
        ("controller.heading_control", False, lambda s: s.controller.heading_control),
        ("character.bodies.pelvis.inertia", [2.0, 3.0, 4.0], lambda s: list(s.character.bodies["pelvis"].inertia)),
        ("robustness.runs", 3, lambda s: s.robustness.runs),
    ],
)
def test_value_replaces_what_is_there_or_its_default(key, value, get):
    before = scene()
    assert get(changed(key, value, before)) == value
    assert before == scene()


def test_table_replaces_a_number_but_goes_into_a_table():
    free = {"value": 12.0, "min": 10.0, "max": 14.0}
    assert changed("character.bodies.pelvis.mass", free).character.bodies["pelvis"].mass == Free(12.0, 10.0, 14.0)
    pd = changed("controller.pd", {"root": {"kd": 2.0}}).controller.pd
    assert (pd["root"], pd["lHip"]) == (PD(10.0, 2.0), PD(Free(10.0, 5.0, 20.0), 1.0))
    assert changed("actuation.lToe", {"drive": "passive"}).actuation["lToe"] == Actuation("passive")
    assert changed(f"{SOURCE}.max", 15.0).controller.pd["lHip"].kp == Free(10.0, 5.0, 15.0)
    assert changed("tracking", {"scene": "fwalk"}).tracking.scene == "fwalk"


def test_numbers_that_follow_go_on_following():
    assert changed(SOURCE, 11.0).controller.pd["rHip"].kp == 22.0
    table = {"value": 6.0, "min": 5.0, "max": 7.0}
    assert changed(SOURCE, table).controller.pd["rHip"].kp == Free(same_as=SOURCE, factor=2.0)
    assert changed("controller.pd.rHip.kp", 3.0).controller.pd["lHip"].kp == Free(10.0, 5.0, 20.0)


def test_numbers_that_go_through_points_take_their_value_there_from_a_number():
    base = scene()
    base.controller.pd["rHip"] = PD(Free(same_as=SOURCE, through=((10.0, 1.0), (20.0, 3.0))), 1.0)
    assert changed(SOURCE, 15.0, base).controller.pd["rHip"].kp == 2.0
    follower = changed(SOURCE, {"same_as": "controller.pd.root.kp"}, with_free_root(base)).controller.pd["rHip"].kp
    assert follower == Free(same_as="controller.pd.root.kp", through=((10.0, 1.0), (20.0, 3.0)))
    with pytest.raises(SceneError, match=r"goes through points over controller\.pd\.lHip\.kp, which follows"):
        changed(SOURCE, {"same_as": "controller.pd.root.kp", "factor": 2.0}, with_free_root(base))


def with_free_root(scene: Scene) -> Scene:
    scene.controller.pd["root"] = PD(Free(12.0, 10.0, 20.0), 2.0)
    return scene


def test_pattern_sets_or_multiplies_every_number_that_it_matches():
    base = load("walk56")
    weak = changed("character.muscles.?SOL.f_max", {"factor": 0.25}, base).character.muscles
    for name, muscle in base.character.muscles.items():
        assert weak[name].f_max == muscle.f_max * (0.25 if name in ("lSOL", "rSOL") else 1.0)
    slow = changed("character.muscles.*.delay", 0.05, base).character.muscles
    assert {muscle.delay for muscle in slow.values()} == {0.05}


def test_scale_changes_bodies_of_a_pattern():
    base = load("walk56")
    bodies = changed("scale.?Foot", 2.0, base).character.bodies
    assert bodies["rFoot"].mass == 8.0 * base.character.bodies["rFoot"].mass
    assert bodies["lToes"] == base.character.bodies["lToes"]


def test_muscles_follow_the_scale_of_bodies_if_they_shall():
    base = load("walk56")
    still, longer = (changed("scale.*", value, base) for value in (1.1, {"factor": 1.1, "muscles": True}))
    before, kept, changed_one = (scene.character.muscles["lSOL"] for scene in (base, still, longer))
    assert kept.l_opt == before.l_opt
    assert changed_one.l_slack.value == pytest.approx(1.1 * before.l_slack.value)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("objective.sped", 1.0, "a.toml:7: objective.sped: unknown key: there is no 'sped' in objective; did you mean"),
        ("objektive.speed", 1.0, "no 'objektive' in a scene; did you mean 'objective'?"),
        ("character.bodies.pelvs.mass", 1.0, "no 'pelvs' in character.bodies; did you mean 'pelvis'?"),
        ("character.bodies.pelvs.ma*", {"factor": 2}, "no 'pelvs' in character.bodies; did you mean 'pelvis'?"),
        ("controller.states.4.time", 1.0, "no '4' in controller.states; there is 0"),
        ("duration.x", 1.0, "no 'x' in duration"),
        ("duration", "long", "a.toml:7: duration: expected a number, got text"),
        ("duration", -1.0, "a.toml:7: duration: must be greater than 0"),
        ("objective", {"sped": 1.0}, "objective.sped: unknown key; did you mean 'speed'?"),
        ("objective.speed", {"value": 1.0}, "a free parameter needs value, min and max"),
        ("character.muscles.?SOL.f_max", {"factor": 0.5}, "a.toml:7: character.muscles.?SOL.f_max: no number has"),
        ("character.bodies.?Foot.mas", {"factor": 0.5}, "of this pattern: nothing fits 'mas'; did you mean 'mass'"),
        ("character.muscles.*.f_max", {"factor": "half"}, "the factor must be a number"),
        ("character.muscles.*.f_max", {"factor": -1.0}, "must be greater than 0"),
        ("character.muscles.HFL.path", {"factor": 2.0}, "a.toml:7: character.muscles.HFL.path: no number has"),
        ("scale.pelvs", 2.0, "no body is called 'pelvs'; did you mean 'pelvis'?"),
        ("scale.pelvis", "big", "a body is scaled by a number"),
        ("scale.pelvis", 0.0, "positive factor"),
        ("scale.pelvis", {"factor": 1.1, "muscles": 3}, "a body is scaled by a number"),
        ("muscle_model.tendon", "soft", "'soft' is none of"),
    ],
)
def test_what_cannot_be_overridden_is_one_line_with_file_line_and_key(key, value, message):
    with pytest.raises(SceneError) as caught:
        changed(key, value)
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"a.toml:7: {key}: ")


def test_a_joint_that_a_table_does_not_name_yet_may_be_given_one_value():
    scene = load("fwalk")
    assert "lKnee" not in scene.actuation
    changed = overridden(scene, [Override("actuation.lKnee.drive", "passive")])
    assert changed.actuation == {**scene.actuation, "lKnee": Actuation("passive")}
    started = overridden(scene, [Override("initial_state.joints.lShoulder.angular_velocity", [0.0, 0.0, 1.0])])
    assert started.initial_state.joints["lShoulder"].angular_velocity == (0.0, 0.0, 1.0)
    with pytest.raises(SceneError, match="no 'lKnea' in actuation; did you mean 'lKnee'"):
        overridden(scene, [Override("actuation.lKnea.drive", "passive")])
