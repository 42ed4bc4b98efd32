"""The command line as a user meets it."""

import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from child_signals import PROGRAM, running
from command_line import run
from patience import PATIENCE, until
from warpmuscle.cli.walkers import commanded_in_words
from warpmuscle.formats import load, toml
from warpmuscle.results.journal import Journal
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters, start_values, substitute


def changed(scene: Scene, old: str, new: str, folder: Path) -> Path:
    """The scene's TOML file with one piece of its text replaced."""
    text = toml.dumps(scene)
    assert old in text
    path = folder / "changed.toml"
    path.write_text(text.replace(old, new, 1))
    return path


def test_help_names_every_command(tmp_path):
    shown = run("--help", folder=tmp_path)
    assert shown.returncode == 0
    assert all(
        name in shown.stdout
        for name in ("info", "simulate", "optimize", "convert", "apply", "scenes", "view", "plot", "video", "synergies")
    )


def test_scenes_lists_those_with_all_words(tmp_path):
    every = run("scenes", folder=tmp_path).stdout
    found = run("scenes", "Walks", "UP", folder=tmp_path)
    lines = [line for line in found.stdout.splitlines() if line.startswith("  ")]
    assert found.returncode == 0
    assert 0 < len(lines) < len(every.splitlines()) / 2
    assert all("walks" in line.lower() and "up" in line.lower() for line in lines)
    wrong = run("scenes", "nosuch", folder=tmp_path)
    assert wrong.returncode != 0
    assert wrong.stderr.strip() == "error: no shipped scene has 'nosuch'; `warpmuscle scenes` lists all"


def test_info_counts_bodies_freedoms_mass_and_parameters(tmp_path):
    shown = run("info", "fwalk", folder=tmp_path).stdout
    assert "15 bodies, 14 joints, 28 joint degrees of freedom and 6 of the root, 70.4 kg" in shown
    assert "controller.pd.lHip.kp" in shown


def test_values_of_the_scene_are_set_on_the_command_line(tmp_path):
    settings = ("--set", "objective.target_speed=1.5", "--set", "description=quick", "--set", "controller.pd.*.kp=7")
    shown = run("info", "fwalk", *settings, folder=tmp_path)
    assert shown.returncode == 0, shown.stderr
    assert "quick" in shown.stdout
    assert "controller.pd.lHip.kp" not in shown.stdout  # a number now, no free parameter
    assert "controller.pd.lHip.kd" in shown.stdout


