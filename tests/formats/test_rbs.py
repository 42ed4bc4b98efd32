"""Reading `.rbs` files: bodies, joints, ground, and what is said about the rest."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, rbs
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.rbs_blocks import Contents
from warpmuscle.scene import Box, Capsule, Ground, Muscle, Sphere, ViaPoint

TWO_BODIES = """
A_RigidBody
    name pelvis
    mass 10
    planar
    position 0 1 0.5
    orientation 1.5707963267948966 0 2 0
/End
A_RigidBody
    name leg
/End
ArticulatedFigure
    root pelvis
    {joint}
        name hip
        parent pelvis
        child leg
        jointPPos 0 -0.1 0
        jointCPos 0 0.2 0
        {limits}
    /Joint
/ArticulatedFigure
"""

MUSCLE = """    Muscle # of the hip
        maxForce 1500 # N
        optimalLength 0.1
        name GLU
        A_RigidBody pelvis
        position 0 -0.1 0.05 # origin
        slackLength 0.12
        A_RigidBody leg
        position -0 0.1 0.04
        {last}
    /Muscle
/ArticulatedFigure
"""
WITH_MUSCLE = TWO_BODIES.replace("/ArticulatedFigure\n", MUSCLE)


def with_muscle(last: str = "") -> str:
    """A file with a muscle, one of its lines being the given one."""
    return WITH_MUSCLE.format(joint="hingeJoint 1 0 0", limits="jointLimits 0 1", last=last)


def parse(tmp_path: Path, text: str | bytes) -> tuple[Contents, Notes]:
    path, notes = tmp_path / "a.rbs", Notes()
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return rbs.read(path, notes), notes


def hip(tmp_path: Path, joint: str, limits: str = ""):
    character = parse(tmp_path, TWO_BODIES.format(joint=joint, limits=limits))[0].character
    assert character is not None
    return character.joints["hip"]


def test_biped_has_15_bodies_14_joints_28_internal_degrees_of_freedom_and_70_4_kg(reference_data):
    character = rbs.read(reference_data / "simbicon/characters/bipV2/bipV2.rbs", Notes()).character
    freedom = {"ball": 3, "universal": 2, "hinge": 1}
    assert (len(character.bodies), len(character.joints)) == (15, 14)
    assert sum(freedom[joint.type] for joint in character.joints.values()) == 28
    assert sum(body.mass for body in character.bodies.values()) == pytest.approx(70.4)
    assert character.root == "pelvis"
    assert character.root_joint == "free"


def test_hip_flexes_by_1_9_and_extends_by_1_3_about_its_swing_axis(reference_data):
    character = rbs.read(reference_data / "simbicon/characters/bipV2/bipV2.rbs", Notes()).character
    assert character.joints["lHip"].limits == [(-1.9, 1.3), (-1.0, 1.0), (-1.0, 0.25)]
    assert character.joints["rHip"].limits == [(-1.9, 1.3), (-1.0, 1.0), (-0.25, 1.0)]
    assert character.joints["lHip"].limit_damping == 8.0
    assert character.joints["lKnee"].limits == [(0.0, 2.5)]


def test_limits_of_ball_joints_change_sign_about_swing_and_twist_only(tmp_path):
    joint = hip(tmp_path, "ballInSocketJoint 1 0 0 0 1 0", "jointLimits -1 2 -3 4 -5 6")
    assert joint.limits == [(-2.0, 1.0), (-3.0, 4.0), (-6.0, 5.0)]
    assert joint.axes == [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]


def test_limits_of_hinge_and_universal_joints_keep_theirs(tmp_path):
    assert hip(tmp_path, "hingeJoint 0 -1 0", "jointLimits -2.7 0 # bent").limits == [(-2.7, 0.0)]
    assert hip(tmp_path, "universalJoint 1 0 0 0 0 1", "jointLimits -1 2 -3 4 5 x").limits == [(-1.0, 2.0), (-3.0, 4.0)]
    assert hip(tmp_path, "hingeJoint 1 0 0").limits == []


def test_of_three_axes_of_a_ball_joint_swing_and_twist_are_used(tmp_path):
    joint = hip(tmp_path, "ballInSocketJoint 1 0 0 0 0 1 0 1 0")
    assert joint.axes == [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]


def test_root_may_be_planar_and_gives_the_initial_pose(tmp_path):
    contents, _ = parse(tmp_path, TWO_BODIES.format(joint="stiffJoint", limits=""))
    assert contents.character.root_joint == "planar"
    assert contents.initial.root_position == (0.0, 1.0, 0.5)
    np.testing.assert_allclose(contents.initial.root_orientation, (0, 0.5**0.5, 0, 0.5**0.5), atol=1e-15)
    assert contents.character.joints["hip"].type == "fixed"


def test_bodies_have_the_defaults_of_the_original(tmp_path):
    leg = parse(tmp_path, TWO_BODIES.format(joint="hingeJoint 1 0 0", limits=""))[0].character.bodies["leg"]
    assert (leg.mass, leg.inertia, leg.friction, leg.shapes) == (1.0, (1.0, 1.0, 1.0), 1.5, [])


def test_shapes_in_any_order_of_corners(tmp_path):
    shapes = "CDP_Box 1 -2 3 -1 2 -3\nCDP_Sphere 1 2 3 4\nCDP_Capsule 1 2 3 4 5 6 7\n"
    text = TWO_BODIES.format(joint="hingeJoint 1 0 0", limits="").replace("name leg\n", f"name leg\n{shapes}")
    assert parse(tmp_path, text)[0].character.bodies["leg"].shapes == [
        Box((-1.0, -2.0, -3.0), (1.0, 2.0, 3.0)),
        Sphere((1.0, 2.0, 3.0), 4.0),
        Capsule((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), 7.0),
    ]


def test_static_plane_is_the_ground(tmp_path):
    text = "RigidBody\nname g\nstatic\nCDP_Plane 0 2 0 5 -0.025 7\nfrictionCoefficient 2.5\n/End"
    assert parse(tmp_path, text)[0].ground == Ground(normal=(0.0, 2.0, 0.0), height=-0.025, friction=2.5)


def test_keywords_match_by_prefix_and_case(tmp_path):
    text = TWO_BODIES.format(joint="hingeJoint 1 0 0", limits="Name other")
    contents, notes = parse(tmp_path, text.replace("mass 10", "mass10"))
    assert contents.character.bodies["pelvis"].mass == 10.0
    assert [(one.text, one.reason) for one in notes.ignored] == [("Name other", "unknown keyword")]
    with pytest.raises(SceneError, match=r"a\.rbs:4: `mass`: 'XYZ' is not a number"):
        parse(tmp_path, text.replace("mass 10", "massXYZ 3"))


def test_line_ends_and_a_missing_last_one_do_not_matter(tmp_path):
    text = TWO_BODIES.format(joint="hingeJoint 1 0 0", limits="jointLimits 0 1")
    expected = parse(tmp_path, text)[0]
    assert parse(tmp_path, text.replace("\n", "\r\n"))[0] == expected
    assert parse(tmp_path, text.rstrip("\n"))[0] == expected
    assert parse(tmp_path, "# caf\xe9\n".encode("latin-1") + text.encode())[0] == expected


def test_meshes_and_unknown_lines_are_listed_and_never_silent(tmp_path):
    text = with_muscle("mass 3\nForce 7").replace("jointLimits 0 1", "actuationType motor\nmaxForce 3")
    notes = parse(tmp_path, text.replace("name leg", "name leg\nmesh a.obj\nvelocity 1 0 0\nfoo"))[1]
    assert [(one.line, one.text) for one in notes.ignored] == [
        (11, "mesh a.obj"), (13, "foo"), (24, "maxForce 3"), (23, "actuationType motor"), (35, "mass 3"),
        (36, "Force 7"), (12, "velocity 1 0 0"),
    ]  # fmt: skip


def test_muscles_have_a_path_and_properties_in_any_order(tmp_path):
    contents, notes = parse(tmp_path, with_muscle("delay 0.005"))
    path = [ViaPoint("pelvis", (0.0, -0.1, 0.05)), ViaPoint("leg", (0.0, 0.1, 0.04))]
    assert contents.character.muscles == {"GLU": Muscle(path=path, f_max=1500.0, l_opt=0.1, l_slack=0.12, delay=0.005)}
    assert notes.ignored == []
    assert parse(tmp_path, with_muscle())[0].character.muscles["GLU"].delay == 0.0


def test_joints_marked_as_driven_by_muscles_are_known_by_their_lines(tmp_path):
    text = with_muscle().replace("jointLimits 0 1", "actuationType muscle")
    driven = parse(tmp_path, text)[0].driven
    assert {name: line.number for name, line in driven.items()} == {"hip": 20}
    assert parse(tmp_path, text.replace("actuationType", "#actuationType"))[0].driven == {}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass 10", "mass ten", ":4: `mass`: 'ten' is not a number"),
        ("mass 10", "mass 1e999", ":4: `mass`: '1e999' is not a finite number"),
        ("mass 10", "mass", r":4: `mass` needs 1 number \(kg\), got 0"),
        ("name leg", "name pelvis", ":9: there are two bodies called 'pelvis'"),
        ("root pelvis", "", ":12: this ArticulatedFigure has no root"),
        ("parent pelvis", "", ":14: this joint has no parent"),
        ("jointLimits 0 1", "jointLimits 1 0", "joints.hip.limits: low 1 is greater than high 0"),
        ("/End\nArt", "\nArt", ":12: `ArticulatedFigure` within a A_RigidBody; is `/End` missing"),
        ("    /Joint\n/ArticulatedFigure\n", "", ":14: `hingeJoint` is not closed: the file ends before `/Joint`"),
    ],
)
def test_bad_lines_are_named_by_file_and_line(tmp_path, old, new, message):
    text = TWO_BODIES.format(joint="hingeJoint 1 0 0", limits="jointLimits 0 1")
    assert old in text
    with pytest.raises(SceneError, match=message):
        parse(tmp_path, text.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("name GLU", "", r"a\.rbs:22: this muscle has no name"),
        ("name GLU", "name", r"a\.rbs:25: `name` needs a name"),
        ("maxForce 1500", "#", r"a\.rbs:22: character\.muscles\.GLU\.f_max: muscle 'GLU' has no maxForce"),
        ("optimalLength", "#", r"a\.rbs:22: .*\.l_opt: muscle 'GLU' has no optimalLength"),
        ("slackLength", "#", r"a\.rbs:22: .*\.l_slack: muscle 'GLU' has no slackLength"),
        ("maxForce 1500", "maxForce much", r"a\.rbs:23: `maxForce`: 'much' is not a number"),
        ("A_RigidBody pelvis", "", r"a\.rbs:27: `position` of a muscle must follow `A_RigidBody <body>`"),
        ("A_RigidBody leg", "", r"a\.rbs:30: `position` of a muscle must follow"),
        ("position 0 -0.1 0.05", "position 0 -0.1", r"a\.rbs:27: `position` needs 3 numbers \(m\), got 2"),
        ("/Muscle\n", "/Muscle\nMuscle\nname GLU\nmaxForce 1\noptimalLength 1\nslackLength 1\n/Muscle\n",
         r"a\.rbs:33: character\.muscles\.GLU: there are two muscles called 'GLU'"),
        ("/Muscle\n", "", r"a\.rbs:32: `/ArticulatedFigure` within a Muscle; is `/Muscle` missing"),
        ("/Muscle\n/ArticulatedFigure\n", "", r"a\.rbs:22: `Muscle` is not closed: the file ends before `/Muscle`"),
    ],
)  # fmt: skip
def test_bad_lines_of_muscles_are_named_by_file_and_line(tmp_path, old, new, message):
    text = with_muscle()
    assert old in text
    with pytest.raises(SceneError, match=message):
        parse(tmp_path, text.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("A_RigidBody leg", "A_RigidBody lge", r"a\.rbs:30: .*GLU\.path\.1\.body: .* 'lge'; did you mean 'leg'"),
        (
            "A_RigidBody leg\n        position",
            "mesh",
            r"a\.rbs:22: .*GLU\.path: a path needs at least two points, got 1",
        ),
        ("maxForce 1500", "maxForce 0", r"a\.rbs:23: .*GLU\.f_max: must be greater than 0"),
        ("slackLength 0.12", "slackLength -1", r"a\.rbs:28: .*GLU\.l_slack: must not be negative"),
    ],
)
def test_unsound_muscles_are_named_by_file_and_line(tmp_path, old, new, message):
    text = with_muscle()
    assert old in text
    (tmp_path / "a.rbs").write_text(text.replace(old, new))
    with pytest.raises(SceneError, match=message):
        load(tmp_path / "a.rbs", ignored=[])
