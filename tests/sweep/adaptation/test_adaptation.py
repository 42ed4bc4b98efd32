"""Measured and predicted adaptations: what is read, what runs it makes, and changes by hand."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from command_line import run
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gait.likeness import leg_length
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.parameters import at_start, start_values, substitute
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.scene.validation.start import start_depths
from warpmuscle.sweep.adaptation.compared import FREQUENCY, angle_changes, changes, scores
from warpmuscle.sweep.adaptation.page import Comparison, page
from warpmuscle.sweep.adaptation.plan import check_not_edited, sweep_text
from warpmuscle.sweep.adaptation.predicted import Prediction
from warpmuscle.sweep.adaptation.records import Record, read_records, reference_of
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.union import groups

BASE = {"study": "a", "speed_m_s": 1.3, "subject_mass_kg": 70.0, "leg_length_m": 0.9, "metabolic_power_nd": 0.10}
LEVEL = BASE | {"identifier": "level", "stride_frequency_nd": 0.26}
UP = BASE | {"identifier": "up", "slope_pct": 8, "metabolic_power_nd": 0.18, "stride_frequency_nd": 0.27}
FOOT = BASE | {"identifier": "foot", "added_mass_kg": 7, "added_mass_where": "foot", "metabolic_power_nd": 0.15}
SLOW = BASE | {"identifier": "slow", "speed_m_s": 0.8, "metabolic_power_nd": 0.07}
FORMULA = "Bhargava, net work"


def records_of(folder: Path, *entries: dict) -> list[Record]:
    (folder / "data.json").write_text(json.dumps(list(entries)))
    return read_records(folder / "data.json")


def test_each_condition_is_compared_with_the_level_walk_of_its_study_and_speed(tmp_path: Path):
    other = LEVEL | {"identifier": "other", "study": "b"}
    up_slowly = UP | {"identifier": "up slowly", "speed_m_s": 0.8}
    records = {one.name: one for one in records_of(tmp_path, LEVEL, UP, FOOT, SLOW, other, up_slowly)}
    every = list(records.values())
    found = {name: reference_of(record, every) for name, record in records.items()}
    assert {name: one and one.name for name, one in found.items()} == {
        "level": None, "up": "level", "foot": "level", "slow": "level", "other": None, "up slowly": "slow"
    }  # fmt: skip
    assert [records[name].kind for name in ("slow", "up", "foot")] == ["speed", "uphill", "load"]


def test_runs_have_the_same_froude_number_slope_and_relative_load(tmp_path: Path):
    scene = load("reflex_planar")
    plain = substitute(scene, start_values(scene))
    records = records_of(tmp_path, LEVEL, UP, FOOT)
    (tmp_path / "sweep.toml").write_text(sweep_text(records, scene, "reflex_planar", 2, {"candidates": 10}, 5.0))
    plan = read(tmp_path / "sweep.toml")
    assert [(run.axes["run"], run.seed) for run in plan.runs] == [
        (name, seed) for name in ("level", "up", "foot") for seed in (1, 2)
    ]
    scenes = {str(run.axes["run"]): run.scene for run in plan.runs}
    assert scenes["level"].objective.target_speed == pytest.approx(1.3 * math.sqrt(leg_length(plain) / 0.9))
    assert scenes["up"].ground.normal == (0.0, 1.0, -0.08)
    assert body_mass(scenes["foot"].character) == pytest.approx(1.2 * body_mass(plain.character))  # 10 % on each foot
    assert body_mass(scenes["up"].character) == pytest.approx(body_mass(plain.character), abs=0.003)
    assert groups(plan.scenes) == [[0, 1, 2]]  # share batches


def test_loads_at_knees_and_ankles_hang_at_the_lower_end_of_the_bone_above(tmp_path: Path):
    scene = load("reflex_planar")
    at = {"study": "a", "speed_m_s": 1.3, "added_mass_kg": 3.5}
    knee, ankle, torso = (
        LEVEL | at | {"identifier": name, "added_mass_where": name} for name in ("knee", "ankle", "torso")
    )
    records = records_of(tmp_path, LEVEL, knee, ankle, torso)
    (tmp_path / "sweep.toml").write_text(sweep_text(records, scene, "reflex_planar", 1, {"candidates": 10}, 5.0))
    runs = {str(run.axes["run"]): at_start(run.scene).character for run in read(tmp_path / "sweep.toml").runs}
    mass = body_mass(at_start(scene).character)
    for name, joint in (("knee", "lKnee"), ("ankle", "rAnkle")):
        character = runs[name]
        own = character.joints[joint]
        fixed = character.joints[f"load_at_{name}_of_{own.child}"]
        assert (fixed.parent, fixed.position_in_parent) == (own.parent, own.position_in_parent)
        assert character.bodies[fixed.child].mass == pytest.approx(0.05 * mass)
        assert body_mass(character) == pytest.approx(1.1 * mass, rel=1e-3)  # on each leg
    assert body_mass(runs["torso"]) == pytest.approx(1.05 * mass, rel=1e-3)
    assert records[1].described == "1.30 m/s, 5 % of the body's mass on each knee"


@pytest.mark.parametrize("height", [1.004586, Free(1.004586, 0.9, 1.1)])
def test_no_foot_starts_in_a_slope(height: Number, tmp_path: Path):
    """Deeper than on level ground, whose contacts then threw the body up: at 8 %, none of 192 walks lasted."""
    scene = load("reflex_planar")
    start = replace(scene.initial_state, root_position=(0.010356, height, 0.0))
    scene = replace(scene, initial_state=start)
    records = records_of(tmp_path, LEVEL, UP, BASE | {"identifier": "down", "slope_pct": -15})
    text = sweep_text(records, scene, "reflex_planar", 1, {"candidates": 10}, 5.0)
    (tmp_path / "sweep.toml").write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        runs = read(tmp_path / "sweep.toml").runs
    level, up, down = (max(start_depths(at_start(run.scene)).values()) for run in runs)
    assert (up, down) == pytest.approx((level, level), abs=1e-6)
    given = runs[2].scene.initial_state.root_position[1]
    assert isinstance(given, Free) == isinstance(height, Free)
    if isinstance(given, Free):
        assert given.max - given.value == pytest.approx(1.1 - 1.004586)
    stood = text.replace('"initial_state.root_position.1"', '"initial_state.root_position.0"')
    (tmp_path / "sweep.toml").write_text(stood)
    with pytest.warns(SceneWarning) as told:
        read(tmp_path / "sweep.toml")
    up_slope, down_slope = (str(one.message) for one in told)
    assert "sweep.toml: up,seed=1: initial_state.root_position: lFoot starts 0.02 m deep in the ground" in up_slope
    assert "down,seed=1: initial_state.root_position: rFoot starts 0.04 m deep" in down_slope


def test_changes_are_of_pairs_of_seeds_over_the_measured_reference(tmp_path: Path):
    records = records_of(tmp_path, LEVEL, UP)
    found = {
        "level": {seed: Prediction({FORMULA: 0.20 + 0.01 * seed}, 0.25) for seed in range(3)},
        "up": {seed: Prediction({FORMULA: 0.24 + 0.01 * seed}, 0.25) for seed in range(1, 4)},
    }
    power, frequency = changes(records, found)
    assert (power.quantity, power.seeds) == (FORMULA, 2)
    assert (power.measured, power.predicted) == pytest.approx((80.0, 40.0))  # 0.04 of 0.08 more, over 0.10
    assert (frequency.quantity, frequency.predicted) == (FREQUENCY, 0.0)
    assert frequency.measured == pytest.approx(100.0 * 0.01 / 0.26)
    score = scores([power])[0]
    assert (score.kind, score.conditions, score.part, score.error) == pytest.approx(("uphill", 1, 0.5, 40.0))


def test_studies_are_scored_by_themselves_where_several_have_conditions_of_a_kind(tmp_path: Path):
    other = {"study": "b", "metabolic_power_nd": 0.10}
    level, up = LEVEL | other | {"identifier": "level b"}, UP | other | {"identifier": "up b"}
    records = records_of(tmp_path, LEVEL, UP, level, up | {"metabolic_power_nd": 0.12})
    powers = {"level": 0.2, "up": 0.24, "level b": 0.2, "up b": 0.22}
    found = {name: {1: Prediction({FORMULA: power}, 0.25)} for name, power in powers.items()}
    rows = {one.kind: one for one in scores([one for one in changes(records, found) if one.quantity == FORMULA])}
    assert list(rows) == ["uphill", f"uphill, {LEVEL['study']}", "uphill, b"]
    assert [one.conditions for one in rows.values()] == [2, 1, 1]
    assert rows["uphill, b"].part == pytest.approx(1.0)  # 20 of 20 %
    assert rows[f"uphill, {LEVEL['study']}"].part == pytest.approx(0.5)  # 40 of 80 %
    assert rows["uphill"].part == pytest.approx((80.0 * 40.0 + 20.0 * 20.0) / (80.0**2 + 20.0**2))


def test_loads_are_scored_by_where_they_are(tmp_path: Path):
    loads = [
        LEVEL | {"identifier": place, "added_mass_kg": 4, "added_mass_where": place, "metabolic_power_nd": power}
        for place, power in (("foot", 0.12), ("torso", 0.11))
    ]
    records = records_of(tmp_path, LEVEL, *loads)
    powers = {"level": 0.2, "foot": 0.23, "torso": 0.2}
    found = {name: {1: Prediction({FORMULA: power}, 0.25)} for name, power in powers.items()}
    rows = {one.kind: one for one in scores([one for one in changes(records, found) if one.quantity == FORMULA])}
    assert list(rows) == ["load", "load, foot", "load, torso"]
    assert (rows["load, foot"].conditions, rows["load, foot"].part) == (1, pytest.approx(1.5))  # 30 of 20 %
    assert rows["load, torso"].part == pytest.approx(0.0)


def test_the_page_says_in_words_what_was_walked(tmp_path: Path):
    records = records_of(tmp_path, LEVEL, UP, FOOT, BASE | {"identifier": "down", "slope_pct": -8, "added_mass_kg": 14})
    assert [one.described for one in records] == [
        "1.30 m/s", "1.30 m/s, up 8 %", "1.30 m/s, 10 % of the body's mass on each foot",
        "1.30 m/s, down 8 %, 20 % of the body's mass on the torso",
    ]  # fmt: skip
    found = {"level": {1: Prediction({FORMULA: 0.2}, 0.25)}, "up": {1: Prediction({FORMULA: 0.24}, 0.25)}}
    made = changes(records, found)
    text = page(Comparison(4, 4, made, scores(made), [], {"foot": "fell"}), "the sweep", "the command")
    assert '<td>1.30 m/s, up 8 %<br><span class="quiet">up</span></td><td>a</td><td>uphill</td>' in text
    assert '<td class="n">80.00</td><td class="n">40.00</td>' in text
    assert "by 27 %, and so predict 73 %" in text


def test_changes_of_angles_are_over_the_stride(tmp_path: Path):
    def curves(hip: float) -> dict:
        shape = {"hip_flexion_deg": [hip] * 5, "knee_angle_deg": [-10.0] * 5, "ankle_angle_deg": [0.0, 1, 2, 3, 4]}
        return {"curves_right": shape}

    records = records_of(tmp_path, LEVEL | curves(20.0), UP | curves(26.0))
    flat = np.zeros(101)
    found = {
        "level": {1: Prediction({}, 0.25, (flat, flat, flat))},
        "up": {1: Prediction({}, 0.25, (flat + 2.0, flat + 3.0, flat))},
    }
    (change,) = angle_changes(records, found)
    assert change.error == pytest.approx((4.0, 3.0, 0.0))
    assert change.measured == pytest.approx((6.0, 0.0, 0.0))
    assert records[0].angles[1] == pytest.approx(np.full(5, 10.0))  # flexion is positive


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not valid JSON"),
        ("{}", "is not a list"),
        ("[]", "is not a list"),
        ("[" * 100_000, "not valid JSON"),
        (json.dumps([LEVEL, LEVEL]), "conditions 1 and 2 have the same identifier, '"),
        (json.dumps([LEVEL, {"study": "a"}]), "condition 2"),
        (json.dumps([LEVEL | {"speed_m_s": "fast"}]), "condition 1.speed_m_s"),
        (json.dumps([LEVEL | {"speed_m_s": 0}]), "speed_m_s must be greater than 0"),
        (json.dumps([LEVEL | {"slope_pct": 1e9}]), "slope_pct must be within 100"),
        (json.dumps([LEVEL | {"metabolic_power_nd": float("nan")}]), "metabolic_power_nd is not finite"),
        (json.dumps([FOOT | {"added_mass_kg": -1}]), "must not be negative"),
        (json.dumps([LEVEL | {"curves_right": dict.fromkeys(
            ("hip_flexion_deg", "knee_angle_deg", "ankle_angle_deg"), "no")}]), "not a list of numbers"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_list_of_conditions_is_refused(text: str, message: str, tmp_path: Path):
    (tmp_path / "data.json").write_text(text)
    with pytest.raises(Error, match=message):
        read_records(tmp_path / "data.json")


def test_a_load_that_nothing_carries_is_refused(tmp_path: Path):
    records = records_of(tmp_path, FOOT | {"added_mass_where": "hat"})
    with pytest.raises(Error, match="foot: no place of a load is called 'hat'; there are pelvis"):
        sweep_text(records, load("reflex_planar"), "reflex_planar", 1, {"candidates": 10}, 5.0)


def test_a_file_of_ones_own_is_not_replaced_by_the_sweep_that_is_made(tmp_path: Path):
    (tmp_path / "data.json").write_text(json.dumps([LEVEL, UP]))
    (tmp_path / "mine.toml").write_text('base = "reflex_planar"\n')
    done = run("adaptation", "data.json", "--scene", "mine.toml", "-o", "mine.h5", "--device", "cpu", folder=tmp_path)
    assert done.returncode == 2
    assert "mine.toml: would be replaced by the sweep of these conditions" in done.stderr
    assert (tmp_path / "mine.toml").read_text() == 'base = "reflex_planar"\n'
    again = sweep_text(records_of(tmp_path, LEVEL), load("reflex_planar"), "reflex_planar", 1, {}, 5.0)
    (tmp_path / "mine.toml").write_text(again)
    check_not_edited(tmp_path / "mine.toml")


def test_settings_hold_in_all_runs_but_of_what_conditions_say(tmp_path: Path):
    records = records_of(tmp_path, LEVEL, UP)
    settings = {"objective.speed": 300, "objective.metabolic_model": "margaria"}
    text = sweep_text(records, load("reflex_planar"), "reflex_planar", 1, {"candidates": 10}, 5.0, settings)
    (tmp_path / "sweep.toml").write_text(text)
    objectives = [run.scene.objective for run in read(tmp_path / "sweep.toml").runs]
    assert [(one.speed, one.metabolic_model) for one in objectives] == [(300.0, "margaria")] * 2
    with pytest.raises(Error, match=r"--set ground\.normal: slopes are those of the conditions"):
        sweep_text(records, load("reflex_planar"), "reflex_planar", 1, {}, 5.0, {"ground.normal": [0, 1, 0]})


def test_a_wrong_setting_is_named_and_nothing_is_written(tmp_path: Path):
    (tmp_path / "data.json").write_text(json.dumps([LEVEL, UP]))
    done = run("adaptation", "data.json", "--set", "objective.sped=3", "--device", "cpu", folder=tmp_path)
    assert done.returncode == 2
    assert "objective.sped" in done.stderr
    assert "speed" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["data.json"]
