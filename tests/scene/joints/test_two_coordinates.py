"""Functions of two coordinates: their derivatives, the motion that two joints share, and what a scene may not say."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import conjugate, multiply
from warpmuscle.formats import load, save
from warpmuscle.scene import Body, Character, Displacement, Failure, Joint, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.two_coordinates import bend_rates, rates_of_two

STEP = 1e-5
ORIGIN, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TERMS = [(1.3, 1, 1), (0.4, 2, 3), (-0.2, 0, 2), (0.7, 1, 0)]


def rod(length: float = 0.3) -> Displacement:
    return Displacement(X, rod=[length, 0.1, 0.6])


def polynomial() -> Displacement:
    return Displacement((0.6, 0.0, 0.8), value=0.2, terms=TERMS)


def scene() -> Scene:
    """A link on two hinges, which a rod or a turn of both carries on."""
    bodies = {name: Body(1.0, (0.1, 0.2, 0.3)) for name in ("base", "second", "tip")}
    bodies |= {name: Body(0.0, ORIGIN) for name in ("first", "middle")}
    shared = [replace(rod(), axis=axis) for axis in (X, Y, Z)]
    joints = {
        "q": Joint("hinge", "base", "first", ORIGIN, ORIGIN, [X]),
        "p": Joint("hinge", "first", "second", ORIGIN, ORIGIN, [Z]),
        "one": Joint("coupled", "second", "middle", ORIGIN, ORIGIN, translations=shared, follows="q", beside="p"),
        "two": Joint("coupled", "middle", "tip", ORIGIN, ORIGIN, translations=shared, follows="p", beside="q",
            rate_only=True),
    }  # fmt: skip
    return Scene("arc", Character("base", bodies, joints, "fixed"), failure=Failure(com_height=0.0, heading=0.0))


@pytest.mark.parametrize("rate_only", [False, True])
@pytest.mark.parametrize("component", [0, 1, 2])
@pytest.mark.parametrize("made", [rod, polynomial])
def test_derivatives_are_those_of_the_values(made, component: int, rate_only: bool):
    q, p = np.random.default_rng(1).uniform(-0.9, 0.9, (2, 60))
    q[0], p[0] = (-0.6, -0.1) if rate_only else (-0.1, -0.6)  # where the rod is straight
    one = made()
    found = rates_of_two(one, component, rate_only, q, p)

    def slope(name: str, dq: float, dp: float) -> np.ndarray:
        ahead, behind = (rates_of_two(one, component, rate_only, q + s * dq, p + s * dp) for s in (STEP, -STEP))
        return (getattr(ahead, name) - getattr(behind, name)) / (2.0 * STEP)

    np.testing.assert_allclose(found.first, slope("value", 1.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(found.second, slope("first", 1.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(found.mixed, slope("first", 0.0, 1.0), atol=1e-9)


def test_the_series_and_the_closed_form_meet():
    e = np.array([0.19999999, 0.20000001])
    for rate in bend_rates(e):
        assert rate[0] == pytest.approx(rate[1], rel=1e-7)
    theta = np.linspace(1e-3, 3.0, 200)
    np.testing.assert_allclose(bend_rates(1.0 - np.cos(theta))[0], np.sin(theta) / theta, rtol=1e-12)


@pytest.mark.parametrize("kind", ["rotations", "translations"])
def test_both_joints_together_move_as_the_pose_does(kind: str):
    one = Joint("coupled", "a", "b", ORIGIN, ORIGIN, follows="q", beside="p", **{kind: [polynomial()]})
    back = [(a, n, m) for a, m, n in TERMS]
    two = replace(one, follows="p", beside="q", rate_only=True, **{kind: [replace(polynomial(), terms=back)]})
    q, v = np.random.default_rng(2).uniform(-0.8, 0.8, (2, 30, 2))

    def moved(time: float) -> list:
        at = q + time * v
        return [joint_type(one).motion(one, at, v), joint_type(two).motion(two, at[:, ::-1], v[:, ::-1])]

    def twist(both: list) -> np.ndarray:
        parts = [np.concatenate([m.turning[0], m.moving[0]], axis=1) * v[:, k : k + 1] for k, m in enumerate(both)]
        return sum(parts)

    before, here, after = (moved(k * STEP) for k in (-1.0, 0.0, 1.0))
    turn = multiply(after[0].orientation, conjugate(before[0].orientation))
    speed = np.concatenate([turn[:, :3] / STEP, (after[0].place - before[0].place) / (2.0 * STEP)], axis=1)
    np.testing.assert_allclose(twist(here), speed, atol=1e-8)
    drift = sum(np.concatenate([m.turning_drift, m.moving_drift], axis=1) for m in here)
    np.testing.assert_allclose(drift, (twist(after) - twist(before)) / (2.0 * STEP), atol=1e-8)


def test_a_scene_with_them_is_saved_and_loaded(tmp_path: Path):
    save(scene(), tmp_path / "arc.toml")
    assert load(tmp_path / "arc.toml").character == scene().character


def test_a_model_of_opensim_does_not_hold_them(tmp_path: Path):
    with pytest.raises(SceneError, match="a joint that depends on two coordinates"):
        save(scene(), tmp_path / "arc.osim")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"beside": "nobody"}, "nobody"),
        ({"beside": "q"}, "no other joint with a single coordinate"),
        ({"follows": ""}, "only a joint that follows another one"),
        ({"beside": ""}, "only a joint that follows another one|depends on no coordinate"),
        ({"rotations": [polynomial()]}, "turns about one axis or moves along some"),
        ({"translations": [Displacement(X, slope=1.0)]}, "`value` and `terms`, or a `rod`"),
        ({"translations": [Displacement(X, value=1.0)]}, "depends on no coordinate"),
        ({"translations": [rod(), polynomial()]}, "of all translations, or of none"),
        ({"translations": [Displacement(X, rod=[1.0])]}, "a length and two angles"),
        ({"translations": [Displacement(X, terms=[(1.0, -1, 0)])]}, "from 0 to 20"),
        ({"translations": [], "rotations": [rod()]}, "moves along `translations`"),
        ({"damping": 1.0}, "takes none"),
    ],
)
def test_what_is_not_sound_is_refused(tmp_path: Path, change: dict, said: str):
    own = scene()
    own.character.joints["one"] = replace(own.character.joints["one"], **change)
    if "rate_only" not in change and change.get("beside") == "":
        own.character.joints["one"].rate_only = True
    with pytest.raises(SceneError, match=said):
        save(own, tmp_path / "bad.toml")
