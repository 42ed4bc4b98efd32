"""Markers and coordinates in and out of files; damaged ones are one line."""

import numpy as np
import pytest

from leg_model import leg
from recorded_markers import trc_text
from warpmuscle.core.errors import ArgumentError, Error, ResultError, SignalError
from warpmuscle.inverse.files import read_coordinates, read_markers, write_columns, write_coordinates
from warpmuscle.inverse.trial import Coordinates, Loads, Markers, Plate

TIMES = np.arange(4) / 60.0 + 1.0
PLACES = np.random.default_rng(0).uniform(-1.0, 1.0, (4, 3, 3))
HEAD = "x\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\nendheader\n"


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return leg(tmp_path_factory.mktemp("leg"))


def test_markers_keep_their_times_gaps_and_places(tmp_path):
    places = PLACES.copy()
    places[2, 1] = np.nan
    (tmp_path / "m.trc").write_text(trc_text(Markers(("a", "b", "c"), TIMES, places)))
    found = read_markers(tmp_path / "m.trc")
    assert found.names == ("a", "b", "c")
    assert found.times == pytest.approx(TIMES)
    assert np.array_equal(np.isnan(found.positions), np.isnan(places))
    assert np.nanmax(np.abs(found.positions - places)) < 1e-8


def test_names_of_markers_may_stand_once_a_column_and_the_row_of_axes_be_left_out(tmp_path):
    lines = trc_text(Markers(("a", "b", "c"), TIMES, PLACES)).splitlines()
    lines[3:6] = ["Frame#\tTime\t" + "\t".join(f"{name}_{axis}" for name in "abc" for axis in "xyz")]
    (tmp_path / "m.trc").write_text("\n".join(lines) + "\n")
    found = read_markers(tmp_path / "m.trc")
    assert found.names == ("a", "b", "c")
    assert found.positions == pytest.approx(PLACES, abs=1e-8)


def test_times_that_were_rounded_are_even_again(tmp_path):
    text = trc_text(Markers(("a", "b", "c"), TIMES, PLACES))
    for time in TIMES:
        text = text.replace(f"{time:.8f}", f"{time:.3f}")
    (tmp_path / "m.trc").write_text(text)
    assert read_markers(tmp_path / "m.trc").times == pytest.approx(TIMES, abs=1e-8)


def test_other_axes_become_those_of_the_model(tmp_path):
    turned = np.stack([PLACES[..., 2], PLACES[..., 0], PLACES[..., 1]], axis=2)  # x right, y forward, z up
    (tmp_path / "m.trc").write_text(trc_text(Markers(("a", "b", "c"), TIMES, turned)))
    found = read_markers(tmp_path / "m.trc", up="z", forward="y")
    assert np.abs(found.positions - PLACES).max() < 1e-8
    with pytest.raises(SignalError, match="two axes"):
        read_markers(tmp_path / "m.trc", up="z", forward="-z")
    with pytest.raises(SignalError, match="none of x, y, z"):
        read_markers(tmp_path / "m.trc", up="w")


def test_coordinates_come_back_from_all_kinds_of_files(scene, tmp_path):
    given = Coordinates(("flexion", "tx", "knee"), TIMES, np.random.default_rng(1).uniform(-1, 1, (4, 3)))
    for name in ("q.mot", "q.sto", "q.csv"):
        write_coordinates(tmp_path / name, given, scene)
        found = read_coordinates(tmp_path / name, scene)
        assert found.names == given.names
        assert np.abs(found.values - given.values).max() < 1e-8
    assert "inDegrees=no" in (tmp_path / "q.sto").read_text()
    with pytest.raises(ResultError, match="is written as"):
        write_coordinates(tmp_path / "q.txt", given, scene)
    with pytest.raises(Error, match="none"):
        write_columns(tmp_path / "none" / "q.mot", "t", TIMES, ("a",), np.zeros((4, 1)))


