"""What `view` finds in files and scenes, and what it says about those it cannot show."""

import dataclasses
import shutil
import sys
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

import warpmuscle as wm
from warpmuscle.cli.program import main
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.formats import load, toml
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results.records import Result
from warpmuscle.results.result import read, write
from warpmuscle.view.page import replay_html
from warpmuscle.view.sources import is_result, of_replays, of_results, page_of_sights, tracks_of


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """A short search of walks."""
    path = tmp_path_factory.mktemp("view") / "walks.h5"
    optimize(msgspec.structs.replace(load("fwalk"), duration=0.3), 4, device="cpu", output=path)
    return path


def test_motion_of_a_result_is_shown_with_its_best_parameters(file):
    (sight,) = of_results([str(file)])
    assert (sight.label, sight.recording.frames) == ("fwalk", 30)
    result = read(file)
    number = result.parameters.name.index("controller.pd.lKnee.kp")
    assert sight.scene.controller.pd["rKnee"].kp == result.best.params[number]
    assert [sight.label for sight in of_results([str(file), str(file)])] == ["walks", "walks"]


def test_a_motion_without_frames_is_nothing_to_show(file):
    result = read(file)
    none = result.replays[0].window(100.0)
    assert none.frames == 0
    ended = dataclasses.replace(result, replays=(none,), evaluations=None)
    with pytest.raises(Error, match="nothing to show: the motion has no frames"):
        tracks_of(of_replays(ended))
    (walk,), (nothing,) = of_replays(result), of_replays(ended)
    assert page_of_sights([walk, nothing]).text == page_of_sights([walk]).text
    with pytest.raises(Error, match="nothing to show: the motion has no frames"):
        page_of_sights([nothing])


def test_best_candidates_are_run_again_best_first(file):
    sights = of_results([str(file)], candidates=3, device="cpu")
    evaluations = read(file).evaluations
    expected = [f"candidate {k}" for k in np.argsort(evaluations.cost)[:3]]
    assert [sight.label.split(",")[0] for sight in sights] == expected
    best = of_results([str(file)])[0].recording
    np.testing.assert_allclose(sights[0].recording.com, best.com[::2], atol=1e-6)  # recorded half as often


def test_result_and_recording_are_pages_for_a_notebook(file):
    result = read(file)
    page = wm.show(result)
    assert "srcdoc" in page._repr_html_()
    scene = toml.loads(result.scene)
    assert wm.show(result.replays[0], scene).text == replay_html(result.replays[0], scene)
    with pytest.raises(ResultError, match="has 1 motion, none with number 7"):
        wm.show(result, replay=7)


def bad_files(file: Path, folder: Path) -> dict[str, str]:
    """Files that cannot be shown, and what is said of each."""
    (folder / "text.h5").write_text("no\n")
    (folder / "cut.h5").write_bytes(file.read_bytes()[:5000])
    with h5py.File(folder / "other.h5", "w") as other:
        other["x"] = 1
    for name in ("newer.h5", "empty.h5", "torn.h5"):
        shutil.copy(file, folder / name)
    with h5py.File(folder / "newer.h5", "r+") as newer:
        newer.attrs["format_version"] = 99
    with h5py.File(folder / "empty.h5", "r+") as empty:
        del empty["replay"]
    with h5py.File(folder / "torn.h5", "r+") as torn:
        del torn["replay/0/com"]
    return {
        "text.h5": "not an HDF5 file, or damaged",
        "cut.h5": "not an HDF5 file, or damaged",
        "other.h5": "not one written by warpmuscle",
        "newer.h5": "format version 99 is newer than 3",
        "empty.h5": "holds no motion to show; --candidates N runs the N best again",
        "torn.h5": "damaged result file",
        "none.h5": "no such file",
    }


def test_bad_files_are_one_clear_line(file, tmp_path):
    for name, words in bad_files(file, tmp_path).items():
        with pytest.raises(ResultError) as caught:
            of_results([str(tmp_path / name)])
        assert words in str(caught.value)
        assert name in str(caught.value)
        assert "\n" not in str(caught.value)
    bare = dataclasses.replace(read(file), replays=(), evaluations=None, best=None, searched=None)
    write(tmp_path / "bare.h5", bare)
    with pytest.raises(ResultError, match=r"holds no motion to show$"):
        of_results([str(tmp_path / "bare.h5")])
    with pytest.raises(ResultError, match="holds no candidates"):
        of_results([str(tmp_path / "bare.h5")], candidates=2)
    many = Result(bare.scene, "cpu", "", 0, bare.parameters, replays=read(file).replays * 65)
    with pytest.raises(Error, match="none with number 65"):
        of_replays(many, replay=65)


def test_more_than_can_be_seen_at_once_is_refused(file):
    with pytest.raises(Error, match="65 motions are more than can be seen at once: 64"):
        tracks_of(of_results([str(file)]) * 65)


def test_result_files_are_told_from_scenes_by_name_or_content(file, tmp_path):
    shutil.copy(file, tmp_path / "walks.dat")
    assert is_result(str(tmp_path / "walks.dat"))
    assert is_result("missing.hdf5")
    assert not is_result("fwalk")
    assert not is_result(str(Path(__file__)))


def test_command_writes_a_page_and_refuses_what_does_not_go_together(file, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["warpmuscle", "view", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        output = capsys.readouterr()
        return int(ended.value.code or 0), output.out.strip(), " ".join(output.err.split())

    assert run(file, "--export", "walk.html")[:2] == (0, "wrote walk.html")
    assert "<!DOCTYPE html>" in (tmp_path / "walk.html").read_text()
    for arguments, words in (
        ((file, "--live"), "--live takes a scene"),
        ((file, "fwalk"), "either result files or one scene"),
        (("fwalk", "--replay", 1), "a scene takes no --replay"),
        ((file, "--export", "nowhere/walk.html"), "its folder does not exist"),
    ):
        code, _, complaint = run(*arguments)
        assert code == 2
        assert words in complaint
