"""A study from its file to its page: measures are those of its runs' motions, and nothing in it can run."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest

import command_line
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gait.quality import gait_measures
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.result import read as read_result
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies.conditions import Cell, Expected, Spread, verdict_of
from warpmuscle.studies.energy_balance import MEASURES, balance_measures
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.run import sweep
from warpmuscle.sweep.study import page as study_page
from warpmuscle.sweep.study.measured import Held, MeasuredRun, StudyResult, _rows, in_all, measured

TEXT = """
scene = "fwalk"
[set]
duration = 4
[search]
strategy = "random"
candidates = 2
sigma = 0.01
[grid]
seed = [1, 2]
load = { keys = ["character.bodies.torso.mass"], factors = [1, 1.2] }
[study]
title = "Loads <script>alert(1)</script>"
measures = ["cost", "speed", "step*"]
[[study.expected]]
measure = "speed"
change = "falls"
source = "nobody"
[[study.expected]]
measure = "cadence"
value = 3.5
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("study")
    (folder / "loads.toml").write_text(TEXT)
    return folder


@pytest.fixture(scope="module")
def found(folder: Path) -> StudyResult:
    plan = read(folder / "loads.toml")
    return measured(plan, sweep(plan, folder / "loads.h5", device="cpu"))


def test_measures_are_those_of_the_best_motions(found: StudyResult, folder: Path):
    assert found.measures == ["cost", "speed", "step length", "step width", "cadence"]
    assert len(found.runs) == 4
    for run in found.runs:
        result = read_result(folder / "loads.h5", run.run.name)
        alone = gait_measures(result.replays[0], recorded_scene(result))
        assert result.best is not None
        powers = balance_measures(result.replays[0], recorded_scene(result))
        assert set(powers) == {name for name in MEASURES if not name.endswith(("fibres", "damping"))}  # no muscles
        assert run.measures == {"cost": result.best.cost} | alone | powers
    row = next(row for row in found.rows if row.measure == "speed")
    for cell, condition in zip(row.cells, (1.0, 1.2), strict=True):
        speeds = [run.measures["speed"] for run in found.runs if run.condition == condition]
        assert cell.spread.median == pytest.approx(np.median(speeds))


def test_power_in_all_is_that_of_body_and_loads():
    scene = load("reflex_planar")
    plain = substitute(scene, start_values(scene))
    assert in_all({"metabolic power": 5.0}, plain) == {"metabolic power in all": pytest.approx(5.0 * 70.4)}
    plain.character.bodies["torso"].mass += 16.0
    assert in_all({"metabolic power": 5.0}, plain) == {"metabolic power in all": pytest.approx(5.0 * 86.4)}
    assert in_all({"metabolic power": None}, plain) == {}


def test_what_is_expected_stays_open_with_two_seeds(found: StudyResult):
    assert [(held.expected.measure, held.cell.condition, held.verdict) for held in found.held] == [
        ("speed", 1.2, "open"), ("cadence", 1.2, "open"),
    ]  # fmt: skip


def test_a_measure_that_no_run_gives_is_named(folder: Path, tmp_path: Path):
    file = tmp_path / "loads.toml"
    file.write_text(TEXT.replace('"step*"', '"muscle mass"'))
    plan = read(file)
    with pytest.raises(Error, match=r"the study asks for 'muscle mass'.*; its runs give: cost, speed"):
        measured(plan, sweep(plan, folder / "loads.h5", device="cpu"))


def test_a_study_whose_runs_all_fell_shows_their_costs(folder: Path, tmp_path: Path):
    file = tmp_path / "loads.toml"
    file.write_text(TEXT.replace('"step*"', '"muscle mass"'))
    runs = [MeasuredRun(run, 1.0, "", False, {"cost": 2e6}, "fell") for run in read(file).runs]
    study = read(file).study
    assert study is not None
    rows = _rows(study, runs)
    assert [(row.measure, row.cells[0].walked) for row in rows] == [("cost", 0)]


