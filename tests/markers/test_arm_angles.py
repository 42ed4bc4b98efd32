"""Angles of an arm from markers: of an arm that is put together from known angles, and of recorded throws."""

import json
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error, SignalError
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.markers.arm import ANGLES, Choices, arm_angles
from warpmuscle.markers.files import Markers, read_markers
from warpmuscle.throw.recordings.motion_files import read

TIME = np.arange(151) / 100.0
RIGHT, UP, FORWARD = np.eye(3)[0] * -1.0, np.eye(3)[1], np.eye(3)[2]  # x to the left, as in scenes


def angles() -> np.ndarray:
    """Angles (T, 7), rad, of something like a throw."""
    s = 0.5 - 0.5 * np.cos(np.pi * np.clip((TIME - 0.5) / 0.8, 0.0, 1.0))
    columns = [0.4 + 2.0 * s, 0.2 + 0.1 * s, 0.5 - 0.3 * s, 1.9 - 1.5 * s, 0.3 + 0.8 * s, 0.2 - 0.4 * s, -0.4 + 0.9 * s]
    return np.stack(columns, axis=1)


def chain(side: float) -> dict[str, np.ndarray]:
    """Places (T, 3) of markers, by rotations one behind the other about the axes that the angles are meant about."""
    q = angles()
    out = side * RIGHT
    mirror = side  # turns about up and forwards change their sense on the other side, those about the lateral axis not
    lateral = RIGHT
    turns = [
        about(lateral, q[:, 0]), about(FORWARD, -mirror * q[:, 1]), about(UP, mirror * q[:, 2]),
        about(lateral, q[:, 3]), about(UP, mirror * q[:, 4]), about(lateral, q[:, 5]), about(FORWARD, mirror * q[:, 6]),
    ]  # fmt: skip
    pitch = about(lateral, np.full(len(TIME), -0.1))
    zero = np.zeros((len(TIME), 3))
    points = {"shoulder": zero + 0.2 * out, "other_shoulder": zero - 0.2 * out}
    points |= {"hip": zero + 0.1 * out - 0.5 * UP, "other_hip": zero - 0.1 * out - 0.5 * UP}
    points = {name: rotate(pitch, place) for name, place in points.items()}
    turned = pitch
    for k, turn in enumerate(turns):
        turned = multiply(turned, turn)
        if k == 2:
            points["elbow"] = points["shoulder"] + rotate(turned, zero - 0.3 * UP)
        if k == 4:
            points["wrist"] = points["elbow"] + rotate(turned, zero - 0.26 * UP)
    for name, across in (("hand_thumb", 0.03), ("hand_little", -0.03)):
        points[name] = points["wrist"] + rotate(turned, zero - 0.09 * UP + across * FORWARD)
    return points


def markers(side: float = 1.0) -> Markers:
    points = chain(side)
    place = np.stack([[1.0, 2.0, 1.4] + p @ np.array([FORWARD, -RIGHT, UP]).T for p in points.values()], axis=1)
    return Markers(Path("chain"), TIME, tuple(points), place)


@pytest.mark.parametrize("side", ["right", "left"])
def test_angles_of_an_arm_of_known_angles_are_found_on_both_sides(side):
    roles = {name: name for name in chain(1.0)}
    found = arm_angles(markers(1.0 if side == "right" else -1.0), Choices(side, roles, low_pass=0.0, before=None))
    np.testing.assert_allclose(found.angles, angles(), atol=1e-9)
    np.testing.assert_allclose(found.lean, 0.1, atol=1e-9)  # as the chain was pitched


@pytest.mark.parametrize(("up", "forward"), [("y", "x"), ("-z", "y"), ("x", "-z")])
def test_any_axes_of_a_file_will_do(up, forward):
    base = markers()
    axes = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}
    ahead, above = (np.array(axes[name[-1]]) * (-1 if name[0] == "-" else 1) for name in (forward, up))
    turned = base.position @ np.array([ahead, np.cross(above, ahead), above], float)
    roles = {name: name for name in base.names}
    found = arm_angles(Markers(base.path, TIME, base.names, turned),
                       Choices("right", roles, up, forward, low_pass=0.0, before=None))  # fmt: skip
    np.testing.assert_allclose(found.angles, angles(), atol=1e-9)


