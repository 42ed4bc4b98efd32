"""The first guesses of somebody new work, and a closed rollout says so."""

import copy
import pickle
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import warpmuscle as wm
from first_guesses import first_guesses
from warpmuscle.core.errors import RolloutError
from warpmuscle.plots import one_curve
from warpmuscle.plots.names import curves_named
from warpmuscle.scene import Scene


def test_the_script_of_first_guesses_runs(tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    said = first_guesses(tmp_path)
    assert "Run(fwalk, ended after 1 s" in said[1]
    assert (tmp_path / "page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert wm.read(tmp_path / "found.h5").best is not None


def test_parameters_by_name_change_these_alone():
    rollout = wm.Rollout("fwalk", instances=3)
    before = np.array([one.value for one in rollout.parameters])
    first, second = rollout.parameter_names[:2]
    rollout.set_parameters({second: 0.25})
    rollout.set_parameters({first: [0.6, 0.65, 0.7]})
    expected = np.tile(before, (3, 1))
    expected[:, 0], expected[:, 1] = [0.6, 0.65, 0.7], 0.25
    other = wm.Rollout("fwalk", instances=3)
    other.set_parameters(expected)
    for one in (rollout, other):
        one.run(0.2)
    np.testing.assert_array_equal(rollout.state.coordinates.numpy(), other.state.coordinates.numpy())


@pytest.mark.parametrize(("values", "message"), [
    ({"controller.states.0.tim": 1.0}, "no free parameter is called 'controller.states.0.tim'; did you mean"),
    ({"controller.states.0.time": [0.6, 0.7]}, "one for each of 3 instances, is needed"),
    ({"controller.states.0.time": float("nan")}, "not a finite number"),
    ({"controller.states.0.time": "long"}, "controller.states.0.time"),
])  # fmt: skip
def test_other_names_and_shapes_are_told(values, message):
    rollout = wm.Rollout("fwalk", instances=3)
    with pytest.raises(RolloutError, match=re.escape(message)):
        rollout.set_parameters(values)


def test_a_rollout_is_free_at_the_end_of_with():
    with wm.Rollout("fwalk") as rollout:
        rollout.run(0.1)
    assert repr(rollout) == "Rollout(closed)"
    with pytest.raises(RolloutError, match="this rollout is closed"):
        rollout.run(0.1)
    with pytest.raises(RolloutError, match="this rollout is closed"):
        rollout.cost()
    with pytest.raises(RolloutError, match="this rollout is closed"):
        rollout.recordings()
    rollout.close()


def test_a_recording_knows_the_numbers_of_its_instance():
    rollout = wm.Rollout("fwalk", instances=2, record=[0, 1])
    name = rollout.parameter_names[0]
    rollout.set_parameters({name: [0.6, 0.7]})
    rollout.run(0.1)
    made = [rollout.recording(k).origin for k in (0, 1)]
    scenes = [one() for one in made if one is not None]
    assert all(isinstance(scene, Scene) for scene in scenes)
    assert [float(scene.controller.states[0].time) for scene in scenes] == pytest.approx([0.6, 0.7])


@pytest.fixture(scope="module")
def walked():
    return wm.simulate("fwalk", duration=0.2)


def test_a_scene_is_changed_and_asked_by_the_same_paths():
    scene = wm.load("walk56", duration=2)
    assert scene.duration == scene["duration"] == 2.0
    other = wm.load(scene, set={"controller.states.0.time": 0.6, "character.muscles.rSOL.f_max": 9.0})
    assert (scene["controller.states.0.time"].value, other["controller.states.0.time"]) == (0.7, 0.6)
    assert other["character.muscles.rSOL.f_max"] == other.character.muscles["rSOL"].f_max == 9.0
    assert copy.deepcopy(other) == pickle.loads(pickle.dumps(other)) == other
    with pytest.raises(KeyError, match=r"^no muscle is called 'rsol'; did you mean 'rSOL'\?$"):
        scene.character.muscles["rsol"]
    with pytest.raises(KeyError, match=r"^no body is called 'foot'; did you mean 'lFoot' or 'rFoot'\?$"):
        scene.character.bodies["foot"]
    with pytest.raises(KeyError, match=r"asked for by its name, such as \['"):
        scene.character.joints[0]


def test_a_rollout_gives_its_recordings_by_number_and_is_drawn():
    pytest.importorskip("matplotlib")
    with wm.Rollout("fwalk", instances=2, record=[0, 1]) as rollout:
        rollout.run(0.1)
        assert len(list(rollout)) == 2
        np.testing.assert_array_equal(rollout[-1].joint_angle, rollout.recording(1).joint_angle)
        drawn = [line for line in wm.plot(rollout, "hip flexion").axes[0].lines if len(line.get_xdata())]
        assert len(drawn) == 4
        with pytest.raises(IndexError, match="there is no instance 2 of 2"):
            rollout[2]


@pytest.mark.parametrize("name", ["right knee", "knee_angle_r", "R knee flexion", "knee flexion right"])
def test_a_curve_of_one_side_goes_by_its_name_and_the_side(walked, name):
    pytest.importorskip("xarray")
    np.testing.assert_array_equal(walked[name], walked["knee flexion"].sel(side="right"))


def test_forces_of_the_ground_are_over_both_sides_and_curves_of_a_cycle_over_time(walked):
    pytest.importorskip("xarray")
    forces = walked["ground reaction force"]
    assert forces.dims == ("time", "side", "xyz")
    np.testing.assert_array_equal(forces.sel(side="right"), walked.recording.foot_force_right)
    weight = 9.8 * sum(body.mass for body in walked.scene.character.bodies.values())
    np.testing.assert_allclose(walked["vertical ground force"], forces.sel(xyz="y") / weight, rtol=1e-5)
    assert walked["knee moment"].attrs["units"] == "N m/kg"


def test_a_table_over_time_is_drawn_with_both_sides_in_a_panel(tmp_path):
    pytest.importorskip("matplotlib")
    times = np.linspace(0.0, 1.0, 5)
    values = np.stack([times, 2.0 * times, -times], axis=1)
    table: Any = SimpleNamespace(
        names=("hip_flexion_l", "hip_flexion_r", "pelvis_tilt"), units=("N m",) * 3, times=times, values=values
    )
    figure = wm.plot(table, path=tmp_path / "moments.png")
    hip, pelvis = figure.axes[:2]
    assert [len(axes.lines) for axes in (hip, pelvis)] == [3, 2]  # with a line at 0
    np.testing.assert_array_equal(hip.lines[1].get_ydata(), 2.0 * times)
    assert (tmp_path / "moments.png").stat().st_size > 1000
    assert len(wm.plot(table, "pelvis tilt").axes) == 1
    with pytest.raises(wm.Error, match="nothing is called 'knee'; there are hip_flexion_l"):
        wm.plot(table, "knee")


def test_a_page_opens_in_the_browser_from_a_file(walked, monkeypatch):
    seen: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: bool(seen.append(address)) or len(seen) == 1)
    path = walked.show().open()
    assert seen == [path.as_uri()]
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    with pytest.raises(wm.Error, match=r"no browser was found; open .*page.html in one"):
        walked.show().open()


def test_a_curve_by_its_name_has_time_unit_and_sides(walked):
    pytest.importorskip("xarray")
    knee = walked["knee flexion"]
    assert knee.dims == ("time", "side")
    assert list(knee.side.values) == ["left", "right"]
    assert (knee.attrs["units"], knee.time.attrs["units"]) == ("deg", "s")
    np.testing.assert_array_equal(knee.time, walked.recording.time)
    column = walked.recording.joint_angle_names.index("rKnee")
    angle = np.degrees(walked.recording.joint_angle[:, column])
    np.testing.assert_allclose(walked["rKnee"], angle, atol=1e-9)
    np.testing.assert_allclose(np.abs(knee.sel(side="right")), np.abs(angle), atol=1e-3)
    assert walked["com"].dims[0] == "time"


def test_a_muscle_of_both_sides_goes_by_its_name_without_a_side_or_in_full():
    activation = np.arange(6.0).reshape(3, 2) / 10.0

    def recording(*muscles: str) -> Any:
        return SimpleNamespace(muscle_names=muscles, muscle_activation=activation, muscle_force=100.0 * activation)

    curves = {title: lines for title, _, lines in one_curve._both_sides(recording("lSOL", "rSOL"))}
    assert sorted(curves) == ["SOL", "SOL force"]
    np.testing.assert_array_equal(curves["SOL"]["right"], activation[:, 1])
    np.testing.assert_array_equal(curves["SOL force"]["left"], 100.0 * activation[:, 0])
    assert curves_named("soleus", ["lSOL", "rSOL", "SOL"]) == ["SOL"]
    assert curves_named("soleus", ["soleus_l", "soleus_r", "soleus"]) == ["soleus"]
    assert "soleus" in {title for title, _, _ in one_curve._both_sides(recording("soleus_l", "soleus_r"))}
    assert not list(one_curve._both_sides(recording("rSOL", "trunk")))


def test_a_run_names_its_quantities_one_by_one_and_a_result_has_its_curves(walked, tmp_path):
    pytest.importorskip("xarray")
    assert list(walked) == walked.keys() == list(dict(walked))
    walked.save(tmp_path / "run.h5")
    np.testing.assert_array_equal(wm.read(tmp_path / "run.h5")["knee flexion"], walked["knee flexion"])
    scenes = wm.scenes("stairs")
    assert copy.deepcopy(scenes).names == pickle.loads(pickle.dumps(scenes)).names == scenes.names


def test_what_says_where_things_are_copies_and_pickles_as_before(walked):
    assert copy.deepcopy(walked.scene) == walked.scene
    assert pickle.loads(pickle.dumps(walked.gait)) == walked.gait
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(walked.recording)).time, walked.recording.time)
    assert not hasattr(walked.recording, "_repr_png_")
