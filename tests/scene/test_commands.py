"""Numbers that follow commands: their values, ranges, parameters, and how a file says them."""

import msgspec
import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import PD, Command, Robustness, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, pinned, start_values, substitute, with_values
from warpmuscle.scene.scaling import multiplied
from warpmuscle.scene.validation.checks import Checks
from warpmuscle.scene.validation.scene import check_scene

TIME = "controller.states.0.time"


@pytest.fixture
def scene() -> Scene:
    """A state's time follows speed and slope; what it gains per m/s is free. A mirrored gain follows another one."""
    scene = sound_scene()
    scene.commands = {
        "speed": Command(1.25, 0.7, 1.8, unit="m/s"),
        "slope": Command(0.0, -5.0, 5.0, value=2.0, unit="deg"),
    }
    scene.controller.states[0].time = Free(0.5, 0.4, 0.6, per={"speed": Free(-0.1, -0.2, 0.0), "slope": [0.01, 0.002]})
    scene.controller.pd["rHip"] = PD(Free(100.0, per={"speed": 20.0}), 1.0)
    scene.controller.pd["root"] = PD(Free(same_as="controller.pd.rHip.kp", factor=2.0), 1.0)
    check_scene(scene)
    return scene


def test_numbers_follow_commands_of_the_scene_and_those_given(scene):
    plain = substitute(scene, start_values(scene))
    assert plain.controller.states[0].time == pytest.approx(0.5 + 0.01 * 2.0 + 0.002 * 4.0)
    faster = substitute(scene, start_values(scene), {"speed": 1.75, "slope": -1.0})
    assert faster.controller.states[0].time == pytest.approx(0.5 - 0.1 * 0.5 - 0.01 + 0.002)
    assert faster.controller.pd["root"].kp == pytest.approx(2.0 * (100.0 + 20.0 * 0.5))


def test_every_instance_may_have_a_command_of_its_own_and_parameters_too(scene):
    values = np.tile(start_values(scene), (3, 1))
    values[:, 1] = [-0.2, 0.0, -0.1]  # per speed
    numeric = substitute(scene, values, {"speed": np.array([0.75, 1.25, 1.75]), "slope": np.zeros(3)})
    np.testing.assert_allclose(numeric.controller.states[0].time, [0.6, 0.5, 0.45])
    np.testing.assert_allclose(numeric.controller.pd["rHip"].kp, [90.0, 100.0, 110.0])


def test_what_is_added_per_command_is_a_parameter_with_name_and_unit(scene):
    named = {parameter.name: parameter for parameter in free_parameters(scene)}
    assert list(named)[:2] == [TIME, f"{TIME}.per.speed"]
    assert named[f"{TIME}.per.speed"].unit == "s/(m/s)"


def test_ranges_hold_for_all_commands_and_values(scene):
    low, high = Checks(scene).interval(scene.controller.states[0].time)
    slopes = [0.01 * x + 0.002 * x * x for x in np.linspace(-5.0, 5.0, 2001)]
    assert low == pytest.approx(0.4 - 0.2 * 0.55 + min(slopes), abs=1e-6)
    assert high == pytest.approx(0.6 + 0.2 * 0.55 + max(slopes), abs=1e-6)
    assert Checks(scene).start(scene.controller.states[0].time) == pytest.approx(0.528)


def test_new_starts_and_fixed_numbers_go_on_following(scene):
    values = start_values(scene)
    values[:2] = [0.55, -0.15]
    moved = with_values(scene, values)
    np.testing.assert_array_equal(start_values(moved)[:2], [0.55, -0.15])
    fixed = pinned(moved, values, free=())
    assert fixed.controller.states[0].time == Free(0.55, per={"speed": -0.15, "slope": [0.01, 0.002]})
    assert not free_parameters(fixed)
    asked = {"speed": 1.6, "slope": 1.0}
    for part in (moved, fixed):
        numeric = substitute(part, start_values(part), asked)
        assert numeric.controller.states[0].time == pytest.approx(0.55 - 0.15 * 0.35 + 0.012)
        assert numeric.controller.pd["root"].kp == pytest.approx(214.0)


def test_a_multiplied_number_follows_as_much_more(scene):
    doubled = multiplied(scene, {TIME: 2.0})
    numeric = substitute(doubled, start_values(doubled), {"speed": 1.75})
    assert numeric.controller.states[0].time == pytest.approx(2.0 * (0.528 - 0.05))


def test_files_say_it_and_a_scene_may_add_it_to_the_numbers_of_its_base(scene, tmp_path):
    path = tmp_path / "commanded.toml"
    path.write_text(toml.dumps(scene))
    assert toml.read(path) == scene
    above = tmp_path / "above.toml"
    above.write_text(
        'name = "above"\nbase = "commanded.toml"\n[controller.pd.root]\nkd = { per = { speed = 0.5 } }\n'
        "[commands.speed]\nvalue = 1.75\n"
    )
    read = toml.read(above)
    assert substitute(read, start_values(read)).controller.pd["root"].kd == pytest.approx(1.25)


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda s: s.commands.pop("slope"), f"{TIME}.per.slope", "no command is called 'slope'"),
        (lambda s: setattr(s.commands["speed"], "value", 2.0), "commands.speed.value", "2 is outside 0.7 to 1.8"),
        (lambda s: setattr(s.commands["speed"], "max", np.nan), "commands.speed.max", "nan is not a finite number"),
        (lambda s: s.commands.update({"a.b": Command(0, 0, 1)}), "commands.a.b", "one word"),
        (lambda s: setattr(s, "robustness", Robustness(commands={"speed": [1.0, 9.0]})),
         "robustness.commands.speed.1", "9 is outside"),
        (lambda s: setattr(s, "robustness", Robustness(commands={"sped": [1.0]})),
         "robustness.commands.sped", "did you mean 'speed'"),
        (lambda s: setattr(s.controller.states[0], "time", Free(0.1, per={"speed": -1.0})), TIME, "greater than 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_an_error_with_its_key(scene, change, key, words):
    change(scene)
    with pytest.raises(SceneError, match=words) as caught:
        check_scene(scene)
    assert caught.value.key == key


@pytest.mark.parametrize(
    "wrong",
    [
        {"value": 1.0, "min": 0.0},
        {"same_as": "x", "per": {"speed": 1.0}},
        {"value": 1.0, "per": {"speed": []}},
        {"value": 1.0, "per": {"speed": [1.0, 2.0, 3.0]}},
        {"value": 1.0, "per": {"speed": {"same_as": "y"}}},
        {"value": 1.0, "per": {"speed": float("inf")}},
        {"value": 1.0, "step": 0.1, "per": {"speed": 1.0}},
    ],
)
def test_what_is_no_number_is_refused(wrong):
    with pytest.raises((ValueError, msgspec.ValidationError)):
        msgspec.convert(wrong, Free)