def test_simulate_prints_the_gait_and_writes_file_and_picture(tmp_path):
    done = run("simulate", "fwalk", "--duration", 4, "-o", "run.h5", "--plot", "walk.png", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "cadence" in done.stdout
    assert (tmp_path / "walk.png").stat().st_size > 10_000
    with h5py.File(tmp_path / "run.h5") as file:
        assert file["replay/0/com"].shape == (400, 3)
        assert file["replay/0/com"].attrs["units"] == "m"


def test_time_alone_limits_a_search_that_says_nothing_of_candidates(tmp_path):
    arguments = ("optimize", "fwalk", "--duration", 0.05, "--search", "cma", "--until", "3s", "-o", "short.h5")
    done = run(*arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "the time is up" in done.stdout
    assert " of 1000000000" not in done.stdout


def test_export_writes_a_recorded_motion_for_opensim(tmp_path):
    assert run("simulate", "walk56", "--duration", 0.5, "-o", "run.h5", folder=tmp_path).returncode == 0
    done = run("export", "run.h5", "-o", "walk.sto", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "walk.sto").read_text().splitlines()[2] == "nRows=50"
    wrong = run("export", "run.h5", "-o", "walk.mot", "--replay", 3, folder=tmp_path)
    assert (wrong.returncode, "none with number 3" in wrong.stderr) == (2, True)


@pytest.mark.usefixtures("unoptimized_test")
def test_info_and_simulate_tell_the_same_mass_of_muscles(tmp_path):
    shown = run("info", "walk44_but_hips", folder=tmp_path)
    done = run("simulate", "walk44_but_hips", "--duration", 0.1, folder=tmp_path)
    assert "44 of the 56 muscles drive joints: 22.7 kg of muscle at 0.6 MPa (54.5 kg at 0.25 MPa)" in shown.stdout
    assert "22.7 kg of muscle at 0.6 MPa (54.5 kg at 0.25 MPa)" in done.stdout
    assert "muscles drive joints" not in run("info", "walk56", folder=tmp_path).stdout


@pytest.mark.parametrize("script", ["elbow_open_loop", "weakness"])
def test_an_experiment_without_matplotlib_says_which_extra_it_needs(script, tmp_path):
    path = Path(__file__).parents[2] / "tools/research/experiments"
    code = f"import sys; sys.modules['matplotlib'] = None; sys.path.insert(0, {str(path)!r}); import {script}"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith("pip install 'warpmuscle[plot]'")
    assert "Traceback" not in done.stderr


def test_original_muscles_that_fall_on_other_laws_are_told_of_legacy(tmp_path):
    assert run("convert", "walk44_legacy", "-o", "walk.rbs", folder=tmp_path).returncode == 0
    fallen = run("simulate", "walk.rbs", "walk.sbc", "--duration", 3, folder=tmp_path)
    assert "fell" in fallen.stdout
    assert "--legacy computes them so" in fallen.stderr
    as_there = run("simulate", "walk.rbs", "walk.sbc", "--duration", 3, "--legacy", folder=tmp_path)
    assert "reached the end" not in as_there.stdout  # how it fails by then differs between processors
    assert "--legacy" not in as_there.stderr


def test_optimize_frees_numbers_by_pattern_and_leaves_what_nothing_uses(tmp_path):
    free = ("--free", "character.muscles.?SOL.l_opt = 20 %", "--free", "character.muscles.lGLU.l_opt=[0.01, 1]")
    hips = ("--set", "actuation.lHip={drive='torque'}", "--set", "actuation.rHip={drive='torque'}")
    short = ("--candidates", 2, "--duration", 0.1, "-o", "r.h5")
    done = run("optimize", "walk56", *hips, *free, *short, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "nothing uses" in done.stderr
    assert "character.muscles.lGLU" in done.stderr
    with h5py.File(tmp_path / "r.h5") as file:
        table = {key: column[()] for key, column in file["parameters"].items()}
        assert "--free" in file.attrs["command"]
    names = [name.decode() for name in table["name"]]
    assert not {name for name in names if "GLU" in name}
    at = names.index("character.muscles.lSOL.l_opt")
    value = load("walk56").character.muscles["lSOL"].l_opt
    start = getattr(value, "value", value)
    assert [table[key][at] for key in ("value", "min", "max")] == pytest.approx([start, 0.8 * start, 1.2 * start])
    wrong = run("optimize", "walk56", "--free", "character.muscles.XY*.f_max = 20 %", folder=tmp_path)
    assert wrong.returncode == 2
    assert "--free: character.muscles.XY*.f_max: no number that may be free has a path" in wrong.stderr


def test_optimize_then_apply_gives_a_scene_with_the_best_cost(tmp_path):
    arguments = ("--candidates", 6, "--duration", 0.5, "-o", "result.h5")
    done = run("optimize", "fwalk", *arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert run("apply", "result.h5", "-o", "best.toml", folder=tmp_path).returncode == 0
    again = run("simulate", "best.toml", folder=tmp_path)
    with h5py.File(tmp_path / "result.h5") as file:
        assert f"cost {file['best/cost'][()]:.6g}" in again.stdout
        assert np.argmin(file["evaluations/cost"]) == file["best/index"][()]
        assert file.attrs["command"].startswith("warpmuscle optimize fwalk")
    small = run("apply", "result.h5", "-o", "s.toml", "--on", "fwalk", "--fix", "controller.pd.*", folder=tmp_path)
    assert small.returncode == 0, small.stderr
    text, scene, best = (tmp_path / "s.toml").read_text(), load(tmp_path / "s.toml"), load(tmp_path / "best.toml")
    assert "warpmuscle optimize fwalk" in text
    assert len(text) < 0.3 * len((tmp_path / "best.toml").read_text())
    assert not [p for p in free_parameters(scene) if p.name.startswith("controller.pd.")]
    assert substitute(scene, start_values(scene)).controller == substitute(best, start_values(best)).controller


def test_convert_to_the_original_formats_and_back_keeps_the_motion(tmp_path):
    assert run("convert", "iwalk", "-o", "walk.rbs", folder=tmp_path).returncode == 0
    assert run("convert", "walk.rbs", "walk.sbc", "-o", "back.toml", folder=tmp_path).returncode == 0
    texts = [run("simulate", name, "--duration", 1, folder=tmp_path).stdout for name in ("iwalk", "back.toml")]
    assert texts[0].split("cost")[1].split()[0] == texts[1].split("cost")[1].split()[0]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = 12.9", "mass = -12.9", "character.bodies.pelvis.mass"),
        ("mass = 12.9", "mass = 'heavy'", "character.bodies.pelvis.mass"),
        ("mass = 12.9", "masss = 12.9", "mass"),
        ('child = "torso"', 'child = "trunk"', "trunk"),
        ("{ value = 300, min = 150", "{ value = 300, min = 1500", "controller.pd.root.kd"),
        ("[controller.pd]", "[controller.pd", "changed.toml"),
    ],
)
def test_bad_scene_is_one_line_with_file_line_and_key_and_leaves_no_file(old, new, words, tmp_path):
    path = changed(load("fwalk"), old, new, tmp_path)
    for command in (("simulate", path, "-o", "out.h5"), ("optimize", path, "-o", "out.h5")):
        done = run(*command, folder=tmp_path)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        assert done.stderr.startswith(f"error: {path}:"), done.stderr
        assert words in done.stderr
        assert not (tmp_path / "out.h5").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ("simulate", "nowhere.toml"),
        ("simulate", "fwalk", "--set", "objective.target_speed"),
        ("simulate", "fwalk", "--set", "objective.target_spede=1"),
        ("simulate", "fwalk", "--set", "objective.target_speed=fast"),
        ("simulate", "nobody"),
        ("simulate", "fwalk", "--device", "cuda:99"),
        ("simulate", "fwalk", "--device", "cuda:98,cuda:99"),
        ("optimize", "fwalk", "--device", "cpu,cpu"),
        ("simulate", "fwalk", "-o", "missing/out.h5"),
        ("simulate", "fwalk", "--duration", "-1"),
        ("optimize", "iwalk"),
        ("apply", "nothing.h5", "-o", "a.toml"),
        ("convert", "fwalk", "-o", "walk.docx"),
    ],
)
def test_impossible_request_is_one_line_and_exit_code_2(arguments, tmp_path):
    done = run(*arguments, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("convert", "mine.toml", "-o", "mine.toml"),
        ("convert", "mine.toml", "-o", "folder/../mine.toml"),
        ("convert", "one.rbs", "one.sbc", "-o", "one.rs"),
        ("fit-paths", "mine.toml", "-o", "mine.toml"),
        ("scale", "mine.toml", "-o", "mine.toml"),
        ("fit-muscles", "mine.toml", "-o", "mine.toml"),
    ],
)
def test_a_scene_is_not_written_over_what_it_is_read_from(arguments, tmp_path):
    (tmp_path / "folder").mkdir()
    for name in ("mine.toml", "one.rbs", "one.sbc"):
        (tmp_path / name).write_text("earlier")
    done = run(*arguments, folder=tmp_path)
    assert done.returncode == 2
    assert "is the input, which would be lost; name another output file" in done.stderr
    assert {path.read_text() for path in tmp_path.glob("*.*")} == {"earlier"}