def test_paths_of_states_are_coordinates(scene, tmp_path):
    names = "time\t/jointset/hip/flexion/value\t/jointset/hip/flexion/speed\n"
    (tmp_path / "q.sto").write_text(HEAD + names + "0\t10\t3\n0.1\t20\t3\n")
    found = read_coordinates(tmp_path / "q.sto", scene)
    assert found.names == ("flexion",)
    assert found.values[:, 0] == pytest.approx(np.radians([10.0, 20.0]))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time\tflexion\tknee\n0\t1\t2\n0\t2\t3\n", "line|times must increase"),
        ("time\tflexion\tknee\n0\t1\tnan\n1\t2\t3\n", "'knee' is not a finite number"),
        ("time\tflexion\tknee\n0\t1\tx\n1\t2\t3\n", "'x' is not a number"),
        ("time\ta\tb\n0\t1\t2\n1\t2\t3\n", "no column has the name of a coordinate"),
        ("t0\tflexion\tknee\n0\t1\t2\n1\t2\t3\n", "no column of time"),
        ("time\tflexion\tflexion\n0\t1\t2\n1\t2\t3\n", "two columns give the coordinate 'flexion'"),
        ("time\tflexion\tknee\n0\t1\t2\n", "promises"),
        ("time\tflexion\tknee\n0\t1e9\t2\n1\t2\t3\n", "beyond eight turns"),
    ],
)
def test_damaged_coordinates_are_one_line(scene, tmp_path, text, message):
    (tmp_path / "q.mot").write_text(HEAD + text)
    with pytest.raises(SignalError, match=message) as error:
        read_coordinates(tmp_path / "q.mot", scene)
    assert str(error.value).startswith(str(tmp_path / "q.mot"))


def test_a_unit_that_is_not_told_is_asked_for(scene, tmp_path):
    (tmp_path / "q.sto").write_text(HEAD.replace("inDegrees=yes\n", "") + "time\tflexion\tknee\n0\t0.1\t0\n1\t0.2\t0\n")
    with pytest.raises(SignalError, match="does not tell the unit of angles"):
        read_coordinates(tmp_path / "q.sto", scene)
    assert read_coordinates(tmp_path / "q.sto", scene, degrees=False).of("flexion") == pytest.approx([0.1, 0.2])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("Units", "Unit"), "Units"),
        (("\tm\t", "\tmiles\t"), "'miles' is not known"),
        (("1.00000000", "one"), "not a number"),
        (("1.03333333", "0.5"), "increase"),
        (("a\t\t\tb", "a\t\t\ta"), "two markers are called 'a'"),
        (("1.01666667", "nan"), "increase"),
    ],
)
def test_damaged_markers_are_one_line(tmp_path, change, message):
    (tmp_path / "m.trc").write_text(trc_text(Markers(("a", "b", "c"), TIMES, PLACES)).replace(*change))
    with pytest.raises(SignalError, match=message) as error:
        read_markers(tmp_path / "m.trc")
    assert str(error.value).startswith(str(tmp_path / "m.trc"))


def test_arrays_of_trials_go_together():
    with pytest.raises(ArgumentError, match="'a' stands twice"):
        Markers(("a", "a"), TIMES, np.zeros((4, 2, 3)))
    with pytest.raises(ArgumentError, match=r"shape \(4, 1, 3\) is needed"):
        Markers(("a",), TIMES, np.zeros((3, 1, 3)))
    with pytest.raises(ArgumentError, match="infinitely far"):
        Markers(("a",), TIMES, np.full((4, 1, 3), np.inf))
    with pytest.raises(ArgumentError, match="increase"):
        Coordinates(("a",), TIMES[::-1], np.zeros((4, 1)))
    with pytest.raises(ArgumentError, match="'a' is not a finite number in frame 1"):
        Coordinates(("a",), TIMES, np.full((4, 1), np.nan))
    with pytest.raises(ArgumentError, match="no coordinate 'b'"):
        Coordinates(("a",), TIMES, np.zeros((4, 1))).of("b")
    zero = np.zeros((4, 3))
    with pytest.raises(ArgumentError, match="force of 'left' is not a finite number in frame 1"):
        Loads(TIMES, (Plate("left", None, np.full((4, 3), np.nan), zero, zero),))
