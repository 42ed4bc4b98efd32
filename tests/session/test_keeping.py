"""The ending of a name says what is written of a run, and others are refused before anything is."""

import re
from pathlib import Path

import pytest

import warpmuscle as wm
from warpmuscle.core.errors import ArgumentError
from warpmuscle.plots.names import curves_named, kind_named


@pytest.fixture(scope="module")
def walk() -> wm.Run:
    return wm.simulate("fwalk", duration=0.5, device="cpu")


def test_a_name_says_what_is_written(walk: wm.Run, tmp_path: Path):
    begins = {"a.h5": b"\x89HDF", "a.html": b"<!DOCTYPE html>", "a.mot": b"fwalk\n", "a.csv": b"time,"}
    for name, first in begins.items():
        walk.save(tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(first), name
    wm.read(tmp_path / "a.h5").save(tmp_path / "b.csv")
    assert (tmp_path / "b.csv").read_bytes() == (tmp_path / "a.csv").read_bytes()


def test_a_run_becomes_a_film(walk: wm.Run, tmp_path: Path):
    pytest.importorskip("PIL")
    wm.simulate("fwalk", duration=0.05, device="cpu").save(tmp_path / "a.gif")
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF8")


@pytest.mark.parametrize(("name", "why"), [("a.png", "plot(kind, "), ("a.txt", "not '.txt'"), ("a", "not ''")])
def test_other_names_are_refused(walk: wm.Run, tmp_path: Path, name: str, why: str):
    with pytest.raises(ArgumentError, match=re.escape(why)) as caught:
        walk.save(tmp_path / name)
    assert str(caught.value).startswith("path must end in .h5, .html, .mot, .sto, .csv, .mp4, .gif, .webp, not ")
    assert not list(tmp_path.iterdir())


def test_names_that_are_elsewhere_are_told(walk: wm.Run):
    for name, why in (("frames", "run.recording.frames"), ("character", "run.scene.character"), ("shwo", "'show'")):
        with pytest.raises(AttributeError, match=re.escape(why)):
            getattr(walk, name)
    for name, why in (("run", "wm.simulate"), ("simulat", "'simulate'"), ("judge", "warpmuscle judge")):
        with pytest.raises(AttributeError, match=re.escape(why)):
            getattr(wm, name)
    assert not hasattr(wm, "__nothing__")


def test_several_motions_are_shown_in_one_page(walk: wm.Run, tmp_path: Path):
    shorter = wm.simulate("fwalk", duration=0.4, device="cpu")  # frames that are equal are kept once
    shorter.save(tmp_path / "a.h5")
    alone = len(wm.show(walk).text)
    assert len(wm.show([walk, tmp_path / "a.h5"]).text) > 1.02 * alone
    assert len(wm.show([walk, shorter], over=True).text) > 1.02 * alone
    with pytest.raises(ArgumentError, match="not an empty one"):
        wm.show([])


def test_figures_and_curves_are_found_however_they_are_written():
    kinds = ("ground_force", "activation", "joints")
    words = {"ground forces": "ground_force", "GRF": "ground_force", "activations": "activation", "joint": "joints",
             "Ground-Force": "ground_force", "knee": "knee"}  # fmt: skip
    assert {word: kind_named(word, kinds) for word in words} == words
    curves = ("Hip flexion", "Hip moment", "Knee flexion", "rSOL")
    assert curves_named("hip_flexion", curves) == ["Hip flexion"]
    assert curves_named("knee", curves) == ["Knee flexion"]
    assert curves_named("hip", curves) == ["Hip flexion"]
    assert curves_named("moment", (*curves, "Knee moment")) == ["Hip moment", "Knee moment"]
    assert curves_named("rsol", curves) == ["rSOL"]
    assert curves_named("elbow", curves) == curves_named("", curves) == []