def test_interrupt_keeps_what_was_evaluated_and_says_how_much(tmp_path):
    command = [*PROGRAM, "optimize", "fwalk", "--candidates", "100000", "-o", "part.h5"]
    with running(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: Journal.look(tmp_path / "part.h5.journal"), process)  # a generation is kept
        process.send_signal(signal.SIGINT)
        shown, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    assert "of 100000 candidates" in shown
    with h5py.File(tmp_path / "part.h5") as file:
        assert 0 < len(file["evaluations/cost"]) < 100_000


def test_info_shows_muscles_and_points_out_those_that_cannot_act(tmp_path):
    shown = run("info", "walk56", folder=tmp_path).stdout
    assert "lSOL" in shown
    assert "cannot act" not in shown
    joint = load("walk56").character.joints["lAnkle"]
    places = ((joint.parent, joint.position_in_parent), (joint.child, joint.position_in_child))
    ends = [f"{{ body = '{body}', position = {list(position)} }}" for body, position in places]
    (tmp_path / "wrong.toml").write_text(f"[muscles.lTA]\npath = [{', '.join(ends)}]\n")
    files = ["biped", "muscles56", "muscles56_fitted", "wrong.toml"]
    (tmp_path / "scene.toml").write_text(f'name = "wrong"\nbase = "fwalk"\ncharacter = {files}\n')
    shown = run("info", "scene.toml", folder=tmp_path)
    assert "lTA cannot act on lAnkle" in shown.stdout, shown.stderr
    assert "leaves no fibre" in shown.stderr


@pytest.mark.usefixtures("unoptimized_test")
def test_paths_that_no_polynomial_follows_as_closely_as_asked_are_named(tmp_path):
    run("example", "model", folder=tmp_path)
    shown = run("fit-paths", "arm.osim", "--order", 4, "-o", "smooth.toml", folder=tmp_path).stdout
    told = [line for line in shown.splitlines() if line.startswith("triceps: misses ")]
    assert "even at order 4, where --rms allows 0.1 mm, and" in told[0]


