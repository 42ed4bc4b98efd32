"""OpenSim's model files as records, in the layouts of several versions, and hostile ones refused in one line."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.frames import on_body
from warpmuscle.formats.osim.read import read
from warpmuscle.formats.osim.records import Model

OLD = """<?xml version="1.0"?>
<OpenSimDocument Version="20302"><Model name="old"><ForceSet><objects>
<Thelen2003Muscle name="m"><isDisabled>false</isDisabled><GeometryPath><PathPointSet><objects>
<PathPoint name="a"><body>ground</body><location>0 0.1 0</location></PathPoint>
<ConditionalPathPoint name="c"><body>rod</body><location>0 0 0.1</location><range>-1 0.5</range>
<coordinate>q</coordinate></ConditionalPathPoint>
<PathPoint name="b"><body>rod</body><location>0.01 -0.4 0</location></PathPoint>
</objects></PathPointSet></GeometryPath><max_isometric_force>700</max_isometric_force></Thelen2003Muscle>
<CoordinateActuator name="off"><isDisabled> true </isDisabled><coordinate>q</coordinate></CoordinateActuator>
</objects></ForceSet><BodySet><objects>
<Body name="ground"><mass>0</mass><Joint/></Body>
<Body name="rod"><mass>2</mass><mass_center>0 -0.5 0</mass_center><inertia_xx>0.5</inertia_xx><inertia_yy>2</inertia_yy>
<inertia_xy>0.1</inertia_xy><Joint><PinJoint name="pin"><parent_body> ground </parent_body>
<location_in_parent>0 1 0</location_in_parent><orientation_in_parent>0 0 0.5</orientation_in_parent>
<location>0 0.2 0</location><orientation>0 0 0</orientation><CoordinateSet><objects>
<Coordinate name="q"><default_value>0.3</default_value><range>-1 1</range></Coordinate></objects></CoordinateSet>
<reverse>false</reverse></PinJoint></Joint></Body></objects></BodySet></Model></OpenSimDocument>
"""
OLDEST = """<OpenSimDocument Version="10600"><Model name="first"><DynamicsEngine><SimbodyEngine name="e">
<gravity>0 -9.8 0</gravity><BodySet><objects><Body name="ground"/><Body name="rod"><mass>2</mass><Joint>
<CustomJoint name="j"><parent_body>ground</parent_body><CoordinateSet><objects><Coordinate name="q"/></objects>
</CoordinateSet><TransformAxisSet><objects>
<TransformAxis name="x"><is_rotation>false</is_rotation><coordinate>q</coordinate><axis>1 0 0</axis><function>
<natCubicSpline><x>0 1 2</x><y>0 1 4</y></natCubicSpline></function></TransformAxis>
<TransformAxis name="z"><is_rotation>true</is_rotation><coordinate>q</coordinate><axis>0 0 1</axis></TransformAxis>
</objects></TransformAxisSet></CustomJoint></Joint></Body></objects></BodySet></SimbodyEngine></DynamicsEngine>
<ActuatorSet><objects><Thelen2003Muscle name="m"><MusclePointSet><objects>
<MusclePoint><body>ground</body><location>0 0 0</location></MusclePoint>
<MuscleViaPoint><body>rod</body><location>0 0 1</location><coordinate>q</coordinate><range>0 1</range></MuscleViaPoint>
<MusclePoint><body>rod</body><location>0 1 0</location></MusclePoint></objects></MusclePointSet>
<pennation_angle>0.2</pennation_angle></Thelen2003Muscle></objects></ActuatorSet></Model></OpenSimDocument>
"""


def records(folder: Path, text: str) -> Model:
    return read(small.written(folder, text), Notes())


def test_joints_of_an_old_layout_have_places_of_six_digits_as_in_opensim(tmp_path: Path):
    old = OLD.replace("0 1 0</location_in_parent>", "0 1.23456789 1e-07</location_in_parent>")
    model = records(tmp_path, old.replace("0 0 0.5</orientation", "0 0 -0.123456789</orientation"))
    _, axes, origin = on_body(model, model.joints[0].parent)
    np.testing.assert_allclose(origin, [0.0, 1.23457, 1e-7], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(axes[:, 0], [np.cos(0.123457), -np.sin(0.123457), 0.0], rtol=0.0, atol=1e-15)


def test_an_old_layout_says_the_same_as_a_new_one(tmp_path: Path):
    model = records(tmp_path, OLD)
    (joint,), (muscle,), (rod,) = model.joints, model.muscles, model.bodies
    body, axes, origin = on_body(model, joint.parent)
    assert (body, origin.tolist()) == ("/ground", [0.0, 1.0, 0.0])
    np.testing.assert_allclose(axes[:, 0], [np.cos(0.5), np.sin(0.5), 0.0])
    assert on_body(model, joint.child)[0] == "/bodyset/rod"
    assert on_body(model, joint.child)[2].tolist() == [0.0, 0.2, 0.0]
    assert joint.coordinates[0].value == 0.3
    assert rod.inertia.tolist() == [[0.5, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 1.0]]
    assert [point.frame for point in muscle.points] == ["/ground", "/bodyset/rod", "/bodyset/rod"]
    assert (muscle.points[1].coordinate, muscle.points[1].range) == ("q", (-1.0, 0.5))
    assert muscle.numbers["max_isometric_force"] == 700.0
    assert muscle.numbers["KshapeActive"] == 0.45
    assert model.forces == []


def test_the_oldest_layout_keeps_an_engine_and_sets_of_axes(tmp_path: Path):
    model = records(tmp_path, OLDEST)
    (joint,), (muscle,) = model.joints, model.muscles
    assert model.gravity == (0.0, -9.8, 0.0)
    assert joint.translations[0].function.x == (0.0, 1.0, 2.0)
    assert joint.rotations[0].function.line == (0.0, 1.0)
    assert joint.rotations[0].coordinates == ("q",)
    assert [point.coordinate for point in muscle.points] == ["", "q", ""]
    assert muscle.numbers["pennation_angle_at_optimal"] == 0.2


def test_what_an_object_does_not_say_its_class_does_in_the_defaults(tmp_path: Path):
    defaults = '<CoordinateActuator name="default"><optimal_force>300</optimal_force></CoordinateActuator>'
    forces = '<CoordinateActuator name="a"><coordinate>q</coordinate></CoordinateActuator>'
    model = records(tmp_path, small.pendulum(forces=forces, defaults=f"<defaults>{defaults}</defaults>"))
    assert model.forces[0].numbers["optimal_force"] == (300.0,)


@pytest.mark.parametrize("socket", ["/bodyset/rod", "../../bodyset/rod", "rod", "bodyset/rod"])
def test_sockets_name_frames_absolutely_relatively_and_by_name(tmp_path: Path, socket: str):
    offset = f'<PhysicalOffsetFrame name="o"><socket_parent>{socket}</socket_parent></PhysicalOffsetFrame>'
    text = small.pendulum().replace("</inertia></Body>", f"</inertia><components>{offset}</components></Body>")
    assert records(tmp_path, text).frames["/bodyset/rod/o"].parent == "/bodyset/rod"


def test_frames_stand_on_frames(tmp_path: Path):
    frames = (
        '<PhysicalOffsetFrame name="a"><socket_parent>/bodyset/rod</socket_parent><translation>1 0 0</translation>'
        "<orientation>0 0 1.5707963267948966</orientation></PhysicalOffsetFrame>"
        '<PhysicalOffsetFrame name="b"><socket_parent>/a</socket_parent><translation>1 0 0</translation>'
        "</PhysicalOffsetFrame>"
    )
    model = records(tmp_path, small.pendulum(more=f"<components>{frames}</components>"))
    body, _, origin = on_body(model, "/b")
    assert body == "/bodyset/rod"
    np.testing.assert_allclose(origin, [1.0, 1.0, 0.0], atol=1e-15)


def test_what_is_not_read_is_noted_once_a_kind_with_its_line(tmp_path: Path):
    mesh = "<attached_geometry><Mesh/></attached_geometry>"
    bodies = small.body("rod", more=mesh) + small.body("tip", more=mesh)
    joints = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    joints += small.joint("WeldJoint", "weld", "rod", "tip")
    forces = '<PointActuator name="l"/><StrangeMuscle name="m"/>'
    path, notes = small.written(tmp_path, small.model(bodies, joints, forces)), Notes()
    read(path, notes)
    found = {note.text.split()[0]: (note.line, note.reason) for note in notes.ignored}
    assert found["attached_geometry"][0] == 5
    assert found["attached_geometry"][1].startswith("not read; bodies are drawn")
    assert "pulls on nothing" in found["PointActuator"][1]
    assert "make it a Millard2012EquilibriumMuscle" in found["StrangeMuscle"][1]
    assert set(found) == {"attached_geometry", "PointActuator", "StrangeMuscle"}


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("<mass>1.0", "<mass>nan", 5, "'nan' is not a number"),
        ("<mass>1.0", "<mass>1e999", 5, "'1e999' is not a finite number"),
        ("<mass>1.0", "<mass>1e200", 5, "1e200 is beyond 1e+12"),
        ("<mass>1.0", "<mass>1 2", 5, "needs 1 number, has 2"),
        ("PinJoint", "HelicalJoint", 8, "<HelicalJoint> 'pin': joints of this class are not known"),
        ("near</socket", "nearer</socket", 8, "there is no frame 'nearer'"),
        ("/ground", "/jointset/pin/near", 11, "hangs on itself"),
        ('Version="40000"', 'Version="50000"', 2, "newer than those known here"),
        ('Version="40000"', 'Version="four"', 2, "its version is a number"),
        ("</Body>", "", 6, "not sound XML: mismatched tag"),
        ("<BodySet>", "<length_units>inches</length_units><BodySet>", 4, "not in inches; if the numbers are (OpenSim"),
        ('name="rod"', 'name="a/b"', 5, "a body needs a name"),
        ('<Model name="small">', '<Model name="small" file="a.xml">', 3, "stands in a file of its own"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_line(tmp_path: Path, old: str, new: str, line: int, message: str):
    path = small.written(tmp_path, small.pendulum().replace(old, new))
    with pytest.raises(SceneError) as caught:
        read(path, Notes())
    assert message in caught.value.message
    assert (caught.value.file, caught.value.line) == (path, line)


def test_entities_depth_and_size_are_bounded(tmp_path: Path):
    bomb = '<!DOCTYPE a [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><OpenSimDocument Version="40000">&b;</OpenSimDocument>'
    for text, message in (
        (bomb, "no document type"),
        ("<a>" * 60 + "</a>" * 60, "60|51 tables, lists or elements in each other"),
        ("<OpenSimDocument>" + "<a/>" * 500_001 + "</OpenSimDocument>", "500001 elements"),
        ("", "not sound XML: no element found"),
        ("<a/>", "begins with <OpenSimDocument>"),
    ):
        with pytest.raises(SceneError, match=message):
            records(tmp_path, text)


def test_text_of_other_encodings_is_read(tmp_path: Path):
    path = tmp_path / "latin.osim"
    path.write_bytes(small.pendulum(more="<credits>Müller</credits>").encode("latin-1"))
    assert read(path, Notes()).bodies[0].name == "rod"
    path.write_bytes(small.pendulum().replace("UTF-8", "UTF-16").encode("utf-16"))
    assert read(path, Notes()).bodies[0].name == "rod"


def test_a_coordinate_starts_at_its_default_and_not_at_an_older_initial_value(tmp_path: Path):
    text = OLD.replace(
        "<default_value>0.3</default_value>", "<default_value>0.3</default_value><initial_value>0.1</initial_value>"
    )
    for given, start in ((text, 0.3), (OLD.replace("default_value", "initial_value"), 0.3)):
        model = read(small.written(tmp_path, given), Notes())
        assert model.coordinates["q"].value == start


@pytest.mark.parametrize(("version", "turned"), [(30000, True), (30516, True), (40000, False)])
def test_a_reversed_joint_of_an_old_layout_has_its_ends_the_other_way_round(
    tmp_path: Path, version: int, turned: bool
):  # fmt: skip
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"), "<reverse>true</reverse>", "0 1 0")
    (found,) = records(tmp_path, small.model(small.body("rod"), joint, version=version)).joints
    assert (found.parent.endswith("far"), found.child.endswith("near")) == (turned, turned)
