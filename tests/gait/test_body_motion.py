"""How a body moves as a whole: centre of mass, forces, pressure, pelvis, muscles, of motions that are made up."""

import numpy as np
import pytest

from small_result import STRIDE, march, walk_scene, with_arrays
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.formats import load
from warpmuscle.gait.body_motion import (
    CADENCE_AT_SPEED,
    FORCE_AT_SPEED,
    body_measures,
    centre_of_mass,
    measured_force,
)
from warpmuscle.gait.centre_of_pressure import centre_of_pressure, travel
from warpmuscle.gait.cycles import body_weight
from warpmuscle.gait.ground_force import forward_forces
from warpmuscle.gait.likeness import dimensionless_speed, leg_length
from warpmuscle.gait.muscle_timing import beyond_chance, muscle_timing, side_and_muscle
from warpmuscle.gait.pelvis_and_trunk import segments, turn_curves
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.people.emg import MUSCLES, WINDOWS
from warpmuscle.scene.people.pinzone import PELVIS
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.ground_loads import ground_loads

STRIDES = {"left": [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0)], "right": [(0.5, 1.5), (1.5, 2.5)]}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


@pytest.fixture(scope="module")
def motion(scene: Scene) -> Recording:
    return march(scene.character, 1.2, 4.0, 801, len(scene.character.muscles))


def turned(motion: Recording, heading: float) -> Recording:
    """The same motion on another course: it goes to the left by this angle."""
    q = about([0.0, 1.0, 0.0], heading)
    arrays = {name: rotate(q, motion[name]) for name in ("com", "body_position", "foot_force_left", "foot_force_right")}
    for name in ("root_orientation", "body_orientation"):
        arrays[name] = multiply(np.broadcast_to(q, motion[name].shape), motion[name])
    return with_arrays(motion, **arrays)


@pytest.mark.parametrize("course", [0.0, 0.8, -2.4])
def test_sway_bobbing_and_fore_aft_force_are_those_along_and_across_the_course(scene, motion, course):
    beat = 2.0 * np.pi * motion.time / STRIDE
    place = motion.com + np.stack([0.025 * np.sin(beat), 0.02 * np.cos(2.0 * beat), 0.0 * beat], axis=1)
    push = np.stack([0.05 * np.cos(beat), 1.0 + 0.0 * beat, 0.025 - 0.175 * np.cos(beat)], axis=1)
    forces = {f"foot_force_{side}": body_weight(scene) * push for side in ("left", "right")}
    moved = turned(with_arrays(motion, com=place, **forces), course)
    found = centre_of_mass(moved, scene, STRIDES)
    assert found["sway of the centre of mass"] == pytest.approx(5.0, rel=0.02)
    assert found["bobbing of the centre of mass"] == pytest.approx(4.0, rel=0.02)
    assert found["maximum braking force"] == pytest.approx(0.15, rel=1e-3)
    assert found["maximum driving force"] == pytest.approx(0.2, rel=1e-3)
    np.testing.assert_allclose(forward_forces(moved, scene)["left"], push[:, 2], atol=1e-3)


def test_sway_is_beside_that_of_people_at_the_same_speed(scene, motion):
    beat = 2.0 * np.pi * motion.time / STRIDE
    place = motion.com + np.stack([0.0699 / 2.0 * np.sin(beat), 0.0 * beat, 0.0 * beat], axis=1)
    swaying = with_arrays(motion, com=place)
    slow, fast, faster = (body_measures(swaying, scene, STRIDES, v, 110.0, True) for v in (0.7, 1.6, 1.7))
    assert slow["sway from people"] == pytest.approx(0.0, abs=0.05)
    assert fast["sway from people"] == pytest.approx((6.99 - 3.85) / 1.41, abs=0.05)
    assert faster["sway from people"] is None
    assert "sway from people" not in body_measures(swaying, scene, STRIDES, 1.2, 110.0, False)