def test_recorded_throws_have_the_angles_that_came_with_them(reference_data: Path):
    """Of three throws, converted by somebody else from the same filtered points: within 0.01 degrees."""
    with np.load(reference_data / "spl_freethrow" / "throws22.npz") as data:
        names = tuple(str(name) for name in data["keypoints"])
        for trial in (0, 9, 21):
            time, points = data["time"] - data["time"][0], data["keypoint_pos_m"][trial].astype(float)
            one = Markers(Path("throws22"), time, names, points)
            found = arm_angles(one, Choices(low_pass=0.0, before=None))
            degrees = np.degrees(found.angles)
            for name in ("shoulder", "elbow", "wrist"):
                ours = degrees[:, ANGLES.index(name)]
                np.testing.assert_allclose(ours, data[f"{name}_flexion"][trial], atol=0.01)
            ours = degrees[:, ANGLES.index("shoulder_abduction")]
            np.testing.assert_allclose(ours, data["shoulder_abduction"][trial], atol=0.01)


def files_of(folder: Path) -> dict[str, Path]:
    """The same markers as a track, a table, and as MLSE's open data have them, in mm, m and feet."""
    base = markers()
    usual = dict(zip(("shoulder", "other_shoulder", "hip", "other_hip", "elbow", "wrist", "hand_thumb", "hand_little"),
                     ("R_SHOULDER", "L_SHOULDER", "R_HIP", "L_HIP", "R_ELBOW", "R_WRIST", "R_1STFINGER", "R_5THFINGER"),
                     strict=True))  # fmt: skip
    names = [usual[name] for name in base.names]
    rows = base.position.reshape(len(TIME), -1)
    head = "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t"
    trc = ["PathFileType\t4\t(X/Y/Z)\ta.trc", "DataRate\tNumFrames\tNumMarkers\tUnits"]
    trc += [f"100\t{len(TIME)}\t{len(names)}\tmm", head, "\t\tX1\tY1\tZ1"]
    trc += ["\t".join([str(k + 1), f"{t:.3f}", *(f"{x:.6f}" for x in 1000.0 * row)])
            for k, (t, row) in enumerate(zip(TIME, rows, strict=True))]  # fmt: skip
    table = [",".join(["time_s", *(f"{name}_{axis}" for name in names for axis in "xyz")])]
    table += [",".join(f"{x:.9f}" for x in [t, *row]) for t, row in zip(TIME, rows, strict=True)]
    players = [{n: list(p / 0.3048) for n, p in zip(names, frame, strict=True)} for frame in base.position]
    tracking = [{"time": round(1000.0 * t), "data": {"player": p}} for t, p in zip(TIME, players, strict=True)]
    found = {kind: folder / f"{kind}.{kind}" for kind in ("trc", "csv", "json")}
    found["trc"].write_text("\n".join(trc) + "\n")
    found["csv"].write_text("\n".join(table) + "\n")
    found["json"].write_text(json.dumps({"tracking": tracking}))
    return found


def test_the_command_makes_files_that_throws_are_read_from_of_every_kind(tmp_path):
    sources = files_of(tmp_path)
    words = [*map(str, sources.values()), "-o", str(tmp_path / "out"), "--low-pass", "0", "--whole"]
    done = CliRunner().invoke(app, ["arm-angles", *words])
    assert done.exit_code == 0, done.output
    for kind in sources:
        (motion,) = read(tmp_path / "out" / f"{kind}.csv", ANGLES)
        np.testing.assert_allclose(motion.angles, angles(), atol=1e-4)
        np.testing.assert_allclose(motion.pitch, 0.1, atol=1e-4)


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("{name}.{upper}", 1.0),
        ("{name} {axis} (mm)", 1000.0),
        ("{name}:{upper} [cm]", 100.0),
        ("{name}_{axis}_mm", 1e3),
    ],
)
def test_headings_may_name_coordinates_and_units_in_other_ways(tmp_path, head, factor):
    path = files_of(tmp_path)["csv"]
    names, *rows = path.read_text().splitlines()
    headings = [head.format(name=name[:-2], axis=name[-1], upper=name[-1].upper()) for name in names.split(",")[1:]]
    places = [[float(cell) for cell in row.split(",")] for row in rows]
    lines = [";".join(["Time (ms)", *headings])]
    lines += [";".join(f"{x:.9f}" for x in [1e3 * time, *(factor * x for x in place)]) for time, *place in places]
    path.write_text("\n".join(lines) + "\n")
    found = arm_angles(read_markers(path), Choices(low_pass=0.0, before=None))
    np.testing.assert_allclose(found.angles, angles(), atol=1e-6)


