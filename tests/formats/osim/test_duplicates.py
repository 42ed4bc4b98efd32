"""Names that a model has twice: joints, frames and muscles get OpenSim's names, coordinates their body's."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import Scene


def two_pins(first: str, second: str, forces: str = "") -> str:
    """Two links on pins of one name, whose coordinates are called as given."""
    joints = small.joint("PinJoint", "pin", "ground", "upper", small.coordinate(first)) + small.joint(
        "PinJoint", "pin", "upper", "lower", small.coordinate(second), place="0 -0.3 0"
    )
    bodies = small.body("upper", center="0 -0.1 0") + small.body("lower", center="0 -0.1 0")
    return small.model(bodies, joints, forces)


def loaded(folder: Path, text: str) -> tuple[Scene, list[Ignored]]:
    ignored: list[Ignored] = []
    return load(small.written(folder, text), ignored=ignored), ignored


def test_joints_of_one_name_both_carry_their_bodies(tmp_path: Path):
    scene, ignored = loaded(tmp_path, two_pins("a", "b"))
    assert {name: joint.child for name, joint in scene.character.joints.items()} == {"a": "upper", "b": "lower"}
    (note,) = [note for note in ignored if "'pin_0'" in note.reason]
    assert note.line > 0
    assert note.text == "PinJoint pin"


def test_a_coordinate_that_comes_again_is_called_after_its_body_and_paths_to_it_find_it(tmp_path: Path):
    moving = (
        '<ConditionalPathPoint name="p"><socket_parent_frame>/bodyset/lower</socket_parent_frame><location>0.05 -0.05 0'
        "</location><socket_coordinate>/jointset/pin_0/q</socket_coordinate><range>0.1 1</range></ConditionalPathPoint>"
    )
    points = small.point("a", "upper", "0.02 -0.1 0") + moving + small.point("b", "lower", "0.02 -0.1 0")
    scene, ignored = loaded(tmp_path, two_pins("q", "q", small.muscle("m", points)))
    assert list(scene.character.joints) == ["q", "lower_q"]
    condition = scene.character.muscles["m"].path[1].condition
    assert condition is not None
    assert condition.joint == "lower_q"
    assert any("'lower_q'" in note.reason for note in ignored)


def test_muscles_of_one_name_are_two(tmp_path: Path):
    points = small.point("a", "upper", "0.02 -0.1 0") + small.point("b", "lower", "0.02 -0.1 0")
    text = two_pins("a", "b", small.muscle("m", points) + small.muscle("m", points) + small.muscle("m", points))
    scene, _ = loaded(tmp_path, text)
    assert list(scene.character.muscles) == ["m", "m_0", "m_1"]


def test_names_are_those_that_opensim_gives(tmp_path: Path):
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")
    path = small.written(tmp_path, two_pins("a", "b"))
    model = opensim.Model(str(path))
    model.initSystem()
    assert [joint.getName() for joint in model.getJointSet()] == ["pin", "pin_0"]
    lower = model.getBodySet().get("lower")
    scene = load(path, ignored=[])
    assert scene.character.joints["b"].child == lower.getName()
    np.testing.assert_allclose(scene.character.joints["b"].position_in_parent, (0.0, -0.2, 0.0), atol=1e-12)


@pytest.mark.parametrize(
    ("order", "ground", "expected"),  # m; OpenSim 4.6 takes the ground's first, and then that of the first body
    [("ab", None, 0.1), ("ba", None, 0.2), ("ba", 0.3, 0.3), ("ba", -0.3, None)],
)
def test_of_two_surfaces_of_one_name_paths_go_round_the_first(
    tmp_path: Path, order: str, ground: float | None, expected: float | None
) -> None:  # fmt: skip
    def surface(radius: float) -> str:
        active = f"<active>{str(radius > 0.0).lower()}</active><radius>{abs(radius)}</radius>"
        one = f'<WrapCylinder name="w">{active}<length>1</length></WrapCylinder>'
        return f"<WrapObjectSet><objects>{one}</objects></WrapObjectSet>"

    radii = {"a": 0.1, "b": 0.2}
    bodies = "".join(small.body(name, more=surface(radii[name])) for name in order)
    joints = "".join(small.joint("PinJoint", f"j{n}", "ground", n, small.coordinate(f"q{n}")) for n in order)
    wraps = '<PathWrap name="p"><wrap_object>w</wrap_object></PathWrap>'
    force = small.muscle("m", small.point("p", "ground", "-1 0 0") + small.point("q", "a", "1 0 0"), wraps)
    more = "" if ground is None else f'<Ground name="ground">{surface(ground)}</Ground>'
    scene, ignored = loaded(tmp_path, small.model(bodies, joints, force, more))
    assert [one.radius for one in scene.character.surfaces.values()] == ([] if expected is None else [expected])
    others = [note for note in ignored if note.text == "WrapCylinder w"]
    assert len(others) == (1 if ground is None else 2)
    assert all("paths go round the surface of this name" in note.reason for note in others)


def test_what_has_no_name_is_called_after_its_class(tmp_path: Path):
    text = two_pins("a", "b").replace('<PinJoint name="pin">', "<PinJoint>").replace(' name="b"', "")
    points = small.point("p", "upper", "0.02 0 0") + small.point("r", "lower", "0.02 -0.1 0")
    text = text.replace("</Model>", f"<ForceSet><objects>{small.muscle('', points)}</objects></ForceSet></Model>")
    scene, ignored = loaded(tmp_path, text.replace(' name=""', ""))
    assert {name: joint.child for name, joint in scene.character.joints.items()} == {
        "a": "upper",
        "coordinate": "lower",
    }
    assert list(scene.character.muscles) == ["millard2012equilibriummuscle"]
    assert any("it is called 'pinjoint_0'" in note.reason for note in ignored)


def test_of_two_lists_of_coordinates_the_last_counts(tmp_path: Path):
    given = f"<coordinates>{small.coordinate('b')}</coordinates>"
    scene, ignored = loaded(tmp_path, two_pins("a", "b").replace(given, given + given))
    assert list(scene.character.joints) == ["a", "b"]
    assert not [note for note in ignored if "another one of this name" in note.reason and "Coordinate" in note.text]
