"""Reading `.sbc` files: gains, states, trajectories, where the machine starts."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import rbs, sbc
from warpmuscle.formats.lines import Notes
from warpmuscle.scene import PD, Body, Character, Curve, Joint

CHARACTER = Character(
    root="pelvis",
    bodies={"pelvis": Body(1.0, (1.0, 2.0, 4.0)), "leg": Body(1.0, (0.5, 0.1, 0.25))},
    joints={"hip": Joint("ball", "pelvis", "leg", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))},
)
STATE = """ConState {number}
    nextState 0
    transitionOn footDown
    stateStance {stance}
    time 0.7
{trajectories}
/ConState
"""
TRAJECTORY = """trajectory hip
    component
        rotationAxis 1 0 0
        {lines}
    /component
/trajectory
"""


def parse(tmp_path: Path, text: str) -> tuple[sbc.Contents, Notes]:
    path, notes = tmp_path / "a.sbc", Notes()
    path.write_text(text)
    return sbc.read(path, CHARACTER, notes), notes


def state(tmp_path: Path, trajectories: str = ""):
    contents, notes = parse(tmp_path, STATE.format(number=0, stance="reverse", trajectories=trajectories))
    return contents.controller.states[0], notes


def component(tmp_path: Path, lines: str):
    read, notes = state(tmp_path, TRAJECTORY.format(lines=lines))
    return read.trajectories["hip"].components[0], notes


def test_rows_of_two_fields_take_damping_and_scale_from_stiffness_and_inertia(tmp_path):
    pd = parse(tmp_path, "PDParams\nhip 100\nroot 10\n/PDParams\n")[0].controller.pd
    assert pd == {"hip": PD(100.0, 10.0, 10000.0, (1.0, 0.2, 0.5)), "root": PD(10.0, 1.0, 10000.0, (0.25, 0.5, 1.0))}


def test_later_rows_overwrite_earlier_ones_and_say_so(tmp_path):
    row = "hip {} 2 3 4 5 6\n"
    contents, notes = parse(tmp_path, f"PDParams\n{row.format(1)}/PDParams\nPDParams\n{row.format(7)}/PDParams\n")
    assert contents.controller.pd == {"hip": PD(7.0, 2.0, 3.0, (4.0, 5.0, 6.0))}
    assert [(one.line, one.reason) for one in notes.ignored] == [(2, "replaced by a later line")]


@pytest.mark.parametrize(
    ("stance", "lines", "expected"),
    [
        ("reverse", "", "left"),
        ("reverse", "startAtState 0", "right"),
        ("reverse", "startAtState 0\nstartingStance left", "left"),
        ("reverse", "startingStance right\nstartAtState 0", "left"),
        ("reverse", "startAtState 0\nstartAtState 0", "left"),
        ("same", "startingStance right\nstartAtState 0", "right"),
        ("right", "startAtState 0", "right"),
    ],
)
def test_starting_at_a_state_applies_its_stance_rule(tmp_path, stance, lines, expected):
    text = STATE.format(number=0, stance=stance, trajectories="") + lines
    assert parse(tmp_path, text)[0].controller.start_stance == expected


def test_feedback_keyword_is_not_taken_for_its_projection_axis(tmp_path):
    lines = "feedback linear\nfeedbackProjectionAxis 0 0 1\ncd 0.5\ncv -0.2\ndMin -1\nvMax 2\n/feedback"
    feedback = component(tmp_path, lines)[0].feedback
    assert (feedback.axis, feedback.cd, feedback.cv) == ((0.0, 0.0, 1.0), 0.5, -0.2)
    assert (feedback.d_limits, feedback.v_limits) == ((-1.0, 1000.0), (-1000.0, 2.0))


def test_knots_are_sorted_and_of_two_at_one_phase_the_later_stays(tmp_path):
    read, notes = component(tmp_path, "baseTrajectory\n0.5 1\n0.1 2\n0.5 3\n/baseTrajectory")
    assert (read.phase, read.angle) == ([0.1, 0.5], [2.0, 3.0])
    assert "its knot at phase 0.5 of value 1" in notes.ignored[0].reason


def test_no_knots_are_allowed(tmp_path):
    assert component(tmp_path, "baseTrajectory\n/baseTrajectory")[0].phase == []
    assert state(tmp_path, "trajectory hip\n/trajectory")[0].trajectories["hip"].components == []


def test_of_two_trajectories_of_one_name_the_later_stays_in_its_place(tmp_path):
    trajectories = "".join(f"trajectory {name}\n/trajectory\n" for name in ("hip", "root", "hip"))
    read, notes = state(tmp_path, trajectories)
    assert list(read.trajectories) == ["root", "hip"]
    assert notes.ignored[0].reason == "replaces the trajectory 'hip' of line 6"


def test_strength_frame_and_set_points(tmp_path):
    text = "trajectory hip\ncharacterFrameRelative\nstrengthTrajectory\n0 0.5\n/strengthTrajectory\n/trajectory\n"
    read, _ = state(tmp_path, text + "vTrajZ\n1 2\n0 1\n/vTrajZ\ndTrajX\n/dTrajX\n")
    assert read.trajectories["hip"].frame == "character"
    assert read.trajectories["hip"].strength == Curve([0.0], [0.5])
    assert read.balance.velocity_z == Curve([0.0, 1.0], [1.0, 2.0])
    assert read.balance.distance_x is None


def test_walk_has_all_its_feedback(reference_data):
    notes = Notes()
    character = rbs.read(reference_data / "simbicon/characters/bipV2/bipV2.rbs", notes).character
    controller = sbc.read(reference_data / "simbicon/controllers/bipV2/fWalk.sbc", character, notes).controller
    swing_hip = controller.states[0].trajectories["SWING_Hip"].components
    assert [(c.feedback.cd, c.feedback.cv) if c.feedback else None for c in swing_hip] == [
        None, (-0.3, -0.3), (0.55, 0.3),
    ]  # fmt: skip
    assert controller.stance_hip_damping == 25.0
    assert controller.pd["lHip"] == PD(300.0, 30.0, 10000.0, (1.0, 0.66, 1.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("ConState 1\n/ConState\n", ":1: states are numbered in order: this one must be 0"),
        ("ConState 0\n/ConState\n", ":1: controller.states.0: this state has no `nextState`"),
        ("startAtState 0\n", ":1: controller.start_state: no state 0 above this line"),
        ("startingStance up\n", ":1: `startingStance` takes left or right, not 'up'"),
        ("PDParams\nhip 1 2 3\n/PDParams", ":2: gains of 'hip': needs kp alone"),
        ("PDParams\nhip x\n/PDParams", ":2: this line: 'x' is not a number"),
        ("PDParams\nhip 1\n", ":1: `PDParams` is not closed"),
        (STATE.format(number=0, stance="up", trajectories=""), ":4: `stateStance` takes left or right"),
        (
            STATE.format(number=0, stance="same", trajectories="trajectory hip\n"),
            ":8: unexpected `/ConState`; is `/traj",
        ),
        (STATE.format(number=0, stance="same", trajectories="dTrajX\n0 a\n/dTrajX"), ":7: this line: 'a' is not"),
    ],
)
def test_bad_lines_are_named_by_file_and_line(tmp_path, text, message):
    with pytest.raises(SceneError, match=message):
        parse(tmp_path, text)


def test_trajectories_by_which_a_later_program_steers_are_named_with_their_line_and_left_out(tmp_path):
    texts = [TRAJECTORY.replace("hip", name).format(lines="") for name in ("swing_foot", "velD", "hip")]
    read, notes = state(tmp_path, "".join(texts))
    assert list(read.trajectories) == ["hip"]
    lines = Path(tmp_path / "a.sbc").read_text().splitlines()
    assert [(one.line, one.text) for one in notes.ignored] == [
        (lines.index(f"trajectory {name}") + 1, name) for name in ("swing_foot", "velD")
    ]


def test_numbers_of_seconds_may_say_so(tmp_path):
    read, notes = component(tmp_path, "baseTrajectory\n0.000000s 0.2\n0.5 0.000000s\n/baseTrajectory")
    assert (read.phase, read.angle) == ([0.0, 0.5], [0.2, 0.0])
    assert [one.reason for one in notes.ignored] == ["the s of 0.000000s is left out"] * 2
    with pytest.raises(SceneError, match=r"a\.sbc:\d+: .*'0\.000000m' is not a finite number"):
        component(tmp_path, "baseTrajectory\n0.000000m 0.2\n/baseTrajectory")


def test_of_several_curves_by_speed_the_first_one_is_used(tmp_path):
    curve = "baseTrajectory ({speed})\n0.5 {angle}\n/baseTrajectory\n"
    text = curve.format(speed="0.0,0.3", angle=0.1) + curve.format(speed="0.0,0.7", angle=0.9)
    read, notes = component(tmp_path, text)
    assert (read.phase, read.angle) == ([0.5], [0.1])
    assert [one.text for one in notes.ignored] == ["baseTrajectory (0.0,0.7)"]