@pytest.mark.parametrize("course", [0.0, 1.1, -2.0])
def test_pelvis_and_trunk_turn_as_clinics_count(scene, motion, course):
    """Tilt forwards; up and in front where the side of the cycle is."""
    assert segments(scene) == {"Pelvis": "pelvis", "Trunk": "torso"}
    beat = 2.0 * np.pi * motion.time / STRIDE
    y, z, x = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    tilt, left_up, right_ahead = (
        np.radians(10.0 + 2.0 * np.cos(beat)),
        np.radians(4.0 * np.sin(beat)),
        0.1 * np.cos(beat),
    )
    pelvis = multiply(multiply(about(y, right_ahead), about(z, left_up)), about(x, tilt))
    whole = motion.body_orientation.copy()
    whole[:, motion.body_names.index("pelvis")] = pelvis
    moved = turned(with_arrays(motion, body_orientation=whole), course)
    curves = turn_curves(moved, scene, STRIDES)
    cycle = 2.0 * np.pi * np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(curves["Pelvis tilt"][0], 10.0 + 2.0 * np.cos(cycle), atol=0.02)
    np.testing.assert_allclose(curves["Pelvis obliquity"][0], 4.0 * np.sin(cycle), atol=0.02)
    np.testing.assert_allclose(curves["Pelvis obliquity"][1], 4.0 * np.sin(cycle), atol=0.02)  # half a stride later
    np.testing.assert_allclose(curves["Pelvis rotation"][0], -np.degrees(0.1) * np.cos(cycle), atol=0.02)
    np.testing.assert_allclose(curves["Pelvis rotation"][1], -np.degrees(0.1) * np.cos(cycle), atol=0.02)
    np.testing.assert_allclose(curves["Trunk tilt"], 0.0, atol=1e-6)


def test_people_have_their_side_up_as_it_is_loaded_and_in_front_as_it_lands():
    percent = np.array([0.0, 16.0, 50.0, 66.0])
    np.testing.assert_allclose(PELVIS["Pelvis obliquity"].mean(percent)[[1, 3]], [4.27, -4.31], atol=0.01)
    assert PELVIS["Pelvis rotation"].mean(percent)[0] == pytest.approx(4.4, abs=0.1)
    assert PELVIS["Pelvis rotation"].mean(percent)[2] < -4.5


def tilted_foot(scene: Scene, pitch: float, height: float) -> Recording:
    """The march with its left foot and toes turned about x by an angle, rad, so high over the ground."""
    motion = march(scene.character, 1.2, 1.0, 11, 0)
    q = about([1.0, 0.0, 0.0], pitch)
    place, turn = motion.body_position.copy(), motion.body_orientation.copy()
    foot, toes = (motion.body_names.index(name) for name in ("lFoot", "lToes"))
    joint = scene.character.joints["lToeJoint"]
    place[:, foot] = [0.1, height, 0.0]
    place[:, toes] = place[:, foot] + rotate(q, np.array(joint.position_in_parent) - np.array(joint.position_in_child))
    turn[:, [foot, toes]] = q
    force = np.tile([0.0, body_weight(scene), 0.0], (motion.frames, 1))
    return with_arrays(motion, body_position=place, body_orientation=turn, foot_force_left=force)


def test_pressure_is_at_the_heel_of_who_stands_on_it_at_the_toe_of_who_tiptoes_and_between_of_who_stands_flat(scene):
    at = {}
    for name, pitch in (("heel", -0.35), ("flat", 0.0), ("toe", 0.5)):
        heights = np.linspace(0.2, 0.0, 201)  # lowered until it touches, and 4 mm more
        touched = [
            k
            for k, height in enumerate(heights)
            if np.isfinite(centre_of_pressure(tilted_foot(scene, pitch, height), scene)["left"][0])
        ]
        found = centre_of_pressure(tilted_foot(scene, pitch, heights[touched[0] + 4]), scene)["left"]
        at[name] = float(found[0])
    assert at["heel"] < 15.0 < 30.0 < at["flat"] < 70.0 < 85.0 < at["toe"]


def test_nothing_is_pressed_where_the_foot_carries_nothing(scene):
    lifted = with_arrays(tilted_foot(scene, 0.0, 0.0), foot_force_left=np.zeros((11, 3)))
    assert np.isnan(centre_of_pressure(lifted, scene)["left"]).all()
    assert travel(np.array([np.nan, *np.linspace(3.0, 86.0, 20), np.nan, 5.0])).tolist() == pytest.approx([83.0])


def test_pressure_is_where_the_forces_of_the_contacts_are():
    """Against contacts computed again, with their damping, by the simulation's own stage."""
    scene = load("fwalk")
    scene.duration = 1.2
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run()
    motion = rollout.recording()
    loads = {load.body: load for load in ground_loads(motion, scene)}
    found = centre_of_pressure(motion, scene)["left"]
    foot, toes = (loads[name] for name in ("lFoot", "lToes"))
    flat = np.isfinite(found) & (motion.foot_force_left[:, 1] > 0.5 * body_weight(scene))
    whole = foot.force[:, 1] + toes.force[:, 1]
    point = (foot.force[:, 1:2] * foot.point + toes.force[:, 1:2] * toes.point) / np.maximum(whole, 1.0)[:, None]
    index = motion.body_names.index("lFoot")
    q = motion.body_orientation[:, index].astype(float)
    ahead = np.sum((point - motion.body_position[:, index]) * rotate(q, np.array([0.0, 0.0, 1.0])), axis=1)
    slope, offset = np.polyfit(ahead[flat], found[flat], 1)
    error = found[flat] - (slope * ahead[flat] + offset)
    assert 100.0 / slope == pytest.approx(0.20, abs=0.02)  # m, the foot: from -0.09 to 0.11 in its axes
    assert np.sqrt(np.mean(error**2)) < 5.0
    assert np.ptp(found[flat]) > 30.0


