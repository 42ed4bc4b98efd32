"""Several results are drawn over one another, with a legend that names their files."""

from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import warpmuscle as wm
from small_result import march, search_result, walk_scene
from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error
from warpmuscle.plots.overlay import OVERLAYS

FIRST = search_result()
SECOND = replace(FIRST, replays=(march(walk_scene().character, 0.9, 4.0, 401, 56),))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("overlay")
    for name, result in (("before", FIRST), ("after", SECOND)):
        wm.write(folder / f"{name}.h5", result)
    return [folder / "before.h5", folder / "after.h5"]


def legend(figure) -> list[str]:
    return [text.get_text() for one in figure.legends for text in one.get_texts()]


@pytest.mark.parametrize("kind", OVERLAYS)
def test_a_legend_names_the_files_and_each_has_curves(kind: str, files: list[Path]):
    both, alone = wm.plot(files, kind, norms=False), wm.plot(files[:1], kind, norms=False)
    assert legend(both)[:2] == ["before", "after"]
    assert both is not alone
    colors = {line.get_color() for line in both.axes[0].get_lines() if len(line.get_xdata()) > 2}
    assert len(colors) == 2


def test_results_without_files_are_told_apart():
    assert legend(wm.plot([FIRST, SECOND], "convergence")) == ["walk56, 1", "walk56, 2"]


def test_panels_of_muscles_share_their_scale(files: list[Path]):
    figure = wm.plot(files, "activation", muscles=["?SOL", "?TA"])
    assert len({axes.get_ylim() for axes in figure.axes}) == 1


def test_a_kind_that_shows_one_result_says_so(files: list[Path]):
    with pytest.raises(Error, match="sticks shows one result at a time; over one another there are angles"):
        wm.plot(files, "sticks")
    with pytest.raises(Error, match="source must be"):
        wm.plot([], "angles")


def test_the_command_draws_all_that_can_be_drawn_over_one_another(
    files: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["plot", *map(str, files), "-o", "both.svg"])
    assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.iterdir()} == {f"both_{kind}.svg" for kind in OVERLAYS}
    text = (tmp_path / "both_angles.svg").read_text()
    assert "before" in text
    assert "after" in text
