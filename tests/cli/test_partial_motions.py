"""Commands on files that keep only some quantities of their motions, and options that write such files."""

import re
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import warpmuscle as wm
from small_result import walk_result
from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error
from warpmuscle.results.recorded_quantities import QUANTITIES

RUNNER = CliRunner()


@pytest.fixture(scope="module")
def partial(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A walk, and the same once more, of which only the centre of mass is kept."""
    path = tmp_path_factory.mktemp("partial") / "walk.h5"
    whole = walk_result()
    wm.write(path, replace(whole, replays=(*whole.replays[:1], *whole.replays[:1])), quantities=["com"])
    return path


@pytest.mark.parametrize(
    ("words", "quantity"),
    [
        ("gait FILE", "foot_force_left"),
        ("plot FILE --what sticks -o a.png", ""),
        ("plot FILE --what angles -o a.png", ""),
        ("video FILE -o a.gif --size 128x96", ""),
        ("export FILE -o a.mot", ""),
        ("export FILE -o a.sto --replay 1", "muscle_"),
        ("view FILE --export a.html", ""),
        ("simulate walk56 --duration 0.05 --set tracking.file=FILE --set objective.tracking=1", ""),
    ],
)
def test_commands_say_in_one_line_which_quantity_they_lack(words: str, quantity: str, partial: Path, tmp_path: Path,
                                                           monkeypatch):  # fmt: skip
    monkeypatch.chdir(tmp_path)
    result = RUNNER.invoke(app, [word.replace("FILE", str(partial)) for word in words.split()])
    assert result.exit_code != 0
    assert isinstance(result.exception, Error), result.output
    assert str(partial) in str(result.exception)
    assert re.search(rf"motion .*has no {quantity}", str(result.exception))
    assert "\n" not in str(result.exception)
    assert not list(tmp_path.iterdir())


def test_what_is_kept_is_drawn(partial: Path, tmp_path: Path):
    for name in ("/replay/1/com", "/replay/com"):
        path = tmp_path / "a.png"
        result = RUNNER.invoke(app, ["plot", str(partial), "--what", f"dataset:{name}", "-o", str(path)])
        assert (result.exit_code == 0) == (name == "/replay/1/com"), result.output
    assert path.stat().st_size > 1000


def test_muscles_alone_are_exported(tmp_path: Path):
    wm.write(tmp_path / "a.h5", walk_result(), quantities=["muscle_activation", "muscle_force"])
    result = RUNNER.invoke(app, ["export", str(tmp_path / "a.h5"), "-o", str(tmp_path / "a.sto")])
    assert result.exit_code == 0, result.output
    assert "lSOL.force" in (tmp_path / "a.sto").read_text()


@pytest.mark.parametrize("ending", ["mot", "sto", "csv", "nc"])
def test_a_motion_without_frames_is_not_exported(ending: str, tmp_path: Path):
    found = walk_result()
    ended = tuple(one.changed(**{name: one[name][:0] for name in QUANTITIES}) for one in found.replays)
    wm.write(tmp_path / "a.h5", replace(found, replays=ended))
    result = RUNNER.invoke(app, ["export", str(tmp_path / "a.h5"), "-o", str(tmp_path / f"a.{ending}")])
    assert "a.h5: its motion 0 has no frames" in str(result.exception)
    assert [file.name for file in tmp_path.iterdir()] == ["a.h5"]


def test_simulate_keeps_what_it_is_told(tmp_path: Path):
    path = tmp_path / "a.h5"
    options = ["--duration", "0.02", "--device", "cpu", "-o", str(path)]
    result = RUNNER.invoke(app, ["simulate", "fwalk", *options, "--quantities", "com, joint_angle", "--single"])
    assert result.exit_code == 0, result.output
    with h5py.File(path) as file:
        assert file["replay/0/com"].dtype == np.float32
        assert file["replay/0/time"].dtype == np.float64
        assert file["replay/0"].attrs["quantities"] == "time, com, joint_angle"
        assert "phase" not in file["replay/0"]
    result = RUNNER.invoke(app, ["simulate", "fwalk", *options, "--quantities", "con"])
    assert isinstance(result.exception, Error)
    assert "--quantities: no quantity is called 'con'; did you mean 'com'" in str(result.exception)


def test_measuring_a_partial_recording_says_which_quantity_it_lacks(partial: Path):
    motion = wm.read(partial).replays[0]
    assert motion.com_velocity.shape == (0, 3)
    with pytest.raises(Error, match="this recording: the motion has no"):
        wm.measure(motion, "lFoot", "rFoot")
