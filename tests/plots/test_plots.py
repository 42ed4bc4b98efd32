"""Figures of results: every kind is drawn, with units on its axes; what a result does not hold is said in one line."""

import dataclasses
import functools
import re
import subprocess
import sys
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import warpmuscle as wm
from muscle_arm import arm
from small_result import arm_motion, no_parameters, search_result, walk_result, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.plots import KINDS, Absent, Choices, Subject, draw, plot
from warpmuscle.results.records import Result
from warpmuscle.results.result import write
from warpmuscle.scene.parameters import substitute
from warpmuscle.scene.people.emg import WINDOWS

SEARCHES = ("convergence", "parameters")
GAITS = ("angles", "ground_force", "moments", "body", "feet")


@pytest.fixture(scope="module")
def result() -> Result:
    """A search with the motion of its best."""
    return search_result()


@pytest.fixture(scope="module")
def drawn(result) -> Callable[[str], Figure]:
    """The figure of each kind for that search, drawn once."""
    return functools.cache(lambda kind: draw(Subject(result), kind))


@pytest.fixture(scope="module")
def armed() -> Result:
    """The motion of an arm, which does not walk."""
    return Result(toml.dumps(arm()), "cpu", "", 0, no_parameters(), replays=(arm_motion(),))


def words(figure: object) -> list[str]:
    """All texts of a figure that are shown."""
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_for_a_walk_with_units_on_its_axes(kind: str, drawn):
    figure = drawn(kind)
    shown = words(figure)
    labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
    labels += [text for text in (figure.get_supxlabel(), figure.get_supylabel()) if text]
    plain = {"candidates evaluated", "generation", "part of the maximum"}
    assert all(re.search(r"\(.+\)", label) for label in labels if label not in plain), labels
    assert "walk56" in "".join(shown)


@pytest.mark.parametrize("kind", KINDS)
def test_names_beside_the_panels_do_not_overlap(kind: str, drawn):
    figure = drawn(kind)
    figure.draw_without_rendering()
    for axes in figure.axes:
        boxes = [Text.get_window_extent(text) for text in [*axes.texts, *axes.get_yticklabels()] if text.get_text()]
        for k, box in enumerate(boxes):
            others = [other.padded(-1.0) for other in boxes[k + 1 :]]
            assert not any(box.overlaps(other) for other in others)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in (*SEARCHES, *GAITS)])
def test_kinds_that_need_no_gait_draw_an_arm(kind: str, armed):
    assert words(draw(Subject(armed), kind))


@pytest.mark.parametrize("kind", GAITS)
def test_gait_kinds_say_that_an_arm_has_no_legs(kind: str, armed):
    with pytest.raises(Absent, match=r"there is no body 'lFoot' or 'rFoot'; `character\.feet` names feet"):
        draw(Subject(armed), kind)


@pytest.mark.parametrize("kind", SEARCHES)
def test_a_simulation_has_no_search_to_draw(kind: str):
    with pytest.raises(Absent, match="holds no search"):
        draw(Subject(walk_result()), kind)


def test_a_file_without_a_motion_says_so(result):
    with pytest.raises(Absent, match="holds no motion"):
        draw(Subject(dataclasses.replace(result, replays=())), "angles")


def test_a_motion_of_another_character_is_refused(result, armed):
    mixed = dataclasses.replace(result, replays=armed.replays)
    with pytest.raises(Error, match="motion 0 is of another character than the scene 'walk56'"):
        draw(Subject(mixed), "joints")


def test_choices_that_a_result_does_not_have_are_named_with_those_it_has(result):
    for choices, message in (
        (Choices(replay=3), "numbered from 0; none has number 3"),
        (Choices(start=90.0), "within the times wanted"),
        (Choices(muscles=("lSOl",)), "no muscle is called 'lSOl'; did you mean 'lSOL'"),
    ):
        with pytest.raises(Error, match=message):
            draw(Subject(result, choices), "activation")
    with pytest.raises(Error, match="no figure is called 'angels'; did you mean 'angles'"):
        draw(Subject(result), "angels")


def test_chosen_muscles_are_shown_as_curves_of_both_sides(result):
    figure = draw(Subject(result, Choices(muscles=("?SOL", "?TA"))), "activation")
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["SOL", "TA"]
    assert len(figure.axes[0].lines) == 2


def test_norms_are_not_drawn_beside_legs_that_are_bent_where_their_angles_are_zero(result):
    def ankles_behind(scene):
        joints = dict(scene.character.joints)
        for name in ("lAnkle", "rAnkle"):
            x, y, z = joints[name].position_in_parent
            joints[name] = msgspec.structs.replace(joints[name], position_in_parent=(x, y, z - 0.4))
        return msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, joints=joints))

    crouched = dataclasses.replace(result, scene=toml.dumps(ankles_behind(walk_scene())))
    for one, drawn in ((result, True), (crouched, False)):
        labels = [text for axes in draw(Subject(one), "angles").axes for text in axes.get_legend_handles_labels()[1]]
        assert any(text.startswith("norm") for text in labels) == drawn