@pytest.mark.usefixtures("unoptimized_test")
def test_info_cuts_no_name_off_in_a_narrow_console(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    shown = run("info", "gait2392", folder=tmp_path).stdout
    assert "…" not in shown
    lines = [line.split() for line in shown.splitlines()]
    assert ["calcn_r", "1.25", "subtalar_angle_r", "hinge", "talus_r"] in lines
    assert ["knee_angle_r", "ankle_angle_r", "subtalar_angle_r"] in [
        line[6:] for line in lines if line[:1] == ["med_gas_r"]
    ]


@pytest.mark.long
def test_muscle_mass_is_shown_and_too_much_of_it_warned_of(tmp_path):
    heavy = ("--set", "muscle_model.specific_tension=0.25e6")
    shown = run("info", "walk56", folder=tmp_path)
    assert "25.1 kg of muscle at 0.6 MPa (60.3 kg at 0.25 MPa), 35.7 % of the body\n" in shown.stdout
    assert "warning" not in shown.stderr
    done = run("simulate", "walk56", "--duration", 3, *heavy, folder=tmp_path)
    assert (done.returncode, done.stderr.count("60.3 kg of muscle are 85.6 % of a body")) == (0, 1)
    assert "1.51 W/kg at rest, 60.3 kg of muscle at 0.25 MPa\n" in done.stdout
    begun = run("optimize", "walk56", "--candidates", 2, "--duration", 0.5, *heavy, "-o", "a.h5", folder=tmp_path)
    resumed = run("optimize", "--resume", "a.h5", "--candidates", 1, folder=tmp_path)
    for done in (begun, resumed):
        assert (done.returncode, done.stderr.count(" kg of muscle are ")) == (0, 1), done.stderr
    assert run("report", "a.h5", folder=tmp_path).stdout.count(" kg of muscle are ") == 1


def test_fit_muscles_writes_properties_that_a_scene_can_add(tmp_path):
    done = run(
        "fit-muscles", "elbow_simplified", "--properties-only", "--strength", 2, "--duration", 2, "-o", "fitted.toml",
        folder=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    files = ["biped", "elbow_pair.toml", "fitted.toml"]
    (tmp_path / "scene.toml").write_text(f'name = "mine"\nbase = "fwalk.toml"\ncharacter = {files}\n')
    assert load(tmp_path / "scene.toml").character.muscles["lBIC"].f_max == 8000
    done = run("simulate", "scene.toml", "--duration", 1, "-o", "run.h5", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "run.h5") as file:
        assert list(file["replay/0/muscle_names"].asstr()) == ["lBIC", "lTRI", "rBIC", "rTRI"]
        assert file["replay/0/muscle_force"].shape == (100, 4)
        assert file["replay/0/muscle_force"].attrs["units"] == "N"


@pytest.mark.usefixtures("unoptimized_test")
def test_code_that_a_scene_names_runs_only_if_trusted(tmp_path):
    (tmp_path / "tricks.py").write_text(
        "from pathlib import Path\nimport warp as wp\nfrom warpmuscle.kernels.structs import Model, State, Scratch\n"
        "Path('ran').touch()\n@wp.func\n"
        "def height(instance: int, model: Model, state: State, work: Scratch) -> float:\n"
        "    return work.center[0][1]\n"
    )
    text = toml.dumps(load("fwalk")).replace("[objective]\n", '[objective]\ncustom = { "tricks:height" = 1.0 }\n')
    (tmp_path / "mine.toml").write_text(text)
    arguments = ("simulate", "mine.toml", "--duration", 0.01, "--device", "cpu")
    refused = run(*arguments, folder=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr.count("\n") == 1
    assert "wants to run code of 'tricks:height'" in refused.stderr
    assert "--trust" in refused.stderr
    assert not (tmp_path / "ran").exists()
    done = run(*arguments, "--trust", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "ran").exists()


def test_values_that_are_nested_too_deeply_are_said_in_one_line(tmp_path):
    done = run("info", "fwalk", "--set", "duration=" + "[" * 5000, folder=tmp_path)
    assert done.returncode != 0
    assert "nested too deeply" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.usefixtures("unoptimized_test")
def test_bodies_that_ran_into_each_other_are_named(tmp_path):
    done = run("simulate", "fwalk", "--set", "failure.self_collision=0.005", "--duration", 1, folder=tmp_path)
    assert "by more than their limit (lLowerleg and rLowerleg)" in done.stdout


def test_commands_of_a_scene_are_told_with_their_units():
    scene = load("walk56_kettlebell")
    assert commanded_in_words(scene, ["load=4", " drop = 3"]) == ["load 4 kg", "drop 3 s"]