def test_what_a_camera_did_not_see_may_stand_as_zeros(tmp_path):
    path = files_of(tmp_path)["csv"]
    lines = [line.split(",") for line in path.read_text().splitlines()]
    first = next(k for k, name in enumerate(lines[0]) if name.startswith("R_WRIST"))
    for row in lines[60:64]:
        row[first : first + 3] = ["0", "0.0", "-0"]
    path.write_text("\n".join(map(",".join, lines)))
    found = arm_angles(read_markers(path), Choices(low_pass=0.0, before=None))
    np.testing.assert_allclose(found.angles, angles(), atol=0.02)


@pytest.mark.parametrize(
    ("change", "choices", "message"),
    [
        (lambda place: 1000.0 * place, {}, "the upper arm is 300 m long; name the unit of .*--unit mm"),
        (lambda place: place, {"up": "y", "forward": "x"}, "the shoulder is not above the hip; name the axis"),
        (lambda place: place * [1.0, -1.0, 1.0], {}, "does not face forwards.*--side right.*right-handed"),
        (lambda place: place, {"forward": "-x"}, "does not face forwards.*are --forward"),
    ],
    ids=["millimetres", "another axis up", "mirrored", "backwards"],
)  # fmt: skip
def test_units_and_axes_that_cannot_be_meant_are_refused(change, choices, message):
    base = markers()
    roles = {name: name for name in base.names}
    with pytest.raises(SignalError, match=message):
        arm_angles(Markers(base.path, TIME, base.names, change(base.position)), Choices("right", roles, **choices))


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"rate": 1e9}, r"a rate must be greater than 0 and at most 10000 Hz, not 1e\+09"),
        ({"rate": float("nan")}, "a rate must be .*, not nan"),
        ({"rate": 10.0}, "a low-pass must be 0 or lie below half the rate, 5 Hz, not 8"),
    ],
)
def test_rates_and_filters_that_cannot_be_are_refused_for_what_they_are(choices: dict[str, float], message: str):
    with pytest.raises(SignalError, match=message):
        Choices(**choices)


def test_a_throw_is_cut_about_the_fastest_extension_of_the_elbow(tmp_path):
    found = arm_angles(read_markers(files_of(tmp_path)["csv"]), Choices(before=0.4, after=0.2))
    assert found.release == pytest.approx(0.9, abs=0.02)
    assert (found.time[0], found.time[-1]) == (pytest.approx(-0.4), pytest.approx(0.2))