def test_windows_of_emg_lie_beside_activations_of_a_walk_where_norms_are_drawn(result):
    for norms in (True, False):
        figure = draw(Subject(result, Choices(muscles=("?VAS", "?SOL"), norms=norms)), "activation")
        drawn = {
            (round(patch.get_x(), 1), round(patch.get_x() + patch.get_width(), 1))
            for axes in figure.axes
            for patch in axes.patches
        }
        assert (drawn == {window for name in ("vasti", "soleus") for window in WINDOWS[name]}) == norms
        assert bool(drawn) == norms
        legends = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
        assert any("EMG" in text for text in legends) == norms


def test_control_shows_the_muscles_that_act_on_the_chosen_joint(result):
    figure = draw(Subject(result, Choices(joints=("rKnee",))), "control")
    assert {"rKnee", "rHAM", "rVAS"} <= {axes.get_title(loc="left") for axes in figure.axes}


@pytest.mark.parametrize("ending", [".png", ".svg"])
def test_the_same_result_gives_the_same_bytes(ending: str, tmp_path):
    for name in ("one", "two"):
        plot(walk_result(), "angles", tmp_path / f"{name}{ending}")
    assert (tmp_path / f"one{ending}").read_bytes() == (tmp_path / f"two{ending}").read_bytes()


def test_python_draws_results_files_and_recordings_alike(result, tmp_path):
    write(tmp_path / "a.h5", result)
    scene = substitute(walk_scene(), result.best.params)
    sources = (result, tmp_path / "a.h5", str(tmp_path / "a.h5"))
    figures = [wm.plot(source, "activation", muscles=["?SOL"], end=3.5) for source in sources]
    figures.append(wm.plot(result.replays[0], "activation", muscles=["?SOL"], end=3.5, scene=scene))
    assert len({tuple(words(figure)) for figure in figures}) == 1
    assert wm.plot(tmp_path / "a.h5", "dataset:/evaluations/cost", tmp_path / "cost.svg").axes
    assert (tmp_path / "cost.svg").read_bytes().startswith(b"<?xml")


def test_python_says_what_is_wrong_before_it_draws(result, tmp_path):
    for wrong, message in (
        (lambda: wm.plot(result.replays[0], "joints"), "with its scene"),
        (lambda: wm.plot(tmp_path / "no.h5", "joints"), "no such file"),
        (lambda: wm.plot(result, "jonts"), "did you mean 'joints'"),
        (lambda: wm.plot(result, "joints", tmp_path / "a.bmp"), "a figure is written as"),
        (lambda: wm.plot(result, "dataset:/best"), "drawn from a file"),
    ):
        with pytest.raises(wm.Error, match=message):
            wrong()
    assert not list(tmp_path.iterdir())


def test_importing_the_package_imports_neither_matplotlib_nor_warp():
    code = "import sys, warpmuscle as wm; assert not {'matplotlib', 'warp', 'h5py', 'numpy'} & set(sys.modules)"
    code += "; import warpmuscle.cli.program; assert not {'numpy', 'h5py'} & set(sys.modules)"
    code += "; wm.plot; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("name", "panels"),
    [("/replay/0/com", 1), ("replay/0/joint_torque", 14), ("/replay/0/muscle_force", 2), ("/evaluations/params", 2)],
)
def test_any_dataset_is_drawn_by_its_name(name: str, panels: int, result, tmp_path):
    write(tmp_path / "a.h5", result)
    figure = draw(Subject(result, None, tmp_path / "a.h5"), f"dataset:{name}")
    assert len(figure.axes) == panels


def test_datasets_that_cannot_be_drawn_give_one_line_with_those_that_can(result, tmp_path):
    write(tmp_path / "a.h5", result)
    for name, message in (
        ("/replay/0/con", "has no dataset '/replay/0/con'; did you mean '/replay/0/com'"),
        ("/scene", "/scene is text; there are"),
        ("/best/cost", "/best/cost is the number"),
        ("/replay", "/replay is a group"),
        ("", "has no dataset ''"),
    ):
        with pytest.raises(Error, match=message) as caught:
            draw(Subject(result, None, tmp_path / "a.h5"), f"dataset:{name}")
        assert "\n" not in str(caught.value)
        assert "/evaluations/{" in str(caught.value)


def test_free_numbers_of_the_scene_have_the_values_of_the_best(result):
    subject = Subject(result)
    name = "controller.states.0.time"
    best = float(result.best.params[result.parameters.name.index(name)])
    assert float(np.asarray(subject.scene.controller.states[0].time)) == pytest.approx(best)
    assert msgspec.structs.asdict(subject.scene)["name"] == "walk56"
