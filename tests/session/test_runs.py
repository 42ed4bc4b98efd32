"""One simulation in a line of Python: what it takes, what it gives, and what it says of mistakes."""

from pathlib import Path

import numpy as np
import pytest

import warpmuscle as wm
from small_scene import muscle_scene


@pytest.fixture(scope="module")
def walk() -> wm.Run:
    return wm.simulate("fwalk", duration=3.0, device="cpu")


def test_a_run_is_what_a_rollout_of_the_scene_records(walk: wm.Run):
    rollout = wm.Rollout(wm.load("fwalk", set={"duration": 3.0}), record=[0], device="cpu")
    rollout.run()
    np.testing.assert_array_equal(walk.recording.com, rollout.recording().com)
    assert walk.duration == 3.0
    assert walk.terms == {name: float(values[0]) for name, values in rollout.terms().items()}


def test_a_run_says_in_a_line_how_it_ended_and_walked(walk: wm.Run):
    assert walk.gait is not None
    assert repr(walk).startswith("Run(fwalk, ended after 3 s, reached the end of the simulated time, speed ")
    assert "<table>" in walk._repr_html_()
    assert "<iframe" in walk._repr_html_()


def test_what_is_saved_is_read_again_and_drawn(walk: wm.Run, tmp_path: Path):
    walk.save(tmp_path / "a.h5")
    result = wm.read(tmp_path / "a.h5")
    np.testing.assert_array_equal(result.replays[0].com, walk.recording.com)
    walk.plot("Knee flexion", tmp_path / "knee.png")
    assert (tmp_path / "knee.png").stat().st_size > 1000
    walk.show().save(tmp_path / "a.html")


def test_tables_have_a_row_a_frame(walk: wm.Run):
    assert len(walk.to_dataframe()) == walk.to_xarray().sizes["time"] == walk.recording.frames


def test_a_run_says_what_it_has_and_takes_the_names_that_people_use(walk: wm.Run):
    assert {"joint_angle", "com"} <= set(walk.keys())
    assert "joint_angle" in walk
    assert "hip flexion" in walk
    assert "hip flexon" not in walk
    assert 3 not in walk
    for name, same in (("ankle angle", "ankle dorsiflexion"), ("Knee angle", "knee flexion")):
        np.testing.assert_array_equal(walk[name], walk[same])


@pytest.mark.usefixtures("unoptimized_test")
def test_constant_excitations_reach_the_muscles_that_are_named():
    scene = muscle_scene()
    first, *others = scene.character.muscles
    run = wm.simulate(scene, 0.3, excitations={first: 0.7}, device="cpu")
    excitation = dict(zip(run.recording.muscle_names, run.recording.muscle_excitation[-1], strict=True))
    assert excitation[first] == pytest.approx(0.7, abs=1e-6)
    assert all(excitation[name] == pytest.approx(0.0, abs=1e-6) for name in others)


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"excitations": {"nobody": 0.5}}, "excitations: no muscle is called 'nobody'"),
        ({"excitations": {"first": 1.5}}, "excitation of first must be a finite number, 0 or greater|from 0 to 1"),
        ({"excitations": 0.5}, "excitations are by muscle, such as"),
        ({"duration": -1.0}, "duration must be a finite number greater than 0"),
        ({"set": {"objective.target_sped": 1.0}}, "objective.target_sped"),
        ({"set": [1.0]}, "set must be a dict"),
        ({"commands": {"speed": 1.0}}, "takes no command 'speed'"),
        ({"commands": {"speed": "fast"}}, "command speed must be a finite number"),
        ({"policy": "absent.h5", "excitations": {}}, "a policy excites the muscles itself"),
        ({"policy": "absent.h5"}, "absent.h5"),
    ],
)
def test_mistakes_are_named_in_a_line(arguments: dict, why: str):
    scene = muscle_scene()
    muscle = next(iter(scene.character.muscles))
    if "first" in (arguments.get("excitations") if isinstance(arguments.get("excitations"), dict) else {}):
        arguments, why = {"excitations": {muscle: 1.5}}, f"excitation of {muscle} must be a finite number from 0 to 1"
    with pytest.raises(wm.Error, match=why) as caught:
        wm.simulate(scene, **({"duration": 0.1} | arguments), device="cpu")
    assert "\n" not in str(caught.value)


def test_commands_are_those_that_the_scene_takes():
    run = wm.simulate("walk56_commands", 0.05, commands={"speed": 1.5}, device="cpu")
    assert run.scene.commands["speed"].value == 1.5
    with pytest.raises(wm.Error, match="command speed: 9 is outside"):
        wm.simulate("walk56_commands", 0.05, commands={"speed": 9.0}, device="cpu")


def test_a_run_in_the_place_of_its_recording_is_told_where_that_is():
    with pytest.raises(ValueError, match=r"recording must be a Recording, not a Run; it has one: its \.recording$"):
        wm.measure(wm.simulate("fwalk", duration=0.1), "lFoot", "rFoot")


def test_a_run_has_its_times():
    run = wm.simulate("fwalk", duration=0.1)
    np.testing.assert_array_equal(run.time, run.recording.time)


def test_a_run_that_diverges_at_once_says_so_and_has_nothing_to_show(tmp_path: Path):
    run = wm.simulate("fwalk", 3.0, device="cpu", set={"initial_state.root_velocity.2": 1e9})
    assert run.recording.frames == 0
    assert "diverged" in repr(run)
    assert "diverged" in run._repr_html_()  # as a notebook shows it
    assert "<iframe" not in run._repr_html_()
    for shown in (run.show, lambda: run.save(tmp_path / "a.html")):
        with pytest.raises(wm.Error, match="nothing to show: the motion has no frames"):
            shown()
    for name in ("hip flexion", "hip_flexion"):
        with pytest.raises(wm.Error, match=r"motion 0 has no frames|a curve by its name"):
            run[name]


@pytest.mark.usefixtures("unoptimized_test")
def test_a_curve_that_a_run_does_not_have_is_not_answered_by_its_own_name():
    arm = wm.simulate(muscle_scene(), 0.3, device="cpu")
    with pytest.raises(wm.Error) as told:
        arm["hip flexion"]
    assert "run['hip flexion']" not in str(told.value)
