"""The first guesses of somebody new work, and a closed rollout says so."""

import re

import numpy as np
import pytest

import warpmuscle as wm
from first_guesses import first_guesses
from warpmuscle.core.errors import RolloutError
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