def test_gaps_are_bridged_and_long_ones_refused():
    base = markers()
    base.position[50:55, 4] = np.nan
    roles = {name: name for name in base.names}
    found = arm_angles(base, Choices("right", roles, low_pass=0.0, before=None))
    np.testing.assert_allclose(found.angles, angles(), atol=0.02)
    base.position[60:95, 5] = np.nan
    with pytest.raises(SignalError, match=r"marker wrist is lost for 0\.36 s from 0\.59 s on"):
        arm_angles(base, Choices("right", roles, low_pass=0.0, before=None))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.trc", "hello", "has no head"),
        ("a.json", "[1", "is not JSON"),
        ("a.json", "[" * 100_000, "is not JSON"),
        ("a.json", '{"tracking": [3]}', r"frame 0 has no `data\.player`"),
        ("a.json", '{"tracking": [{"time": 0, "data": {"player": {"A": [1, 2]}}}]}', "frame 0: A is not three numbers"),
        ("a.csv", "time,a\n0,1\n1,2\n", "no markers"),
        ("a.csv", "a_x,a_y,a_z\n0,1,2\n", "no column of time"),
        ("a.csv", "time,a_x,a_y,a_z\n1,0,1,2\n0,0,1,2\n", "times must be numbers that increase"),
    ],
)  # fmt: skip
def test_files_that_cannot_be_used_are_refused_in_a_line(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(Error, match=message):
        read_markers(tmp_path / name)


def test_a_marker_that_is_missing_is_named_with_its_role(tmp_path):
    with pytest.raises(SignalError, match=r"no marker 'RSHO'; it has .*R_ELBOW.*--marker shoulder=NAME"):
        arm_angles(read_markers(files_of(tmp_path)["csv"]), Choices(markers={"shoulder": "RSHO"}))


@pytest.mark.parametrize(
    ("role", "other", "says"),
    [
        ("hand_little", "hand_thumb", "hand thumb and hand little are at the same place"),
        ("wrist", "elbow", "elbow and wrist are at the same place"),
        ("other_shoulder", "shoulder", "shoulder and other shoulder are at the same place"),
    ],
)
def test_one_marker_in_two_roles_is_refused_by_their_names(role: str, other: str, says: str):
    """Else the wrist would be written as 0 throughout."""
    base = markers()
    roles = {name: name for name in base.names} | {role: other}
    with pytest.raises(SignalError, match=says):
        arm_angles(base, Choices("right", roles, low_pass=0.0, before=None))


def test_no_marker_stands_for_two_roles_silently():
    """Of all pairs of roles; angles told from one were wrong by up to 180 degrees and more."""
    base = markers()
    for role, other in permutations(base.names, 2):
        roles = {name: name for name in base.names} | {role: other}
        with pytest.raises(SignalError, match=r"are at the same place|one marker stands for both hips"):
            arm_angles(base, Choices("right", roles, low_pass=0.0, before=None))


def test_one_marker_may_stand_for_both_hips():
    base = markers()
    points = chain(1.0)
    middle = 0.5 * (points["hip"] + points["other_hip"])
    place = [1.0, 2.0, 1.4] + middle @ np.array([FORWARD, -RIGHT, UP]).T
    both = Markers(base.path, TIME, (*base.names, "sacrum"), np.concatenate([base.position, place[:, None]], axis=1))
    roles = {name: name for name in base.names} | {"hip": "sacrum", "other_hip": "sacrum"}
    found = arm_angles(both, Choices("right", roles, low_pass=0.0, before=None))
    np.testing.assert_allclose(found.angles, angles(), atol=1e-9)


def abducted(most: float) -> Markers:
    """The arm raised sideways by up to so many degrees and a little to and fro, the trunk 0.1 rad forwards."""
    s = 0.5 - 0.5 * np.cos(2.0 * np.pi * TIME / TIME[-1])
    points = chain(1.0)
    pitch = about(RIGHT, np.full(len(TIME), -0.1))
    q = np.radians(most) * s
    upper = np.stack([-np.sin(q), -np.cos(q), 0.2 * np.sin(9.0 * TIME) * np.cos(q)], axis=1)  # x is to the left
    upper /= np.linalg.norm(upper, axis=1, keepdims=True)
    old = points["elbow"].copy()
    points["elbow"] = points["shoulder"] + 0.3 * rotate(pitch, upper)
    for name in ("wrist", "hand_thumb", "hand_little"):
        points[name] = points[name] - old + points["elbow"]
    place = np.stack([p @ np.array([FORWARD, -RIGHT, UP]).T for p in points.values()], axis=1)
    return Markers(Path("abducted"), TIME, tuple(points), place)


def test_the_trunks_lean_is_its_own_wherever_the_arm_points():
    made = abducted(75.0)
    found = arm_angles(made, Choices("right", {name: name for name in made.names}, low_pass=0.0, before=None))
    np.testing.assert_allclose(found.columns()["trunk_pitch_deg"], np.degrees(0.1), atol=1e-6)


def test_an_arm_that_points_sideways_is_refused():
    made = abducted(100.0)
    with pytest.raises(SignalError, match=r"the upper arm points sideways.*cannot be determined"):
        arm_angles(made, Choices("right", {name: name for name in made.names}, low_pass=0.0, before=None))


@pytest.mark.parametrize("word", ["inf", "-inf", "1e400"])
def test_a_marker_that_is_infinitely_far_away_is_refused_in_one_line(word, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(f"time_s,elbow_x,elbow_y,elbow_z\n0,1,2,3\n0.01,1,{word},3\n0.02,1,2,3\n")
    with pytest.raises(SignalError, match=r"infinitely far away in frame 2|no number|not a number"):
        read_markers(path)
