"""The command from recordings to muscles, as a user meets it."""

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

import command_line
import warpmuscle as wm
from opensim_table import table
from small_leg import loads, motion, small_leg
from warpmuscle.formats.sto import storage_text
from warpmuscle.inverse.static_optimization import static_optimization


def run(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    return command_line.run("inverse", *arguments, "--device", "cpu", folder=folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a model, two motions, their loads and EMG."""
    found = tmp_path_factory.mktemp("recordings")
    small_leg(found)
    for name, seed in (("walk", 0), ("run", 1)):
        at = motion(30, seed=seed)
        (found / f"{name}.sto").write_text(
            storage_text(name, ["time", *at.names], np.column_stack([at.times, at.values]))
        )
        own = loads(at.times)
        names = [f"foot_{part}{axis}" for part in ("force_v", "force_p", "torque_") for axis in "xyz"]
        plate = own.plates[0]
        table_of = np.column_stack([own.times, plate.force, plate.point, plate.moment])
        (found / f"{name}_grf.mot").write_text(storage_text("grf", ["time", *names], table_of))
        identifiers = {
            "applied_to_body": "calcn_r", "force_identifier": "foot_force_v", "point_identifier": "foot_force_p",
            "torque_identifier": "foot_torque_",
        }  # fmt: skip
        inner = "".join(f"<{tag}>{word}</{tag}>" for tag, word in identifiers.items())
        (found / f"{name}_loads.xml").write_text(
            f'<OpenSimDocument Version="40000"><ExternalLoads name="x"><objects><ExternalForce name="foot">{inner}'
            f"</ExternalForce></objects><datafile>{name}_grf.mot</datafile></ExternalLoads></OpenSimDocument>"
        )
    return found


def test_two_trials_become_one_file_and_opensims(folder, tmp_path):
    done = run(
        folder, "small.osim", "walk.sto", "run.sto", "--loads", "walk_loads.xml", "--loads", "run_loads.xml",
        "--reserve", "5", "--reserve", "knee_angle=10", "-o", tmp_path / "out.h5", "--sto", tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "walk: 30 frames, residuals up to" in done.stdout
    with h5py.File(tmp_path / "out.h5") as file:
        assert list(file["trials"]) == ["walk", "run"]
        said = file.attrs["pennation"]
        group = file["trials/run"]
        assert group["activation"].shape == (30, 10)
        assert group["activation"].attrs["units"] == "1"
        assert group["muscle"].asstr()[0] == "iliacus"
        scales = [dimension[0].name.rpartition("/")[2] for dimension in group["reaction_force"].dims]
        assert scales == ["time", "joint", "axis"]
        activation = group["activation"][()]
    assert said.startswith("the pennation of ")
    assert said in " ".join(done.stdout.split())
    at = motion(30, seed=1)
    wanted = static_optimization(
        folder / "small.osim", at, loads(at.times), reserve={"": 5.0, "knee_angle": 10.0}, device="cpu"
    )
    assert activation == pytest.approx(wanted.activation, abs=1e-3)  # files have nine digits
    _, names, rows = table(tmp_path / "run_StaticOptimization_force.sto")
    assert rows[:, names.index("gastrocnemius")] == pytest.approx(wanted.force[:, 8], abs=1.0)
    assert {path.name for path in tmp_path.glob("walk_*")} == {
        "walk_InverseDynamics.sto", "walk_StaticOptimization_activation.sto", "walk_StaticOptimization_force.sto",
        "walk_JointReaction_ReactionLoads.sto",
    }  # fmt: skip
    assert "knee_angle_moment" in table(tmp_path / "walk_InverseDynamics.sto")[1]


def test_the_file_is_read_by_xarray(folder, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    done = run(folder, "small.osim", "walk.sto", "--every", "10", "--reserve", "5", "-o", tmp_path / "out.h5")
    assert done.returncode == 0, done.stderr
    with xarray.open_dataset(tmp_path / "out.h5", group="trials/walk", engine="h5netcdf") as found:
        assert found.activation.sel(muscle="rectus").shape == (3,)
        assert found.moment.sel(coordinate="knee_angle").dims == ("time",)


def test_steps_that_are_not_asked_for_are_not_there(folder, tmp_path):
    done = run(folder, "small.osim", "walk.sto", "--steps", "id", "-o", tmp_path / "out.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "out.h5") as file:
        assert "moment" in file["trials/walk"]
        assert "activation" not in file["trials/walk"]


@pytest.mark.usefixtures("unoptimized_test")
def test_a_motion_is_followed_and_a_page_is_written(folder, tmp_path):
    pytest.importorskip("matplotlib")
    done = run(
        folder, "small.osim", "walk.sto", "--loads", "walk_loads.xml", "--steps", "id,track", "--reserve", "5",
        "--end", "0.15", "-o", tmp_path / "out.h5", "--sto", tmp_path / "tables", "--report", tmp_path / "page.html",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "walk: followed over 10 windows to" in done.stdout
    assert "forces at the root: up to" in done.stdout
    with h5py.File(tmp_path / "out.h5") as file:
        group = file["trials/walk"]
        assert group["excitation"].shape == (10, 10)
        assert group["tracked_value"].shape == (11, 11)
        assert [dimension[0].name.rpartition("/")[2] for dimension in group["excitation"].dims] == [
            "window_time", "muscle",
        ]  # fmt: skip
    kept = wm.read(tmp_path / "out.h5")
    assert kept.replay_names == ("walk", "walk followed")
    assert kept.replays[1].time[[0, -1]] == pytest.approx([0.0, 0.14], abs=0.011)
    assert kept.replays[1].muscle_force.max() > 10.0
    _, names, rows = table(tmp_path / "tables" / "walk_CMC_Actuation_force.sto")
    assert {"gastrocnemius", "pelvis_ty_residual", "knee_angle_reserve"} <= set(names)
    assert len(rows) == 10
    assert "Hicks et al. 2015" in (tmp_path / "page.html").read_text()


def test_reserves_that_are_too_great_are_told(folder):
    done = run(folder, "small.osim", "walk.sto", "--loads", "walk_loads.xml")
    assert done.returncode == 0, done.stderr
    assert "exceed 5 % of the peak moment" in done.stdout
    assert "did not converge" not in done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("nothing.osim", "walk.sto"), "nothing.osim"),
        (("small.osim", "nothing.sto"), "nothing.sto"),
        (("small.osim", "walk.sto", "--steps", "id,cmc"), "steps are ik, id, so, jr"),
        (("small.osim", "walk.sto", "--loads", "walk.sto"), "no columns of a force"),
        (("small.osim", "walk.sto", "--loads", "a", "--loads", "b"), "--loads is given 2 times"),
        (("small.osim", "walk.sto", "--reserve", "much"), "is not a number"),
        (("small.osim", "walk.sto", "--begin", "7"), "no frame lies between"),
        (("small.osim", "walk.sto", "--filter", "70"), "cut-off"),
        (("small.osim", "walk.sto", "--sto", "nowhere/below"), "nowhere is not a folder; make that first"),
        (("small.osim", "walk.sto", "--sto", "walk.sto"), "--sto: walk.sto is not a folder"),
        (("small.osim", "walk.sto", "--report", "page.txt"), "a report is written as .html"),
        (("small.osim", "walk.sto", "--steps", "track", "--window", "2"), "window is a number from"),
        (("small.osim", "walk.sto", "--steps", "track", "--ground"), "a model on the ground needs two feet"),
        (("small.osim", "walk.sto", "--weight", "mass"), "--weight is none or volume"),
        (("small.osim", "walk.sto", "--emg", "walk.sto"), "name of a muscle"),
        (("small.osim", "walk.sto", "walk.sto", "-o", "two.h5"), "two trials are called 'walk'"),
    ],
)
def test_what_cannot_be_done_is_one_line(folder, words, said):
    done = run(folder, *words)
    assert done.returncode == 2, done.stdout
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (folder / "two.h5").exists()


def test_ground_forces_of_a_motion_ask_for_two_feet_and_no_plates(folder, tmp_path):
    for more, told in (([], "need two feet"), (["--loads", "walk_loads.xml"], "leave one of them out")):
        done = run(folder, "small.osim", "walk.sto", "--no-plates", *more, "-o", tmp_path / "out.h5")
        assert done.returncode == 2
        assert told in done.stderr
        assert not list(tmp_path.iterdir())
