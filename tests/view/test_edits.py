"""Numbers and curves of a scene that are changed by hand, and the scenes that come of it, without a browser."""

import math

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import Command, Curve, Excitation, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, leaves
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.view.editing.numbers import CurveKnots, editable, slider_range
from warpmuscle.view.edits import Edits, Point, edited, key_now

HIP = "controller.states.0.trajectories.SWING_Hip.components.1"
LEAN = "controller.states.0.trajectories.root.components.0"


def curves_of(scene: Scene) -> dict[str, CurveKnots]:
    return {one.key: one for one in editable(scene)[1]}


def changed(scene: Scene, **edits: object) -> Scene:
    made = edited(scene, curves_of(scene), Edits(**edits))  # type: ignore[arg-type]
    check_scene(made)
    assert loads(dumps(made)) == made
    return made


def test_every_number_of_a_controller_and_every_knot_of_its_curves_can_be_edited():
    scene = load("walk56")
    numbers, curves = editable(scene)
    keys = {one.key for one in numbers} | {
        f"{one.key}.{name}.{place}" for one in curves for name in (one.across, one.along) for place in range(one.knots)
    }
    whole = {key for key, leaf in leaves(scene.controller, "controller")
             if isinstance(leaf, float | Free) and not isinstance(leaf, bool)}  # fmt: skip
    assert len(whole) > 300
    assert whole <= keys
    assert {f"character.muscles.{name}.f_max" for name in scene.character.muscles} <= keys
    assert not [key for key in keys if key.endswith((".next", ".start_state"))]  # those are no numbers
    named = {one.key: one for one in (*numbers, *curves)}
    assert (named[HIP].group, named[HIP].name, named[HIP].unit) == ("swing hip", "angle", "rad")
    gain = named[f"{HIP}.feedback.cd"]
    assert (gain.group, gain.name, gain.unit) == ("swing hip", "angle, distance feedback (cd)", "rad/m")
    assert named["controller.pd.lKnee.kp"].unit == "N m/rad"
    assert named["controller.states.0.time"].unit == "s"


@pytest.mark.parametrize(("field", "value"), [("kp", 300.0), ("kd", 0.0), ("angle", -0.4), ("time", 0.7), ("cd", 0.0)])
def test_sliders_hold_their_number_and_do_not_reach_where_it_may_not_be(field, value):
    low, high = slider_range(field, "N m/rad" if field == "kp" else "rad", value)
    assert low < high
    assert low <= value <= high
    assert low >= 0.0 or field in ("angle", "cd")
    assert math.isfinite(high - low)


def test_limits_that_limit_nothing_have_sliders_of_what_would_limit_something():
    assert slider_range("d_limits", "m", -1000.0) == slider_range("d_limits", "m", 1000.0) == (-0.4, 0.4)
    assert slider_range("v_limits", "m/s", 0.3) == (-0.2, 0.8)


def test_free_numbers_stay_free_and_reach_as_far_as_they_were_moved():
    scene = load("fwalk")
    made = changed(scene, numbers={"controller.pd.lKnee.kp": 1000.0, "controller.pd.rHip.kd": 12.0})
    assert made.controller.pd["lKnee"].kp == Free(1000.0, 150.0, 1000.0, 5.0)
    assert made.controller.pd["rKnee"].kp == Free(same_as="controller.pd.lKnee.kp")
    assert made.controller.pd["rHip"].kd == 12.0  # which followed the left one
    assert scene.controller.pd["lKnee"].kp == load("fwalk").controller.pd["lKnee"].kp
    with pytest.raises(SceneError, match="no such number"):
        edited(scene, curves_of(scene), Edits({"controller.pd.lKnee.ki": 1.0}))
    logarithmic = load("walk56")
    with pytest.raises(SceneError, match="logarithmic scale needs a positive min"):
        edited(logarithmic, curves_of(logarithmic), Edits({"controller.pd.lKnee.kp": -1.0}))


def test_numbers_that_follow_commands_keep_doing_so():
    scene = load("fwalk")
    scene.commands = {"speed": Command(1.0, 0.5, 1.5)}
    scene.controller.states[0].time = Free(0.6, per={"speed": [-0.2, 0.01]})
    numbers = {one.key for one in editable(scene)[0]}
    assert {f"controller.states.0.time.per.speed.{power}" for power in (0, 1)} <= numbers
    made = changed(scene, numbers={"controller.states.0.time": 0.7, "controller.states.0.time.per.speed.0": -0.1})
    assert made.controller.states[0].time == Free(0.7, per={"speed": [-0.1, 0.01]})


def test_knots_come_and_go_and_what_follows_them_finds_them():
    scene = load("walk56")
    hip = [Point(0), Point(-1, 0.1, -0.3), Point(2), Point(3, None, 0.5), Point(4), Point(5)]  # the second one goes
    lean = [Point(-1, 0.001, 0.2), Point(0), Point(1), Point(2)]
    names = [p.name for p in free_parameters(scene)]
    made = changed(scene, curves={HIP: tuple(hip), LEAN: tuple(lean)})
    component = made.controller.states[0].trajectories["SWING_Hip"].components[1]
    assert component.phase == [0.023411, 0.1, 0.521739, 0.70903, 0.842809, 0.986622]
    assert component.angle[1] == -0.3
    assert (component.angle[3].value, component.angle[3].max) == (0.5, 0.5)
    leans = made.controller.states[0].trajectories["root"].components[0].angle
    assert leans[0] == 0.2
    assert [one.same_as for one in leans[2:]] == [f"{LEAN}.angle.1"] * 2
    now = {name: key_now(curves_of(scene), Edits({}, {HIP: tuple(hip), LEAN: tuple(lean)}), name) for name in names}
    assert now[f"{HIP}.angle.1"] is None
    assert now[f"{LEAN}.angle.0"] == f"{LEAN}.angle.1"
    assert {key for key in now.values() if key} == {p.name for p in free_parameters(made)}
    gone = changed(scene, curves={LEAN: (Point(1), Point(2))})  # what they followed is no more
    assert gone.controller.states[0].trajectories["root"].components[0].angle == [0.0713, 0.0713]


def test_curves_of_strength_balance_and_excitation_can_be_edited_too():
    scene = load("walk56")
    scene.controller.states[0].balance = None
    muscle = next(iter(scene.character.muscles))
    scene.character.muscles[muscle].excitation = Excitation([0.0, 1.0], [0.1, 0.2])
    scene.controller.states[0].trajectories["root"].strength = Curve([0.0], [1.0])
    curves = curves_of(scene)
    own = curves[f"character.muscles.{muscle}.excitation"]
    assert (own.across, own.straight, own.unit) == ("time", True, "")
    made = changed(scene, curves={own.key: (Point(0), Point(-1, 0.5, 0.4), Point(1))})
    assert made.character.muscles[muscle].excitation == Excitation([0.0, 0.5, 1.0], [0.1, 0.4, 0.2])
    root = made.controller.states[0].trajectories["root"]
    assert np.array_equal(root.strength.value, [1.0])
