"""The same motion is read from files as other people write them: headings, units, gaps, times and turns."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.synergy.columns import plain_name
from warpmuscle.throw.motion import ArmMotion
from warpmuscle.throw.recordings.motion_files import read

JOINTS = ("shoulder", "elbow")
TIME = np.arange(0.0, 1.001, 0.01)
SHOULDER, ELBOW, UP = 20.0 + 120.0 * TIME**2, 100.0 - 85.0 * TIME**2, 1.4 + 0.1 * TIME  # deg, deg, m
HEADER = "time_s,shoulder_deg,elbow_deg,shoulder_up_m"


def written(header: str, *columns: np.ndarray, form: str = "%.6f") -> str:
    rows = [",".join("" if np.isnan(value) else form % value for value in row) for row in np.column_stack(columns)]
    return "\n".join([header, *rows]) + "\n"


def motion(tmp_path: Path, text: str | bytes, suffix: str = ".csv") -> ArmMotion:
    path = tmp_path / f"throw{suffix}"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read(path, JOINTS)[0]


def storage(degrees: str, *columns: np.ndarray) -> str:
    head = f"throw\nversion=1\nnRows={len(TIME)}\nnColumns=3\ninDegrees={degrees}\nendheader\n"
    return head + written("time,shoulder,elbow", TIME, *columns).replace(",", "\t")


PLAIN = written(HEADER, TIME, SHOULDER, ELBOW, UP)
RADIANS = np.radians([SHOULDER, ELBOW])


@pytest.mark.parametrize(
    "text",
    [
        PLAIN.replace(",", ";").replace(".", ","),
        PLAIN.replace(",", "\t").replace(".", ","),
        PLAIN.encode("utf-16"),
        PLAIN.replace("\n", "\r\n").encode("utf-8-sig"),
        written("Time [ms],Shoulder flexion (°),Elbow (deg),Shoulder up [mm]", 1e3 * TIME, SHOULDER, ELBOW, 1e3 * UP),
        written("T,SHOULDER-FLEXION-ANGLE (rad),elbow angle [radians],shoulder_up_cm", TIME, *RADIANS, 100.0 * UP),
        written(HEADER, TIME + 12.3, (SHOULDER + 240.0) % 360.0 - 240.0, ELBOW - 720.0, UP),
    ],
    ids=["decimal commas", "tabs and decimal commas", "UTF-16", "BOM and CRLF", "units", "words", "turns"],
)
def test_files_of_others_hold_the_same_motion(tmp_path: Path, text: str | bytes):
    found = motion(tmp_path, text)
    np.testing.assert_allclose(found.angles, RADIANS.T, atol=1e-6)
    np.testing.assert_allclose(found.place[:, 1], UP, atol=1e-6)
    np.testing.assert_allclose(found.time, TIME, atol=1e-9)


def test_commas_that_may_be_of_thousands_are_not_taken_for_decimal_ones(tmp_path: Path):
    text = "time;shoulder;elbow\n" + "".join(f"{k};1,{k + 100};2\n" for k in range(20))
    with pytest.raises(Error, match="'1,100' is not a number"):
        motion(tmp_path, text)


def test_storage_files_say_how_many_rows_they_have_and_in_what_unit(tmp_path: Path):
    for degrees, columns in (("yes", np.degrees(RADIANS)), ("no", RADIANS)):
        np.testing.assert_allclose(motion(tmp_path, storage(degrees, *columns), ".mot").angles, RADIANS.T, atol=1e-6)
    small = motion(tmp_path, storage("yes", 0.02 * SHOULDER, 0.02 * ELBOW), ".mot")
    np.testing.assert_allclose(small.angles, 0.02 * RADIANS.T, atol=1e-7)  # deg, though they would do as radians
    with pytest.raises(Error, match=r"'shoulder': goes up to 140 where the header says inDegrees=no"):
        motion(tmp_path, storage("no", SHOULDER, ELBOW), ".mot")
    with pytest.raises(Error, match="promises nRows=101, but there are 100"):
        motion(tmp_path, storage("yes", *RADIANS).rstrip().rsplit("\n", 1)[0], ".mot")


def test_short_gaps_are_bridged_and_counted_and_long_ones_refused_with_their_line(tmp_path: Path):
    elbow = ELBOW.copy()
    elbow[40:43] = np.nan
    text = written(HEADER, TIME, SHOULDER, elbow, UP)
    for found in (motion(tmp_path, text), motion(tmp_path, text.replace(",,", ",NaN,"))):
        np.testing.assert_allclose(found.angles, RADIANS.T, atol=1e-4)
        assert found.bridged == 3
    elbow[40:60] = np.nan
    with pytest.raises(Error, match=r"throw\.csv:42: column 'elbow_deg'.* for 0\.21 s; up to 0\.06 s are bridged"):
        motion(tmp_path, written(HEADER, TIME, SHOULDER, elbow, UP))
    elbow[:] = [np.nan, *ELBOW[1:]]
    with pytest.raises(Error, match=r"throw\.csv:2: column 'elbow_deg': the value is nan"):
        motion(tmp_path, written(HEADER, TIME, SHOULDER, elbow, UP))


@pytest.mark.parametrize(("rate", "decimals"), [(60.0, 2), (120.0, 3), (240.0, 3), (30.0, 2), (59.94, 3)])
def test_rounded_times_are_made_even(tmp_path: Path, rate: float, decimals: int):
    time = np.arange(0.0, 1.001, 1.0 / rate)
    text = "".join(f"{t:.{decimals}f},{140.0 * t:.6f},{90.0 * t:.6f}\n" for t in time)
    found = motion(tmp_path, "time,shoulder,elbow\n" + text)
    assert np.abs(found.time - time).max() < 0.3 * 10.0**-decimals
    np.testing.assert_allclose(np.diff(found.time), 1.0 / rate, rtol=2e-3)


@pytest.mark.parametrize("missing", [[40], [40, 41, 42], [20, 50, 80]])
def test_times_with_samples_missing_stay_as_they_are(tmp_path: Path, missing: list[int]):
    left = np.delete(TIME, missing)
    text = "".join(f"{t:.2f},{140.0 * t:.6f},{90.0 * t:.6f}\n" for t in left)
    np.testing.assert_allclose(motion(tmp_path, "time,shoulder,elbow\n" + text).time, left, atol=1e-12)


@pytest.mark.parametrize(
    ("header", "columns", "message"),
    [
        ("frame,shoulder,elbow", (TIME, SHOULDER, ELBOW), "name one `time_s`; the columns are frame, shoulder, elbow"),
        ("time,arm_flex_r,elbow", (TIME, SHOULDER, ELBOW), "`shoulder_deg`; the columns are time, arm_flex_r, elbow"),
        ("time,shoulder,elbow", (1e3 * TIME, SHOULDER, ELBOW), "milliseconds `time_ms`"),
        ("time,shoulder,elbow", (np.round(TIME, 1), SHOULDER, ELBOW), "0 s stands twice; are times rounded"),
        (HEADER, (TIME, SHOULDER, ELBOW, 1e3 * UP), "moves at up to 100 m/s; if it is in mm"),
        (
            f"{HEADER},trunk_pitch_deg,shoulder_flexion_gravity_deg",
            (TIME, SHOULDER, ELBOW, UP, 0.0 * TIME, SHOULDER - 30.0),
            "which is how far the trunk leans forwards; leave one",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused_in_a_line_that_says_what_to_do(
    tmp_path: Path, header: str, columns: tuple[np.ndarray, ...], message: str
):
    with pytest.raises(Error, match="throw") as error:
        motion(tmp_path, written(header, *columns))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_row_of_units_and_a_title_above_the_names_are_told_to_be_comments(tmp_path: Path):
    with pytest.raises(Error, match="'s' is not a number; write # before a row of units"):
        motion(tmp_path, PLAIN.replace("\n", "\ns,deg,deg,m\n", 1))
    with pytest.raises(Error, match="has 1 cell where the header names 3 columns; write # before lines above"):
        motion(tmp_path, f"Throw of Monday\n{PLAIN}")
    assert len(motion(tmp_path, f"# Throw of Monday\n{PLAIN}".replace("_m\n", "_m\n# s,deg,deg,m\n", 1)).time) == 101


@pytest.mark.parametrize(
    ("heading", "name"),
    [("Elbow Flexion [deg]", "elbow_flexion_deg"), (" time ", "time"), ("", ""), ("()", "()"), ("[", "["), ("(m)", "m"),
     ("a[b](c)", "a[b]_c"), ("_x_", "x"), ("\u00a0wrist\u2003(°)", "wrist_deg")],
)  # fmt: skip
def test_headings_of_any_kind_have_plain_names(heading: str, name: str):
    assert plain_name(heading) == name
