"""Texts that are no sound XML, and which OpenSim reads: they are read, and lines stay what they were."""

from pathlib import Path

import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.osim.elements import Element, parse

NESTED = "<!-- <!-- two -- hyphens --> "


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("<BodySet>", f"{NESTED}<BodySet>"),
        lambda text: text.replace("<mass>1.0<", "<mass>1.0\x00\x07<"),
        lambda text: "\n \n" + text,
        lambda text: text + "\ntrailing words",
        lambda text: text.replace("<BodySet>", "<credits>A & B, &lt;C&#62; &D</credits>\n<BodySet>"),
    ],
    ids=["comments", "bytes", "before", "behind", "ampersands"],
)
def test_what_opensim_reads_is_read_with_its_lines(tmp_path: Path, change):
    text = change(small.pendulum())
    path = tmp_path / "small.osim"
    path.write_text(text)
    root = parse(path)
    mass = next(element for element in root.all() if element.tag == "mass")
    assert mass.line == 1 + text[: text.index("<mass>")].count("\n")
    assert mass.number() == 1.0


@pytest.mark.parametrize("text", ["", "words", "<a><b></a>", "<!-- open <a/>", "\x00", "<a/><b/>"])
def test_what_is_no_model_is_refused_in_one_line(tmp_path: Path, text: str):
    path = tmp_path / "small.osim"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        parse(path)
    assert "\n" not in str(caught.value)


def test_commas_before_blanks_part_the_numbers_of_a_vector(tmp_path: Path):
    path = small.written(tmp_path, small.pendulum().replace("0 -0.5 0", "0.1, -0.5,\n 0"))
    center = next(element for element in parse(path).all() if element.tag == "mass_center")
    assert center.numbers(3) == [0.1, -0.5, 0.0]
    for text in ("0.1, -0.5, 0,", "0.1,, -0.5 0"):
        center.text = text
        assert center.numbers(3) == [0.1, -0.5, 0.0]
    center.text = "0.1,-0.5,0"  # of which OpenSim makes zeros
    with pytest.raises(SceneError, match="number"):
        center.numbers(3)


@pytest.mark.parametrize("text", ["-2 0 1.5", "-2,0,1.5", "-2, 0 , 1.5", "(-2 0 1.5)", " (-2,0, 1.5)\n"])
def test_a_list_of_any_length_may_have_commas_and_brackets(text: str):
    assert Element("x", Path("a.osim"), 1, "", text).numbers() == [-2.0, 0.0, 1.5]


@pytest.mark.parametrize(("function", "moves"), [("<function/>", True), ("<function></function>", True), ("", False)])
def test_an_empty_function_of_an_axis_is_its_coordinate_and_none_moves_nothing(
    tmp_path: Path, function: str, moves: bool
):
    transform = small.axes(rotation1=("q", "0 0 1", small.LINE), translation1=("q", "1 0 0", function))
    knee = small.joint("CustomJoint", "knee", "ground", "rod", small.coordinate("q"), transform)
    (joint,) = load(small.written(tmp_path, small.model(small.body("rod"), knee))).character.joints.values()
    assert [(shift.axis, shift.polynomial) for shift in joint.translations] == (
        [((0.0, 0.0, 1.0), [])] if moves else []
    )


def test_a_range_may_have_a_comma(tmp_path: Path):
    scene = load(small.written(tmp_path, small.pendulum().replace("<range>-2 2<", "<range>-1.5, 2<")))
    assert scene.character.joints["q"].limits == [(-1.5, 2.0)]
