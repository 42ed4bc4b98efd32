"""The comparison with OpenSim, but for OpenSim: what it says without it, how it measures, and what it reads."""

import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import opensim_agreement  # noqa: E402
import opensim_energy  # noqa: E402
import opensim_inverse_dynamics  # noqa: E402
import opensim_oracle  # noqa: E402
import opensim_static_optimization  # noqa: E402

from warpmuscle.formats import load  # noqa: E402
from warpmuscle.simulation.rollout import Rollout  # noqa: E402


def test_what_is_missing_is_said_in_a_sentence(monkeypatch, tmp_path):
    model = tmp_path / "model.osim"
    model.write_text("<OpenSimDocument/>")
    monkeypatch.setenv("WARPMUSCLE_OPENSIM_CACHE", str(tmp_path))
    monkeypatch.setattr(opensim_oracle, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="OpenSim is not installed: pip install opensim"):
        opensim_oracle.numbers(model, 1, 1, 1)


def test_values_beyond_the_tolerance_are_counted_and_listed_with_both_numbers(capsys):
    theirs = np.array([[1.0, 2.0], [np.nan, 2.0], [1.0, 2.0], [1.0, 2.0]])
    ours = theirs + np.array([[0.0, 0.5], [9.0, 0.0], [0.0, -2.0], [0.01, 0.0]])
    found = opensim_agreement.measure("length", "m", ours, theirs, ["a", "b"], np.array([0.1, 0.2]))
    assert (found.count, found.within, found.worst) == (7, pytest.approx(5.0 / 7.0), 2.0)
    assert found.beyond == [{"label": "b", "poses": 2, "pose": 2, "ours": 0.0, "opensim": 2.0, "off": 2.0}]
    opensim_agreement.show({"model": "m.osim", "poses": 4, "seed": 1, "measures": [asdict(found)], "jumps": None})
    shown = capsys.readouterr().out
    assert "| length | 71.429 % | 0.1 m | 7 |" in shown
    assert "- length: b in 2 poses, worst 2: ours 0, OpenSim 2" in shown


def test_a_value_of_ours_that_is_no_number_is_beyond_any_tolerance():
    found = opensim_agreement.measure("length", "m", np.array([[np.nan]]), np.array([[1.0]]), ["a"], 0.1)
    assert (found.within, found.beyond[0]["label"]) == (0.0, "a")


def test_files_of_opensim_are_read_by_the_last_part_of_their_names(tmp_path):
    file = tmp_path / "lengths.sto"
    file.write_text(
        "x\ninDegrees=yes\nendheader\ntime\t/forceset/soleus_r|length\t/jointset/knee/angle/value\n0\t1\t2\n"
    )
    names, values, degrees = opensim_agreement.storage(file)
    assert names == ["time", "soleus_r", "angle"]
    assert values.tolist() == [[0.0, 1.0, 2.0]]
    assert degrees


def test_metabolic_power_of_a_walk_is_that_of_opensims_probes_but_for_its_definitions(reference_data):
    pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    model = reference_data / "opensim_models" / "gait2392_millard2012muscle.osim"
    rows = {row.formula: row for row in opensim_energy.compare(model, load("gait2392_walk"), 1.6)}
    assert set(rows) == {"bhargava", "umberger"}
    for row in rows.values():
        assert abs(row.off) < 0.02
        assert row.muscle < 0.01 * row.ours
    assert rows["umberger"].definition > 0.03 * rows["umberger"].ours  # 4 times the heat of lengthening, for 0.3


def test_inverse_dynamics_of_opensim_gives_the_torques_that_were_recorded(reference_data):
    pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    scene = load("gait2392_walk")
    scene.duration = 1.0
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0)
    rollout.run()
    model = reference_data / "opensim_models" / "gait2392_millard2012muscle.osim"
    found = opensim_inverse_dynamics.compare(rollout.recording(), scene, model, 0.0, 0.3, False)
    assert {"lumbar_bending", "hip_flexion_l", "knee_angle_r", "mtp_angle_l"} <= {one.coordinate for one in found}
    assert max(one.worst for one in found) < 0.02


def test_the_optimum_of_what_opensim_is_asked_has_multipliers_as_it_should():
    """At an optimum each activation is its share of the reserves' price, or at a bound that it would pass."""
    random = np.random.default_rng(2)
    made, reserve = random.normal(size=(4, 9)), np.diag(random.uniform(0.05, 0.2, 4))
    low, high = np.full(9, 0.01), np.ones(9)
    problem = opensim_static_optimization.Problem(made, reserve, made @ np.full(9, 0.8), np.ones(4), low, high)
    found = problem.optimum()
    pull = made.T @ np.linalg.solve(reserve.T, problem.reserves(found))
    free = (found > low) & (found < high)
    assert 0 < free.sum() < 9
    assert found == pytest.approx(np.clip(pull, low, high), abs=1e-9)
    assert problem.cost(found) < min(problem.cost(np.clip(found + 0.01 * step, low, high)) for step in np.eye(9))