def test_vertical_force_and_cadence_are_beside_those_measured_at_the_same_speed(scene, motion):
    length = leg_length(scene)
    for speed in (0.9, 1.4, 1.8):
        usual = measured_force(dimensionless_speed(speed, length))
        forces = {}
        for side, first in (("left", 0.0), ("right", 0.5)):
            percent = 100.0 * ((motion.time - first) % STRIDE) / STRIDE
            force = body_weight(scene) * np.interp(percent, np.arange(101.0), usual)
            forces[f"foot_force_{side}"] = np.stack([0.0 * force, force, 0.0 * force], axis=1)
        found = body_measures(with_arrays(motion, **forces), scene, STRIDES, speed, 110.0, True)
        other = body_measures(with_arrays(motion, **forces), scene, STRIDES, 1.15, 110.0, True)
        assert found[FORCE_AT_SPEED] == pytest.approx(0.0, abs=0.01)
        assert other[FORCE_AT_SPEED] > 0.02
    assert measured_force(dimensionless_speed(2.3, length)) is None


def test_people_of_the_norm_have_their_own_cadence(scene, motion):
    """1.4 m/s at 57.9 strides a minute, of legs 0.93 m long: both scale with the square root of the leg."""
    factor = np.sqrt(leg_length(scene) / 0.932)
    found = body_measures(motion, scene, STRIDES, 1.4 * factor, 2.0 * 57.9 / factor, True)
    assert found[CADENCE_AT_SPEED] == pytest.approx(0.0, abs=0.5)
    assert measured_force(dimensionless_speed(1.4, 0.932)).max() == pytest.approx(1.21, abs=0.01)


def test_muscles_are_told_by_their_names():
    expected = {
        "lSOL": ("left", "soleus"), "soleus_r": ("right", "soleus"), "glut_max3_l": ("left", "gluteus maximus"),
        "rHAM": ("right", "hamstrings"), "vasmed_r": ("right", "vasti"), "lBIC": ("", ""), "bifemsh_l": ("", ""),
        "lat_gas_r": ("right", "gastrocnemius"), "rToeExt": ("right", "extensors of the toes"), "ercspn_l": ("", ""),
    }  # fmt: skip
    assert {name: side_and_muscle(name) for name in expected} == expected
    assert set(MUSCLES) == set(WINDOWS)


def test_timing_is_a_hundred_within_the_windows_none_for_even_and_negative_against_them():
    percent = np.linspace(0.0, 100.0, 101)
    soleus = np.where((percent >= 7.0) & (percent < 51.0), 0.5, 0.01)
    assert beyond_chance("soleus", soleus) == pytest.approx(100.0)
    assert beyond_chance("soleus", 0.5 - soleus) < -70.0
    assert beyond_chance("soleus", np.full(101, 0.3)) == 0.0
    ramp = percent / 100.0
    share = sum(range(7, 51)) / sum(range(100))
    assert beyond_chance("soleus", ramp) == pytest.approx(100.0 * (share - 0.44) / 0.56)


def test_timing_counts_both_sides_in_their_own_cycles(scene, motion):
    excitation = np.zeros((motion.frames, len(motion.muscle_names)))
    for name, first in (("lSOL", 0.0), ("rSOL", 0.5)):
        percent = 100.0 * ((motion.time - first) % STRIDE)
        excitation[:, motion.muscle_names.index(name)] = np.where((percent > 8.0) & (percent < 50.0), 0.4, 0.02)
    found = muscle_timing(with_arrays(motion, muscle_excitation=excitation), STRIDES)
    assert found["soleus"] == pytest.approx(100.0, abs=3.0)
    assert found["vasti"] == 0.0  # which does nothing
    late = muscle_timing(with_arrays(motion, muscle_excitation=np.roll(excitation, 100, axis=0)), STRIDES)
    assert late["soleus"] < -50.0
