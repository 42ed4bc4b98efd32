"""Files of one kind into another in a line of Python."""

from pathlib import Path

import pytest

import warpmuscle as wm


def test_a_scene_becomes_the_file_that_the_ending_names(tmp_path: Path):
    scene = wm.convert("fwalk", tmp_path / "mine.toml")
    assert wm.load(tmp_path / "mine.toml") == scene
    wm.convert(tmp_path / "mine.toml", tmp_path / "mine.xml")
    assert "<mujoco" in (tmp_path / "mine.xml").read_text()


def test_what_the_target_cannot_hold_is_warned_of(tmp_path: Path):
    with pytest.warns(UserWarning, match="not all was written"):
        wm.convert("walk56", tmp_path / "mine.rbs")


def test_a_file_is_not_written_over_itself(tmp_path: Path):
    wm.convert("fwalk", tmp_path / "mine.toml")
    with pytest.raises(wm.Error, match="would be lost"):
        wm.convert(tmp_path / "mine.toml", tmp_path / "mine.toml")