def test_the_page_has_every_number_and_a_walk_of_each_condition(found: StudyResult, folder: Path):
    page = study_page.page(found, read(folder / "loads.toml"), "warpmuscle study loads.toml")
    assert len(page.encode()) < 1_000_000
    assert "<script" not in page
    assert "Loads &lt;script&gt;" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    for number, what in (("4 of 4", "walked to the end"), ("0 of 2", "as expected"), ("2", "left open")):
        assert f"<b>{number}</b><span>{what}</span>" in page
    assert page.count("<iframe srcdoc=") == 1  # a walk of each condition, in a page of its own
    assert "found: change from load 1<" in page
    assert page.count("<td>load 1.2</td>") == 2
    for row in found.rows:
        for cell in row.cells:
            assert f'<td class="n">{study_page.number(row.unit, cell.spread.median)}<small>' in page


def test_the_command_writes_page_and_table_and_refuses_what_is_no_study(folder: Path, tmp_path: Path):
    (tmp_path / "loads.toml").write_text(TEXT)
    done = command_line.run("study", "loads.toml", "--device", "cpu", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "open: speed falls at 1.2; found" in done.stdout
    rows = list(csv.DictReader((tmp_path / "loads.csv").read_text().splitlines()))
    assert [(row["seed"], row["load"], row["walked"]) for row in rows] == [
        ("1", "1", "yes"), ("1", "1.2", "yes"), ("2", "1", "yes"), ("2", "1.2", "yes"),
    ]  # fmt: skip
    assert all(0.1 < float(row["speed (m/s)"]) < 2.0 for row in rows)
    assert (tmp_path / "loads.html").exists()
    (tmp_path / "plain.toml").write_text(TEXT[: TEXT.index("[study]")])
    refused = command_line.run("study", "plain.toml", folder=tmp_path)
    assert refused.returncode == 2
    assert "plain.toml: no [study]" in refused.stderr


@pytest.mark.parametrize(
    ("interval", "words"),
    [
        ((0.2, 0.8), "agrees in sign, not in size"),
        ((0.2, 3.0), "agrees"),
        ((-0.2, 0.8), "open"),
        ((-2.0, -1.0), "contradicts"),
    ],
)
def test_a_page_says_whether_a_change_agrees_in_size(interval: tuple[float, float], words: str):
    spread = Spread(20, float(np.mean(interval)), *interval)
    cell, expected = Cell("up 8 %", 20, 20, spread, spread, interval), Expected("speed", "rises", "up 8 %", 2.8)
    assert study_page._words(Held(expected, "", cell, verdict_of(expected, cell))) == words


def test_a_change_that_rounds_to_nothing_has_no_sign():
    assert study_page.number("m/s", -0.0001) == "0.00"
    assert study_page.number("m/s", float("nan")) == ""


def test_costs_of_falls_are_called_so_and_the_sign_of_angles_is_told(found: StudyResult, folder: Path):
    nothing = Spread(0, np.nan, np.nan, np.nan), (np.nan, np.nan)
    cells = (
        Cell(1.0, 2, 2, Spread(2, 1.0, 1.0, 2.0), *nothing), Cell(1.2, 2, 0, Spread(2, 1.8e6, 1.8e6, 1.9e6), *nothing)
    )  # fmt: skip
    changed = [
        dataclasses.replace(row, cells=cells, unit="deg" if row.measure == "speed" else row.unit)
        for row in found.rows
        if row.measure in ("cost", "speed")
    ]
    study = dataclasses.replace(found.study, expected=())
    text = study_page.page(
        dataclasses.replace(found, rows=tuple(changed), held=(), study=study), read(folder / "loads.toml"), ""
    )
    assert text.count(">fell<") == 1
    assert "Angles are flexion of hips and knees, and dorsiflexion of ankles." in text
    assert "Angles are flexion" not in study_page.page(found, read(folder / "loads.toml"), "")
