"""Moments from recordings against OpenSim's, plates found under feet, and motions and loads that do not fit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from opensim_table import table
from small_leg import loads, motion, small_leg
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse import loads as feet
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics, prepare
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.trial import Coordinates, Loads


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


def test_accelerations_of_speeds_are_slopes_of_a_spline_through_them(body):
    at = motion()
    noisy = Coordinates(at.names, at.times, at.values + 0.002 * np.random.default_rng(2).normal(size=at.values.shape))
    wanted = at.times[3:30:4] + 0.003
    found = prepare(body, noisy, None, None, wanted, of_speeds=True)
    knee = at.names.index("knee_angle")
    natural = ([(3, 0.0), (4, 0.0)],) * 2
    speeds = make_interp_spline(at.times, noisy.values[:, knee], k=5, bc_type=natural)(at.times, nu=1)
    own = int(body.map.speed[body.map.names.index("knee_angle")])
    slopes = make_interp_spline(at.times, speeds, k=5, bc_type=natural)(wanted, nu=1)
    assert found.of_speeds.states.rates[:, own] == pytest.approx(slopes, rel=1e-9)
    assert np.abs(found.states.rates[:, own] - slopes).max() > 0.05 * np.abs(slopes).max()
    assert found.of_speeds.states.speeds is found.states.speeds
    assert prepare(body, noisy, None, None, wanted).of_speeds.speed_rates is None


def test_moments_of_a_filtered_walk_are_those_of_opensim(reference_data):
    folder = reference_data / "opensim_walk"
    body = BodyModel(folder / "subject01.osim", "cpu")
    coordinates = read_coordinates(folder / "ik" / "subject01_walk_IK.mot", body.scene)
    found = inverse_dynamics(body, coordinates, read_loads(folder / "subject01_walk_grf.xml"), filter=6.0)
    _, names, rows = table(folder / "id" / "subject01_walk_ID.sto")
    for name, unit in zip(found.names, found.units, strict=True):
        theirs = rows[:, names.index(f"{name}_{'moment' if unit == 'N m' else 'force'}")]
        assert np.abs(np.interp(rows[:, 0], found.times, found.of(name)) - theirs).max() < 1e-3 * np.abs(theirs).max()


@pytest.mark.parametrize("subject", ["subject01", "subject02"])
def test_moments_of_a_synthetic_walk_but_for_its_toes(reference_data, subject):
    """The reference moved toes and kept kneecaps still; the model's toes are welded, its kneecaps follow the knees."""
    folder = reference_data / "inverse" / "synthetic_walk" / subject
    body = BodyModel(folder / f"{subject}.osim", "cpu")
    text = (folder / "coordinates.sto").read_text().partition("endheader")[2].split("\n")
    values = np.array([[float(word) for word in line.split()] for line in text[2:] if line.strip()])
    coordinates = Coordinates(tuple(text[1].split()[1:]), values[:, 0], values[:, 1:])
    found = inverse_dynamics(body, coordinates, read_loads(folder / "grf.mot"))  # the file names no bodies
    _, names, rows = table(folder / "id.sto")
    for name in found.names[found.residuals :]:
        theirs = rows[:, names.index(f"{name}_moment")]
        above = name.startswith(("arm", "elbow", "pro", "lumbar"))
        most = 1e-5 if above else 0.04
        assert np.abs(found.of(name) - theirs).max() < most * np.abs(theirs).max(), name


def test_a_plate_without_a_body_is_under_the_nearer_foot(body, monkeypatch):
    at = motion()
    bodies = body.topology.bodies
    monkeypatch.setattr(feet, "_feet", lambda _: [bodies.index("pelvis"), bodies.index("calcn_r")])
    states = prepare(body, at, None, None, None).states
    own = loads(at.times, None)
    for name in ("pelvis", "calcn_r"):
        place = (feet._places(body, states, slice(0, 40))[:, bodies.index(name)] @ TO_OPENSIM.T).mean(axis=0)
        plate = replace(own.plates[0], point=np.tile(place * [1.0, 0.0, 1.0], (len(own.times), 1)))
        guessed, told = (
            inverse_dynamics(body, at, Loads(own.times, (replace(plate, body=one),))) for one in (None, name)
        )
        assert guessed.values == pytest.approx(told.values)


def test_plates_without_bodies_ask_for_feet_of_known_names(body):
    with pytest.raises(ArgumentError, match="say in the loads which body"):
        inverse_dynamics(body, motion(), loads(motion().times, None))


def test_frames_that_are_wanted_come_from_splines_through_all(body):
    at = motion()
    whole = inverse_dynamics(body, at, loads(at.times))
    some = inverse_dynamics(body, at, loads(at.times), times=at.times[10:30:4])
    assert some.values == pytest.approx(whole.values[10:30:4], rel=1e-5, abs=1e-4)


def test_units_and_residuals_are_told(body):
    found = inverse_dynamics(body, motion(10))
    assert found.residuals == 6
    assert dict(zip(found.names, found.units, strict=True))["pelvis_ty"] == "N"
    with pytest.raises(ArgumentError, match="no coordinate 'knee'"):
        found.of("knee")


def _scaled(one: Coordinates, factor: float) -> Coordinates:
    return replace(one, values=one.values * factor)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda at, own: (_scaled(at, 57.3), own), "is the motion in degrees"),
        (lambda at, own: (replace(at, names=tuple("abcdefghijk")), own), "0 of the model's 11 coordinates"),
        (lambda at, own: (at, replace(own, times=own.times + 60.0)), "the loads reach from 59.95"),
        (lambda at, own: (at, Loads(own.times, (replace(own.plates[0], body="toes"),))), "acts on 'toes'"),
        (lambda at, own: ([at, at], [own]), "loads of 1 trial"),
        (lambda at, own: ([], None), "no trials"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_in_a_line(body, change, words):
    coordinates, own = change(motion(20), loads(motion(20).times))
    with pytest.raises(ArgumentError, match=words) as error:
        inverse_dynamics(body, coordinates, own)
    assert "\n" not in str(error.value)


def test_a_cut_off_beyond_half_the_rate_and_times_beyond_the_motion_are_refused(body):
    with pytest.raises(ArgumentError, match="cut-off"):
        inverse_dynamics(body, motion(20), filter=80.0)
    with pytest.raises(ArgumentError, match="within the motion"):
        inverse_dynamics(body, motion(20), times=np.array([0.0, 9.0]))


def test_a_coordinate_that_a_motion_lacks_stays_where_the_model_has_it(body):
    at = motion(10)
    keep = [k for k, name in enumerate(at.names) if name != "ankle_angle"]
    with pytest.warns(UserWarning, match="lacks ankle_angle, which stays"):
        trials = prepare(
            body, Coordinates(tuple(at.names[k] for k in keep), at.times, at.values[:, keep]), None, None, None
        )
    assert not trials.values[:, at.names.index("ankle_angle")].any()
