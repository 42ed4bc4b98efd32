"""The commands that judge gaits: of files and of scenes, their tables, and what is refused."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from small_result import walk_result, with_arrays
from warpmuscle.cli.console import print_gait
from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error
from warpmuscle.examples import write as examples
from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT, bhargava_costs
from warpmuscle.plots.subject import Choices, Subject
from warpmuscle.results.result import write
from warpmuscle.scene import anatomy
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.studies import robustness

FALLS = ("--set", "failure.com_height=1.2")  # at once


def told(*words: object) -> str:
    """What a command prints."""
    done = CliRunner().invoke(app, list(map(str, words)), catch_exceptions=False, standalone_mode=False)
    return done.stdout


def cells(text: str) -> dict[str, list[str]]:
    """Cells of a printed table, by their first one."""
    rows = [[cell.strip() for cell in line.split("  ") if cell.strip()] for line in text.splitlines()]
    return {row[0]: row[1:] for row in rows if row}


def test_a_walk_in_a_file_stands_beside_people(tmp_path: Path):
    write(tmp_path / "walk.h5", walk_result())
    printed = told("gait", tmp_path / "walk.h5")
    rate = round(1.0 / walk_result().replays[0].time[1])
    assert (f"walk has {rate} frames/s" in " ".join(printed.split())) == (rate < 200)
    rows = cells(printed)
    assert rows["unit"] == ["people", "walk"]
    assert rows["stance"][:2] == ["% of the cycle", "64"]
    assert rows["speed"][0] == "m/s"
    assert float(rows["speed"][-1]) == pytest.approx(1.0, abs=0.5)


def test_scenes_are_run_and_all_numbers_written(tmp_path: Path):
    words = ("gait", "fwalk", "--duration", 4)
    printed = told(*words, "-o", tmp_path / "gait.json")
    numbers = json.loads((tmp_path / "gait.json").read_text())
    walk = numbers["walks"][0]
    assert (walk["name"], numbers["units"]["speed"]) == ("fwalk", "m/s")
    assert walk["frames_per_second"] == pytest.approx(200.0)
    assert "frames/s" not in printed
    assert numbers["people"]["stance"]["value"] == "64"
    assert float(cells(printed)["speed"][-1]) == pytest.approx(walk["measures"]["speed"], abs=0.006)
    assert 0.8 < walk["measures"]["speed"] < 1.1
    knee = walk["curves"]["Knee moment"]
    assert (knee["unit"], len(knee["left"]), len(knee["people"])) == ("N m/kg", 101, 101)
    assert 0.5 < max(knee["left"]) < 2.0
    told(*words, "-o", tmp_path / "gait.csv")
    rows = list(csv.reader((tmp_path / "gait.csv").open()))
    assert rows[0] == ["", "unit", "people", "fwalk"]
    assert len({len(row) for row in rows}) == 1


def test_what_has_no_gait_is_one_line_with_its_name(tmp_path: Path):
    with pytest.raises(Error, match=r"^fwalk: .*no whole gait cycle"):
        told("gait", "fwalk", *FALLS)
    with pytest.raises(Error, match=r"as \.csv, \.md, \.json"):
        told("gait", "fwalk", "-o", tmp_path / "gait.xlsx")
    write(tmp_path / "walk.h5", walk_result())
    with pytest.raises(Error, match=r"walk\.h5: a result file takes no --duration"):
        told("gait", tmp_path / "walk.h5", "--duration", 3)
    with pytest.raises(Error, match="none with number 7"):
        told("gait", tmp_path / "walk.h5", "--replay", 7)
    assert [path.name for path in tmp_path.iterdir()] == ["walk.h5"]


def test_robustness_tells_pushes_and_slopes(tmp_path: Path):
    words = ("--pushes", 2, "--impulse", 20, "--impulse", 300, "--slope", 1, "--duration", 1)
    rows = cells(told("robustness", "fwalk", *words, "-o", tmp_path / "a.json"))
    assert 20.0 < float(rows["fwalk"][0]) < 300.0
    assert rows["fwalk"][2] == "100 0"
    assert rows["fwalk"][3].endswith("m/s")
    written = json.loads((tmp_path / "a.json").read_text())["gaits"]
    assert written[0]["survived"] == [2, 2, 0]
    assert [trial["slope_deg"] for trial in written[0]["slopes"]] == pytest.approx([-1.0, 1.0])
    told("robustness", "fwalk", *FALLS, *words, "-o", tmp_path / "a.md")
    lines = (tmp_path / "a.md").read_text().splitlines()
    assert lines[2].startswith("| fwalk | falls without a push |  |")


def test_a_motion_that_a_policy_made_is_judged_as_it_is_and_not_as_its_scene_would_go(tmp_path: Path):
    path = tmp_path / "played.h5"
    write(path, replace(walk_result(), command="warpmuscle simulate walk56 --policy policy.h5 -o played.h5"))
    printed = told("judge", path)
    assert printed.startswith("played, judged as a walk at ")
    assert "a recording, of which nothing is simulated" in printed
    for command in ("robustness", "judge"):
        more = ("--command", "speed=1") if command == "judge" else ()
        with pytest.raises(Error, match=r"played\.h5: a policy moved this, and the file holds its motion alone"):
            told(command, path, *more)


def test_a_policy_is_pushed_as_a_scene_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for name, value in {"PUSHED_FROM": 0.5, "PUSHED_UNTIL": 1.0, "AFTERWARDS": 1.0}.items():
        monkeypatch.setattr(robustness, name, value)
    examples("policies", tmp_path)
    words = ("--pushes", 2, "--impulse", 5, "--impulse", 300, "--slope", 0.5, "--duration", 1)
    rows = cells(told("robustness", tmp_path / "walk56_like_people.h5", *words))
    assert rows["walk56_like_people"][2] == "100 0"
    assert rows["walk56_like_people"][3].endswith("m/s")


def test_an_impulse_of_nothing_is_refused():
    with pytest.raises(Error, match="positive numbers"):
        told("robustness", "fwalk", "--impulse", -3)


def test_a_run_prints_both_energies_by_name(capsys):
    result = walk_result()
    scene = Subject(result, Choices()).scene
    gait = print_gait(scene, result.replays[0])
    assert gait is not None
    steady = result.replays[0].window(gait.start)
    costs = bhargava_costs(steady, substitute(scene, start_values(scene)), gait.speed_horizontal)
    net, strict = costs[BHARGAVA_NET], costs[BHARGAVA_STRICT]
    assert net is not None
    assert strict is not None
    assert strict > net
    told = capsys.readouterr().out
    assert f"by Bhargava {net:.2f} J/(kg m) net, {strict:.2f} strict (people who walk: 3.05 to 3.51)" in told


def test_where_no_step_is_counted_it_says_what_a_step_is(capsys):
    """As of an animal whose feet are in the air for less than 0.2 s."""
    result = walk_result()
    scene, motion = Subject(result, Choices()).scene, result.replays[0]
    print_gait(scene, motion)
    assert "feet make one" not in capsys.readouterr().out
    loaded = np.where((motion.time % 0.4 < 0.22)[:, None], [0.0, 350.0, 0.0], 0.0)
    print_gait(scene, with_arrays(motion, foot_force_left=loaded, foot_force_right=loaded[::-1]))
    told = capsys.readouterr().out
    assert "0 steps; feet make one that land in turn, each after 0.2 s off the ground or more)" in told


def test_no_animal_with_bent_legs_is_told_what_people_spend(capsys, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(anatomy, "straight_legs", lambda scene: False)
    result = walk_result()
    print_gait(Subject(result, Choices()).scene, result.replays[0])
    told = capsys.readouterr().out
    assert "J/(kg m) net, " in told
    assert "people who walk" not in told
