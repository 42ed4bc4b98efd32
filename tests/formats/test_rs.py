"""Reading `.rs` files: the state that a simulation starts from."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import rbs, rs
from warpmuscle.formats.lines import Notes
from warpmuscle.scene import Body, Character, InitialState, Joint, JointState

BODY = Body(1.0, (1.0, 1.0, 1.0))
ZERO = (0.0, 0.0, 0.0)


def character(*joints: tuple[str, str, str]) -> Character:
    """A character from (name, parent, child)."""
    return Character(
        root="a",
        bodies=dict.fromkeys("abcdef", BODY),
        joints={name: Joint("ball", parent, child, ZERO, ZERO) for name, parent, child in joints},
    )


ONE_JOINT = character(("hip", "a", "b"))
TEXT = """# a comment
0.5

1 2 3
0.9 0.1 0.2 0.3
4 5 6
7 8 9
  # hip
0.8 0.4 0.5 0.6
-1 -0 -3
"""


def parse(tmp_path: Path, text: str) -> tuple[InitialState, Notes]:
    path, notes = tmp_path / "a.rs", Notes()
    path.write_text(text)
    return rs.read(path, ONE_JOINT, notes), notes


def test_quaternions_turn_scalar_last_and_stay_unnormalised(tmp_path):
    assert parse(tmp_path, TEXT)[0] == InitialState(
        heading=0.5,
        root_position=(1.0, 2.0, 3.0),
        root_orientation=(0.1, 0.2, 0.3, 0.9),
        root_velocity=(4.0, 5.0, 6.0),
        root_angular_velocity=(7.0, 8.0, 9.0),
        joints={"hip": JointState((0.4, 0.5, 0.6, 0.8), (-1.0, 0.0, -3.0))},
    )


def test_files_without_a_heading_leave_it_open(tmp_path):
    assert parse(tmp_path, TEXT.replace("0.5\n\n", "", 1))[0].heading is None


def test_joints_come_breadth_first_from_the_root_children_in_order_of_the_table():
    tree = character(("4", "c", "e"), ("3", "b", "d"), ("1", "a", "c"), ("2", "a", "b"), ("5", "c", "f"))
    assert rs.breadth_first(tree) == ["1", "2", "4", "5", "3"]


def test_muscle_block_is_listed_as_ignored(tmp_path):
    initial, notes = parse(tmp_path, TEXT + "muscles\n#VAS\n0\n0.5\n")
    assert initial == parse(tmp_path, TEXT)[0]
    assert [(one.line, one.reason) for one in notes.ignored] == [
        (11, "muscles start at the activation of the scene's muscle_model (2 lines of their state)")
    ]


def test_biped_starts_with_its_joints_in_the_order_of_the_file(reference_data):
    biped = rbs.read(reference_data / "simbicon/characters/bipV2/bipV2.rbs", Notes()).character
    initial = rs.read(reference_data / "simbicon/controllers/bipV2/fWalkState.rs", biped, Notes())
    assert list(initial.joints) == [
        "pelvis_torso", "lHip", "rHip", "torso_head", "lShoulder", "rShoulder", "lKnee", "rKnee", "lElbow", "rElbow",
        "lAnkle", "rAnkle", "lToeJoint", "rToeJoint",
    ]  # fmt: skip
    assert initial.root_velocity == (0.095324, -0.255831, 1.05819)
    assert initial.joints["lAnkle"].angular_velocity == (5.148876, 0.236064, -1.285515)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("-1 -0 -3\n", "", r"a\.rs:\d+: .*: the file ends before the angular velocity of joint 'hip' \(1 of 1\)"),
        ("-1 -0 -3", "-1 -0", r"a\.rs:10: .*: expected the angular velocity .*: 3 numbers, got 2"),
        ("-1 -0 -3", "-1 -0 x", r"a\.rs:10: this line: 'x' is not a number"),
        ("-1 -0 -3", "-1 -0 nan", r"a\.rs:10: this line: 'nan' is not a number"),
        ("-1 -0 -3\n", "-1 -0 -3\n1 0 0 0\n", r"a\.rs:11: expected the end of the file: the character has 1 joint"),
    ],
)
def test_bad_records_are_named_by_file_and_line(tmp_path, old, new, message):
    with pytest.raises(SceneError, match=message):
        parse(tmp_path, TEXT.replace(old, new))
