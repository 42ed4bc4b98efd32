"""Properties of muscles fitted to a skeleton and its gait."""

import math

import msgspec
import numpy as np
import pytest

from small_result import march
from warpmuscle.core.errors import ArgumentError, SceneError
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.scene.joints.symmetry import counterpart
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies import fit_muscles as fit_muscles_module
from warpmuscle.studies.fit_muscles import PropertyTable, fit_muscles, torque_motion


def test_a_motion_on_torques_is_taken_from_its_first_seconds_on_if_it_is_longer(monkeypatch: pytest.MonkeyPatch):
    """A march of 2 s in place of the simulation."""
    scene = load("fwalk")
    motion = march(scene.character, 1.1)

    class Marching:
        def __init__(self, scene, instances, device, **more):
            assert {one.drive for one in scene.actuation.values()} == {"torque"}

        def run(self):
            pass

        def recording(self):
            return motion

    monkeypatch.setattr(fit_muscles_module, "Rollout", Marching)
    later, whole = (torque_motion(scene, settle, "cpu") for settle in (0.5, 2.5))
    assert (later.time[0], whole.time[0]) == pytest.approx((0.5, 0.0), abs=0.021)
    assert whole.frames == motion.frames > later.frames > 0.7 * motion.frames


@pytest.fixture(scope="module")
def fitted() -> Scene:
    return fit_muscles(load("walk56_legacy"), device="cpu")


def test_shipped_properties_are_those_of_the_fit(fitted: Scene):
    """Rounding aside: 0.1 mm and 1 N, and motions differ in the last digits from machine to machine."""
    walk56 = load("walk56")
    shipped, muscles = substitute(walk56, start_values(walk56)).character.muscles, fitted.character.muscles
    assert list(shipped) == list(muscles)
    for field, tolerance in (("f_max", 1.0), ("l_opt", 2e-4), ("l_slack", 2e-4)):
        got, expected = ([getattr(m, field) for m in of.values()] for of in (muscles, shipped))
        np.testing.assert_allclose(got, expected, atol=tolerance * 1.001, err_msg=field)
    assert PropertyTable.of(fitted).muscles.keys() == shipped.keys()


def test_both_sides_get_the_same_properties(fitted: Scene):
    muscles = fitted.character.muscles
    pairs = {name: counterpart(name, muscles) for name in muscles}
    assert sum(bool(other) for other in pairs.values()) >= 44
    for name, other in pairs.items():
        if other:
            for field in ("f_max", "l_opt", "l_slack"):
                assert getattr(muscles[name], field) == getattr(muscles[other], field), (name, other)


def test_all_but_force_and_lengths_stays(fitted: Scene):
    before = load("walk56_legacy")
    before = substitute(before, start_values(before))
    for name, muscle in fitted.character.muscles.items():
        old = before.character.muscles[name]
        same = {field: getattr(old, field) for field in ("f_max", "l_opt", "l_slack")}
        assert msgspec.structs.replace(muscle, **same) == old
    assert msgspec.structs.replace(fitted, character=before.character) == before


def test_fibres_of_fitted_muscles_work_about_their_optimal_length(fitted: Scene):
    """Slack length plus optimal length is the mean length of the path, with a tendon of a tenth of it at least."""
    for muscle in fitted.character.muscles.values():
        assert muscle.l_slack >= 0.1 * (muscle.l_slack + muscle.l_opt) - 2e-4


def test_strength_and_mean_length_do_what_they_say():
    scene = load("walk56_legacy")
    scene.duration = 0.1
    f_max = scene.character.muscles["lGLU"].f_max  # free here, a number once it is fitted
    weak, long = fit_muscles(scene, strength=0.5, device="cpu"), fit_muscles(scene, mean_length=1.1, device="cpu")
    assert weak.character.muscles["lGLU"].f_max == round(0.5 * f_max.value)
    for name, own in long.character.muscles.items():
        assert own.l_opt <= weak.character.muscles[name].l_opt
        assert own.l_slack + 1.1 * own.l_opt == pytest.approx(
            weak.character.muscles[name].l_slack + weak.character.muscles[name].l_opt, abs=3e-4
        )


@pytest.mark.parametrize("argument", ["mean_length", "fibre_per_arm", "strength", "settle"])
@pytest.mark.parametrize("value", [math.inf, math.nan, -1.0])
def test_numbers_that_are_not_finite_or_negative_are_refused_by_name(argument: str, value: float):
    with pytest.raises(ArgumentError, match=argument):
        fit_muscles(load("walk56_legacy"), **{argument: value}, device="cpu")


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("lHAM", "rHAM"),
        ("rHAM", "lHAM"),
        ("ham_l", "ham_r"),
        ("ham_right", "ham_left"),
        ("left_ham", "right_ham"),
        ("LeftHam", "RightHam"),
        ("LHAM", "RHAM"),
        ("neck", ""),
        ("rectus", ""),
        ("longus", ""),
    ],
)
def test_mirror_finds_the_other_side_by_name(name: str, other: str):
    sided = ["lHAM", "ham_l", "ham_left", "left_ham", "LeftHam", "LHAM"]
    others = ["rHAM", "ham_r", "ham_right", "right_ham", "RightHam", "RHAM"]
    names = dict.fromkeys([*sided, *others, "neck", "rectus", "longus"])
    assert counterpart(name, names) == other


def test_character_without_muscles_cannot_be_fitted():
    with pytest.raises(SceneError, match="no muscles") as caught:
        fit_muscles(load("fwalk"))
    assert caught.value.key == "character.muscles"


def test_motion_that_ends_at_once_cannot_be_fitted_to():
    scene = load("walk56_legacy")
    scene.failure.com_height = 2.0
    with pytest.raises(SceneError, match="at once"):
        fit_muscles(scene, device="cpu")
