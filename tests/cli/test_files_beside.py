"""Outputs beside which commands write more files: none replaces another, and folders are refused in a line."""

import json
from pathlib import Path

import pytest

import warpmuscle as wm
from command_line import run
from warpmuscle.core.errors import Error

STUDY = 'scene = "fwalk"\n[grid]\nseed = [1]\n"objective.torque" = [1, 2]\n[study]\ncondition = "torque"\n'
CONDITION = {"study": "a", "identifier": "level", "speed_m_s": 1.3, "subject_mass_kg": 70.0, "leg_length_m": 0.9}
COMMANDS = {
    "study": ("study", "study.toml", "--device", "cpu"),
    "slurm": ("sweep", "study.toml", "--slurm", 2),
    "adaptation": ("adaptation", "data.json", "--device", "cpu"),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("output", [".", "/", "..", ""])
def test_a_folder_as_output_is_refused_in_a_line(command: str, output: str, tmp_path: Path):
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "data.json").write_text(json.dumps([CONDITION]))
    done = run(*COMMANDS[command], "-o", output, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].endswith("cannot be written: this is a folder")
    assert {path.name for path in tmp_path.iterdir()} == {"study.toml", "data.json"}


@pytest.mark.parametrize(
    ("command", "output"),
    [("study", "a.html"), ("study", "a.CSV"), ("slurm", "a.slurm"), ("adaptation", "a.toml"), ("adaptation", "a.csv")],
)
def test_an_output_that_would_be_replaced_by_what_lies_beside_it_is_refused(command: str, output: str, tmp_path: Path):
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "data.json").write_text(json.dumps([CONDITION]))
    done = run(*COMMANDS[command], "-o", output, folder=tmp_path)
    assert done.returncode == 2
    assert f"{output}: another file of this name is written beside it; name an output that ends in .h5" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"study.toml", "data.json"}


def test_a_sweep_from_python_with_a_folder_as_output_says_what_it_is_written_as(tmp_path: Path):
    with pytest.raises(Error, match=r"a sweep is written as \.h5, \.hdf5"):
        wm.sweep("fwalk", tmp_path.parent / "..", grid={"seed": [1]})
