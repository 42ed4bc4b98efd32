"""A file of `warpmuscle inverse` is read like that of a simulation."""

import numpy as np
import pytest

import command_line
import small_leg
import warpmuscle as wm
from warpmuscle.formats.sto import storage_text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("trials")
    small_leg.small_leg(found)
    for name, seed in (("walk", 0), ("run", 1)):
        at = small_leg.motion(30, seed=seed)
        table = np.column_stack([at.times, at.values])
        (found / f"{name}.sto").write_text(storage_text(name, ["time", *at.names], table))
    done = command_line.run(
        "inverse", "small.osim", "walk.sto", "run.sto", "--reserve", "50", "-o", "out.h5", "--steps", "id,so",
        "--device", "cpu", folder=found,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return found


def test_trials_are_motions_with_their_names_and_muscles(folder):
    result = wm.read(folder / "out.h5")
    assert result.replay_names == ("walk", "run")
    first = result.replays[0]
    assert first.frames == 30
    assert first.muscle_activation.shape == (30, 10)
    assert "muscle_path_length" in first.missing


def test_a_page_shows_one_and_coordinates_are_exported(folder):
    for words in (("view", "out.h5", "--export", "out.html"), ("export", "out.h5", "-o", "back.mot")):
        done = command_line.run(*words, folder=folder)
        assert done.returncode == 0, done.stderr
    assert (folder / "out.html").stat().st_size > 50_000
    text = (folder / "back.mot").read_text()
    names, *rows = text.split("endheader\n")[1].splitlines()
    knee = names.split("\t").index("knee_angle")
    found = [np.radians(float(row.split("\t")[knee])) for row in rows]
    assert found == pytest.approx(small_leg.motion(30).of("knee_angle"), abs=1e-6)


def test_what_needs_feet_says_so_in_a_line(folder):
    done = command_line.run("gait", "out.h5", folder=folder)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert len(done.stderr.splitlines()) == 1
