"""Forces of plates in C3D files are those from which their channels were made, whatever the plate's kind and axes."""

import warnings
from pathlib import Path

import ezc3d
import numpy as np
import pytest
from damaging.c3d_file import plate_channels, write_c3d

from warpmuscle.core.errors import SignalError
from warpmuscle.inverse.files import read_markers
from warpmuscle.inverse.laboratory.axes import axes_of_c3d
from warpmuscle.inverse.laboratory.c3d_plates import loads_of_c3d
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.trial import TrialWarning

FRAMES, SAMPLES, RATE = 30, 8, 100.0
ROOMS = {  # rows: the room's axes in ground axes
    "z up, y forward": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "z up, -x forward": np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
    "y up, x forward": np.eye(3),
    "-z up, x forward": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
ORIGINS = {1: [0.0, 0.0, 0.0], 2: [3.0, -2.0, -41.0], 3: [120.0, 200.0, -54.0], 4: [3.0, -2.0, -41.0]}


def stance() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force N, point m and free moment N m over all samples, in ground axes: a foot from frame 5 on."""
    phase = np.clip(np.linspace(-0.2, 1.0, FRAMES * SAMPLES), 0.0, 1.0)
    up = 800.0 * np.sin(np.pi * phase) * (1.0 + 0.3 * np.cos(4.0 * np.pi * phase))
    force = np.stack([-0.2 * up * np.cos(np.pi * phase), up, 0.05 * up], axis=1)
    zeros = np.zeros_like(up)
    point = np.stack([1.0 + 0.2 * phase, zeros + 0.005, 0.1 + 0.03 * phase], axis=1)
    return force, point, np.stack([zeros, 8.0 * np.sin(2.0 * np.pi * phase), zeros], axis=1)


def written(
    path: Path, kind: int = 2, room: str = "z up, y forward", of_foot: bool = False, offset: float = 0.0,
    zero: tuple[int, int] = (1, 0), units: str = "", turned: bool = False, belt: bool = False, **changes: object,
) -> Path:  # fmt: skip
    """A file with a walk of three points over one plate; `changes` are of FORCE_PLATFORM."""
    axes = ROOMS[room]
    force, point, moment = (one @ axes.T for one in stance())
    point, moment = 1000.0 * point, 1000.0 * moment
    first = np.array([[1.3, 0.005, 0.3], [0.8, 0.005, 0.3], [0.8, 0.005, -0.2], [1.3, 0.005, -0.2]])
    corners = 1000.0 * first[[1, 2, 3, 0] if turned else [0, 1, 2, 3]] @ axes.T
    origin = np.array(ORIGINS[kind])
    channels = plate_channels(2 if kind == 4 else kind, corners, origin, force, point, moment, of_foot)
    more: dict[str, object] = {}
    if kind == 4:  # volts, of which each force takes some of each other channel
        matrix = np.diag([100.0, 100.0, 200.0, 5e4, 5e4, 3e4]) @ (np.eye(6) + 0.02 * np.arange(36).reshape(6, 6) / 36)
        channels, more = channels @ np.linalg.inv(matrix).T, {"CAL_MATRIX": matrix[:, :, None]}
    count = channels.shape[1]
    words = {1: ["N"] * 3 + ["mm", "mm", "Nmm"], 2: ["N"] * 3 + ["Nmm"] * 3, 3: ["N"] * 8, 4: ["V"] * 6}[kind]
    own = {"USED": 1, "TYPE": np.array([kind]), "ZERO": np.array(zero), "CORNERS": corners.T[:, :, None],
           "ORIGIN": origin[:, None], "CHANNEL": (2 + np.arange(count))[:, None]} | more | changes  # fmt: skip
    time = np.arange(FRAMES) / RATE
    way = np.zeros(FRAMES) if belt else time  # of the body; on a belt the foot goes backwards
    points = np.stack(np.broadcast_arrays(way + 0.5, 1.0, 0.1), axis=1)[:, None]
    foot = np.stack(np.broadcast_arrays(way - time + 1.0, 0.1, 0.1), axis=1)[:, None]
    points = 1000.0 * np.concatenate([points, points + np.array([0.1, 0.5, 0.2]), foot], axis=1) @ axes.T
    emg = np.linspace(-1.0, 1.0, FRAMES * SAMPLES)
    return write_c3d(
        path, points, ["RHIP", "RHAND", "RHEEL"], RATE, np.column_stack([emg, channels + offset]),
        ["emg", *(f"F{k}" for k in range(count))], ["V", *([units] * count if units else words)],
        {"FORCE_PLATFORM": {k: v for k, v in own.items() if v is not None}},
        scale=[0.5] * (count + 1), offset=[3] * (count + 1),
    )  # fmt: skip


def check(loads, least: float = 21.0, rtol: float = 3e-4) -> None:
    (plate,) = loads.plates
    force, point, moment = stance()
    np.testing.assert_allclose(loads.times, np.arange(FRAMES * SAMPLES) / (RATE * SAMPLES))
    np.testing.assert_allclose(plate.force, force, atol=0.05)
    loaded = np.abs(force[:, 1]) > least
    assert loaded.sum() > 150
    np.testing.assert_allclose(plate.point[loaded], point[loaded], atol=rtol)
    np.testing.assert_allclose(plate.moment[loaded], moment[loaded], atol=0.02)
    about = plate.moment + np.cross(plate.point, plate.force)  # all of the moment, also where hardly anything acts
    np.testing.assert_allclose(about, moment + np.cross(point, force), atol=0.02)


@pytest.mark.parametrize("room", ROOMS)
def test_plates_tell_forces_and_axes_in_any_room(tmp_path, room):
    path = written(tmp_path / "walk.c3d", room=room)
    found = read_loads(path)
    check(found)
    assert found.plates[0].body is None
    up, _, ahead = room.partition(" up, ")
    assert axes_of_c3d(path) == (up, ahead.removesuffix(" forward"))
    markers = read_markers(path)
    np.testing.assert_allclose(markers.positions[0], [[0.5, 1.0, 0.1], [0.6, 1.5, 0.3], [1.0, 0.1, 0.1]], atol=1e-6)


@pytest.mark.parametrize("kind", [1, 2, 3, 4])
def test_plates_of_every_kind_tell_the_forces_as_ezc3d_does(tmp_path, kind):
    path = written(tmp_path / "walk.c3d", kind)
    plate = ezc3d.c3d(str(path), extract_forceplat_data=True)["data"]["platform"][0]
    found = loads_of_c3d(path, "z", "y")
    check(found)
    (own,) = found.plates
    loaded = np.abs(own.force[:, 1]) > 21.0
    room = ROOMS["z up, y forward"]
    for ours, theirs in ((own.force, plate["force"]), (1e3 * own.point, plate["center_of_pressure"]),
                         (1e3 * own.moment, plate["Tz"])):  # fmt: skip
        np.testing.assert_allclose((ours @ room.T)[loaded], theirs.T[loaded], atol=1e-3)


@pytest.mark.parametrize("changes", [{"of_foot": True}, {"turned": True}, {"of_foot": True, "turned": True, "kind": 3}])
def test_forces_are_those_on_the_foot_whichever_the_plate_tells_and_however_it_lies(tmp_path, changes):
    if "kind" in changes:  # half its distances change places with its edges
        changes = changes | {"ORIGIN": np.array(ORIGINS[3])[:, None]}
    check(read_loads(written(tmp_path / "walk.c3d", **changes)))


def test_a_walk_on_a_belt_goes_where_feet_come_from(tmp_path):
    path = written(tmp_path / "walk.c3d", room="z up, -x forward", belt=True)
    assert axes_of_c3d(path) == ("z", "-x")
    assert axes_of_c3d(path, up="z") == ("z", "-x")


def test_origins_without_their_sign_are_below_the_surface(tmp_path):
    check(read_loads(written(tmp_path / "walk.c3d", ORIGIN=np.array([3.0, -2.0, 41.0])[:, None])))


def test_the_baseline_is_taken_off_where_the_plate_is_empty(tmp_path):
    check(read_loads(written(tmp_path / "walk.c3d", offset=7.0, zero=(1, 4))))
    with pytest.warns(TrialWarning, match=r"\d+ N act on plate 1 in frames 12 to 18.*none is taken off"):
        check(read_loads(written(tmp_path / "late.c3d", zero=(12, 18))))


def test_two_plates_of_two_kinds_go_by_their_own_channels(tmp_path):
    both = read_loads(written(tmp_path / "walk.c3d", USED=2, TYPE=np.array([2, 2]),
                              CORNERS=np.repeat(corners_of(tmp_path), 2, axis=2),
                              ORIGIN=np.repeat(np.array(ORIGINS[2])[:, None], 2, axis=1),
                              CHANNEL=np.stack([2 + np.arange(6), 2 + np.arange(6)], axis=1)))  # fmt: skip
    assert [plate.name for plate in both.plates] == ["plate 1", "plate 2"]
    np.testing.assert_array_equal(both.plates[0].point, both.plates[1].point)


def corners_of(folder: Path) -> np.ndarray:
    content = ezc3d.c3d(str(written(folder / "corners.c3d")))
    return np.asarray(content["parameters"]["FORCE_PLATFORM"]["CORNERS"]["value"])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"TYPE": np.array([5])}, "plate 1 is of TYPE 5; those of 1 to 4 are read"),
        ({"kind": 4, "CAL_MATRIX": None}, "plate 1, of TYPE 4, needs a CAL_MATRIX of 6 x 6"),
        ({"CHANNEL": np.arange(3)[:, None]}, "plate 1, of TYPE 2, needs 6 channels, CHANNEL has 3"),
        ({"CHANNEL": (90 + np.arange(6))[:, None]}, "channel 90 of plate 1 is not there: there are 7 analog channels"),
        ({"CORNERS": np.zeros((3, 4, 1))}, "the CORNERS of plate 1 do not span a rectangle"),
        ({"CORNERS": np.full((3, 4, 1), np.nan)}, "FORCE_PLATFORM:CORNERS has something else than finite numbers"),
        ({"ORIGIN": None}, "FORCE_PLATFORM:USED says 1, but ORIGIN is of 0"),
        ({"USED": 3}, "FORCE_PLATFORM:USED says 3, but TYPE is of 1"),
        ({"USED": 0}, "has no force plates"),
    ],
)
def test_what_a_plate_lacks_is_said_in_a_line(tmp_path, changes, said):
    path = written(tmp_path / "walk.c3d", **changes)
    with pytest.raises(SignalError, match=said) as caught:
        read_loads(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"units": "V"}, "plate 1 has channels in 'V', which are taken for N and N mm"),
        (
            {"ORIGIN": np.array([3000.0, 0.0, -41.0])[:, None]},
            "centre of pressure of plate 1 lies .* m beyond its edge",
        ),
    ],
)
def test_units_and_places_that_cannot_be_right_are_warned_of(tmp_path, changes, said):
    with pytest.warns(TrialWarning, match=said):
        read_loads(written(tmp_path / "walk.c3d", **changes))


def test_files_without_plates_keep_y_up_or_what_the_screen_shows(tmp_path):
    plain = written(tmp_path / "walk.c3d", room="y up, x forward", USED=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(read_markers(plain).positions[0, 0], [0.5, 1.0, 0.1], atol=1e-6)
    assert loads_of_c3d(plain) is None
