"""The command as a user meets it."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
from synthetic_emg import raw_emg, write_csv

import command_line
from patience import PATIENCE


def run(*arguments, folder):
    """Run `warpmuscle synergies extract` with these arguments in a folder."""
    return command_line.run("synergies", "extract", *arguments, folder=folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("synergies")
    write_csv(folder / "a.csv", raw_emg(4.0, seed=0))
    write_csv(folder / "b.csv", raw_emg(4.0, seed=1))
    (folder / "cycles.csv").write_text("start\n0.2\n1.7\n3.2\n")
    return folder


def test_number_is_found_and_file_and_figure_are_written(folder):
    done = run("a.csv", "b.csv", "-o", "syn.h5", "--plot", "syn.png", "--restarts", 3, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "7 channels, 800 samples of 2 recordings" in done.stdout
    assert "3 synergies account for 0.9" in done.stdout
    with h5py.File(folder / "syn.h5") as file:
        assert file["W"].shape == (7, 3)
        assert file.attrs["command"].startswith("warpmuscle ")
        assert np.ptp(file["trial"][()]) == 1
        assert file["timing/centre"].attrs["units"] == "s"
        assert np.all(file["timing/width"][()] > 0.0)
    assert (folder / "syn.png").stat().st_size > 20_000


def test_options_reach_the_chain_and_synergies_follow_another_file(folder):
    assert run("a.csv", "-n", 3, "-o", "first.h5", "--restarts", 2, folder=folder).returncode == 0
    done = run(
        "b.csv", "-n", 3, "-o", "second.h5", "--like", "first.h5", "--band", 20, 400, "--low-pass", 8, "--cycles",
        "cycles.csv", "--points", 50, "--subtract-minimum", "--ecg", "auto", "--restarts", 2, folder=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "no component holds the heart's signal" in done.stderr
    assert "cosine" in done.stdout
    with h5py.File(folder / "second.h5") as file:
        assert file.attrs["band"].tolist() == [20.0, 400.0]
        assert (file.attrs["low_pass"], file.attrs["points"]) == (8.0, 50)
        assert file["C"].shape == (3, 100)
        assert file["similarity"][()].min() > 0.95


@pytest.mark.long
def test_modules_of_several_files_are_sorted_by_likeness(folder):
    for name, seed in (("a", 0), ("b", 1)):
        assert run(f"{name}.csv", "-n", 3, "-o", f"p{seed}.h5", "--restarts", 2, folder=folder).returncode == 0
    command = ["synergies", "cluster", "p0.h5", "p1.h5"]
    done = command_line.run(*command, "-o", "modules.csv", "--plot", "modules.png", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "6 modules of 2 people in 3 clusters" in done.stdout
    lines = (folder / "modules.csv").read_text().splitlines()
    assert lines[0] == "file,synergy,cluster,cosine,DA,DP,BIC,TRI,FCR,ECU,PEC"
    assert sorted(line.split(",")[2] for line in lines[1:]) == list("112233")
    assert (folder / "modules.png").stat().st_size > 10_000
    wrong = command_line.run(*command, "a.csv", folder=folder)
    assert wrong.returncode == 2
    assert len(wrong.stderr.strip().splitlines()) == 1


def test_same_seed_gives_the_same_file_also_in_a_process_of_its_own(folder):
    words = ["a.csv", "-n", "2", "--restarts", "2", "-o"]
    assert run(*words, "one.h5", folder=folder).returncode == 0
    command = [sys.executable, "-m", "warpmuscle", "synergies", "extract", *words, "two.h5"]
    assert subprocess.run(command, cwd=folder, capture_output=True, timeout=PATIENCE).returncode == 0
    with h5py.File(folder / "one.h5") as one, h5py.File(folder / "two.h5") as two:
        assert np.array_equal(one["C"][()], two["C"][()])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("a.csv", "-n", 9), "9 synergies are more than the 7 channels with 400 samples allow"),
        (("a.csv", "-n", "few"), "a number of synergies is at least 1, or auto, knee or cross, not 'few'"),
        (("a.csv", "--already-filtered"), "a.csv:2: channel 'FCR': is -0.003839, but an envelope is never negative"),
        (("a.csv", "--band", 10, 700), "a band up to 700 Hz needs a sampling rate above 1400 1/s"),
        (("none.csv",), "none.csv: there is no such file"),
        (("a.csv", "--channels", "BIC,XYZ"), "a.csv: no channel is called 'XYZ'"),
        (("a.csv", "-o", "nowhere/syn.h5"), "its folder does not exist"),
        (("a.csv", "--like", "a.csv", "-n", 2), "a.csv: not an HDF5 file, or damaged"),
        (("a.csv", "--vaf", 2), "a VAF to reach must be from 0 to 1, not 2"),
    ],
)
def test_errors_are_one_line_and_nothing_is_written(folder, arguments, says):
    before = sorted(folder.iterdir())
    done = run(*arguments, folder=folder)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert sorted(folder.iterdir()) == before
