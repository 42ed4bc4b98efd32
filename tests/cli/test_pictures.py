"""The commands that show results, as a user meets them: files appear, and what is wrong with a file is one line."""

from pathlib import Path

import h5py
import pytest

from small_result import search_result, walk_result
from warpmuscle.cli import program
from warpmuscle.plots import KINDS
from warpmuscle.results.result import write


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a search, and with files that are none."""
    folder = tmp_path_factory.mktemp("results")
    write(folder / "best.h5", search_result())
    write(folder / "walk.h5", walk_result())
    (folder / "text.h5").write_text("no HDF5")
    (folder / "torn.h5").write_bytes((folder / "best.h5").read_bytes()[:20000])
    with h5py.File(folder / "other.h5", "w") as file:
        file["x"] = 1.0
    (folder / "newer.h5").write_bytes((folder / "best.h5").read_bytes())
    with h5py.File(folder / "newer.h5", "a") as file:
        file.attrs["format_version"] = 99
    (folder / "still.h5").write_bytes((folder / "best.h5").read_bytes())
    with h5py.File(folder / "still.h5", "a") as file:
        del file["replay"]
    return folder


@pytest.fixture
def run(folder, monkeypatch, capsys):
    """Runs a command in the folder, in this process; gives the exit code, what it printed, and its errors."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["warpmuscle", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            program.main()
        shown = capsys.readouterr()
        return int(left.value.code or 0), shown.out.strip(), shown.err.strip()

    return call


@pytest.mark.long
def test_plot_draws_all_that_a_file_has_and_says_what_it_has_not(folder, run):
    assert run("plot", "best.h5", "-o", "every.png")[0] == 0
    assert {file.name for file in folder.glob("every_*.png")} == {f"every_{kind}.png" for kind in KINDS}
    code, _, errors = run("plot", "walk.h5")
    assert (code, errors) == (0, "left out: walk.h5 holds no search; `warpmuscle optimize` writes files that do")
    assert (folder / "walk_angles.png").exists()


def test_plot_draws_chosen_figures_under_the_names_given(folder, run):
    assert run("plot", "walk.h5", "--what", "angles", "-o", "angles.svg") == (0, "wrote angles.svg", "")
    assert run("plot", "walk.h5", "--what", "dataset:/replay/0/com", "--what", "joints", "-o", "a.pdf")[0] == 0
    assert {file.name for file in folder.glob("a_*.pdf")} == {"a_replay_0_com.pdf", "a_joints.pdf"}


def test_report_writes_a_page_and_still_prints_lines(folder, run):
    assert "60 candidates" in run("report", "best.h5")[1]
    assert run("report", "best.h5", "-o", "best.html", "--reference", "walk.h5")[:2] == (0, "wrote best.html")
    assert (folder / "best.html").read_text().rstrip().endswith("</html>")


def test_video_writes_a_film(run):
    done = run("video", "walk.h5", "-o", "walk.gif", "--size", "96x64", "--rate", 5, "--end", 1)
    assert done[:2] == (0, "wrote walk.gif: 5 frames, 1 s")


def test_video_shows_several_files_side_by_side(run):
    done = run("video", "walk.h5", "best.h5", "-o", "both.gif", "--size", "192x64", "--rate", 5, "--end", 1)
    assert done[:2] == (0, "wrote both.gif: 5 frames, 1 s")


@pytest.mark.parametrize("command", [("plot", "-o", "x.png"), ("report", "-o", "x.html"), ("video", "-o", "x.mp4")])
@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("nothing.h5", "nothing.h5: no such file"),
        ("text.h5", "text.h5: not an HDF5 file, or damaged"),
        ("torn.h5", "torn.h5: not an HDF5 file, or damaged"),
        ("other.h5", "other.h5: an HDF5 file, but not one written by warpmuscle"),
        ("newer.h5", "format version 99 is newer than 3"),
    ],
)
def test_bad_files_give_one_line(command, file: str, message: str, folder, run):
    code, _, errors = run(command[0], file, *command[1:])
    assert (code, len(errors.splitlines())) == (2, 1)
    assert message in errors
    assert not list(folder.glob("x*"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("video", "still.h5", "-o", "x.gif"), "still.h5 holds no motion"),
        (("plot", "still.h5", "--what", "angles", "-o", "x.png"), "still.h5 holds no motion"),
        (("plot", "walk.h5", "--what", "angels"), "did you mean 'angles'"),
        (("plot", "walk.h5", "--what", "dataset:/replay/0/con"), "did you mean '/replay/0/com'"),
        (("plot", "walk.h5", "--what", "angles", "-o", "x.bmp"), "a figure is written as .png, .svg, .pdf"),
        (("report", "walk.h5", "-o", "x.txt"), "a report is written as .html"),
        (("video", "walk.h5", "-o", "x.avi"), "a film is written as .mp4, .gif, .webp"),
        (("video", "walk.h5", "-o", "x.gif", "--replay", 4), "none has number 4"),
    ],
)
def test_wrong_wishes_give_one_line(arguments, message: str, folder, run):
    code, _, errors = run(*arguments)
    assert (code, len(errors.splitlines())) == (2, 1)
    assert message in errors
    assert not list(folder.glob("x*"))


def test_help_of_plot_names_every_kind(run):
    shown = " ".join(run("plot", "--help")[1].split())
    assert all(kind in shown for kind in KINDS)
