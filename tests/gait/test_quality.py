"""Measures of walks that are made up: angles and forces of the norms, headings that turn, speeds that are asked for."""

import msgspec
import numpy as np
import pytest

from small_result import STRIDE, march, walk_result, walk_scene, with_arrays
from warpmuscle.core.pose import about
from warpmuscle.formats import load
from warpmuscle.gait import quality
from warpmuscle.gait.cycles import PERCENT, body_weight, steady_strides
from warpmuscle.gait.foot_contact import Support
from warpmuscle.gait.foot_sliding import FootSliding
from warpmuscle.gait.measure_names import can_be_measured, measure_names
from warpmuscle.gait.quality import TIMING, aimed_speed, gait_measures, runs
from warpmuscle.gait.table import gait_table, human, unit_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene, SearchStage
from warpmuscle.scene.masses import at_common_tension, body_mass, common_mass
from warpmuscle.scene.norms import NORMS
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.people.fukuchi import RUN, gained_by_speed
from warpmuscle.scene.people.pinzone import MOMENTS
from warpmuscle.simulation.rollout import Rollout

STANCE = 63.0  # % of the cycle; the norm's toe-off is at 64
JOINTS = {"Hip flexion": ("Hip", -1.0), "Knee flexion": ("Knee", 1.0), "Ankle dorsiflexion": ("Ankle", -1.0)}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


def normal_walk(scene: Scene, away: float = 0.0) -> Recording:
    """A march whose legs move as the norms do, all curves of loaded legs so many half-widths above them."""
    motion = march(scene.character, 1.2, 4.0, 801, len(scene.character.muscles))
    turned, forces = motion.joint_orientation.copy(), {}
    for side in ("left", "right"):
        cycle = 100.0 * ((motion.time - (0.0 if side == "left" else 0.5 * STRIDE)) % STRIDE) / STRIDE
        for name, (joint, sign) in JOINTS.items():
            angle = np.radians(sign * (NORMS[name].mean(cycle) + away * NORMS[name].half_width))
            turned[:, motion.joint_names.index(side[0] + joint)] = about([1.0, 0.0, 0.0], angle)
        norm = NORMS["Vertical ground force"]
        mean = norm.mean(cycle)
        loaded = cycle < STANCE
        force = np.where(loaded, np.maximum(mean, 0.04) + away * norm.half_width, 0.0) * body_weight(scene)
        forces[f"foot_force_{side}"] = np.stack([0.0 * force, force, 0.0 * force], axis=1)
    velocity = np.tile([0.0, 0.0, 1.27], (len(motion.time), 1))  # the speed of the norms
    return with_arrays(motion, joint_orientation=turned, com_velocity=velocity, **forces)


def test_how_straight_a_knee_gets_counts_from_the_first_steady_stride(scene: Scene):
    motion = normal_walk(scene)
    begin = min(strides[0][0] for strides in steady_strides(motion, scene).values())
    turned, early = motion.joint_orientation.copy(), motion.time < begin - 0.1
    assert early.any()
    turned[early, motion.joint_names.index("lKnee")] = about([1.0, 0.0, 0.0], np.radians(-40.0))
    found = gait_measures(with_arrays(motion, joint_orientation=turned), scene)
    assert found["knee, minimum"] == pytest.approx(gait_measures(motion, scene)["knee, minimum"])


def test_a_walk_on_the_norms_has_their_key_points_and_does_not_deviate(scene: Scene):
    found = gait_measures(normal_walk(scene), scene)
    for name in ("hip", "knee", "ankle", "three angles", "ground force"):
        assert found[f"deviation of the {name}"] == pytest.approx(0.0, abs=0.15)
    expected = {
        "hip, minimum": (-8.3, 52), "hip, maximum": (33.7, 87), "knee, maximum in stance": (19.4, 12),
        "knee, maximum in swing": (63.4, 72), "ankle, maximum in stance": (12.5, 43),
        "ankle, minimum at push-off": (-19.9, 64), "first hump of the force": (1.05, 15),
        "valley of the force": (0.80, 31), "second hump of the force": (1.14, 49),
    }  # fmt: skip
    for name, (value, percent) in expected.items():
        assert found[name] == pytest.approx(value, abs=0.03 if "force" in name else 0.2), name
        assert found[f"{name} at"] == pytest.approx(percent, abs=1.5), name
    assert found["knee, minimum"] == pytest.approx(3.8, abs=0.2)
    assert found["knee flexion within the norm band"] == 100.0
    assert found["stance"] == pytest.approx(STANCE, abs=0.5)
    assert found["double support"] == pytest.approx(2.0 * STANCE - 100.0, abs=1.0)
    assert found["flight"] == 0.0
    assert found["angles outside the norms"] == pytest.approx(0.0, abs=0.08)
    assert found["angles outside the norms as published"] == pytest.approx(0.0, abs=0.02)
    assert found["angles from key points"] == pytest.approx(0.0, abs=0.1)
    assert 0.5 < found["angles from Fukuchi 2018"] < 1.2  # the norms are that far from each other


WINDOWS = {  # % of the cycle within which each key point is looked for
    "hip, minimum": (20, 80), "hip, maximum": (50, 100), "knee, maximum in stance": (2, 45),
    "knee, maximum in swing": (45, 100), "ankle, maximum in stance": (8, 62), "ankle, minimum at push-off": (45, 85),
}  # fmt: skip


@pytest.mark.parametrize("key", WINDOWS)
def test_key_points_are_looked_for_in_their_part_of_the_cycle(key: str):
    (_, find, *window), sign = quality.KEY_POINTS[key], -1.0 if "minimum" in key else 1.0
    low, high = WINDOWS[key]
    for percent in (low + 3, high - 3, low - 3, high + 3):
        if 0 < percent < 100:
            found = find(sign * 30.0 * np.exp(-(((PERCENT - percent) / 1.5) ** 2)), *window)
            there = found is not None and abs(found.percent - percent) < 0.6 and abs(found.value) > 25.0
            assert there is (low < percent < high), percent


def test_slides_are_told_in_centimetres_and_depths_in_millimetres(scene: Scene, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(quality, "foot_sliding", lambda *_: FootSliding(0.01, 0.02, 0.03, 0.004))
    found = gait_measures(normal_walk(scene), scene)
    assert [found[name] for name in ("slide of the stance foot", "maximum slide of the stance foot")] == [1.0, 2.0]
    assert (found["drag of the trailing foot"], found["depth of the feet"]) == (3.0, 4.0)


def test_a_cycle_begins_where_the_foot_lands_and_not_where_the_controller_changes_its_stance(scene: Scene):
    motion = normal_walk(scene)
    early = with_arrays(motion, stance=np.roll(motion.stance, -9))
    assert gait_measures(early, scene) == gait_measures(motion, scene)


def test_a_gait_with_flight_or_of_a_scene_that_means_a_run_is_judged_as_running(scene: Scene):
    motion = normal_walk(scene)
    meant = msgspec.structs.replace(scene, objective=Objective(gait="run"))
    cycle = (motion.time / STRIDE) % 1.0
    flying = {
        f"foot_force_{side}": np.outer((cycle - first) % 1.0 < 0.4, [0.0, 1800.0, 0.0])
        for side, first in (("left", 0.0), ("right", 0.5))
    }
    walking, running = gait_measures(motion, scene), gait_measures(motion, meant)
    flown = gait_measures(with_arrays(motion, **flying), scene)
    for found in (running, flown):
        assert found["angles from Fukuchi 2017"] == found["angles outside the norms"] > 1.5
        assert found["angles outside the norms as published"] == found["angles outside the norms"]  # below 2.5 m/s
        assert found["deviation of the ground force"] is None
        assert "angles from key points" not in found
        assert TIMING not in found  # people's muscles are known of walking only
    assert TIMING in walking
    assert flown["flight"] == pytest.approx(20.0, abs=2.0)
    assert "angles from Fukuchi 2017" not in walking
    walk_of_flight = msgspec.structs.replace(scene, objective=Objective(gait="walk"))
    assert "angles from key points" in gait_measures(with_arrays(motion, **flying), walk_of_flight)
    assert human("stance", running=True) == ("40", "Fukuchi 2017")


@pytest.mark.parametrize(("speed", "apart"), [(2.5, 0.0), (3.5, 0.7), (4.5, 0.7)])
def test_a_run_is_compared_with_people_who_run_as_fast(scene: Scene, speed: float, apart: float):
    """Whose angles at 3.5 m/s are 0.7 standard deviations from those at 2.5 m/s, as published."""
    walk = normal_walk(scene)
    running, turned = msgspec.structs.replace(scene, objective=Objective(gait="run")), walk.joint_orientation.copy()
    for side, begin in (("l", 0.0), ("r", 0.5 * STRIDE)):
        cycle = 100.0 * ((walk.time - begin) % STRIDE) / STRIDE
        for name, (joint, sign) in JOINTS.items():
            angle = RUN[name].mean(cycle) + gained_by_speed(name, cycle, speed)
            turned[:, walk.joint_names.index(side + joint)] = about([1.0, 0.0, 0.0], np.radians(sign * angle))
    velocity = np.tile([0.0, 0.0, speed], (len(walk.time), 1))
    found = gait_measures(with_arrays(walk, joint_orientation=turned, com_velocity=velocity), running)
    assert found["angles outside the norms"] == pytest.approx(0.0, abs=0.1)
    assert found["angles outside the norms as published"] == pytest.approx(apart, abs=0.08)


def test_a_walk_at_the_edges_of_the_bands_deviates_by_one(scene: Scene):
    found = gait_measures(normal_walk(scene, away=1.0), scene)
    for name in ("hip", "knee", "ankle", "three angles"):
        assert found[f"deviation of the {name}"] == pytest.approx(1.0, abs=0.06)
    assert found["deviation of the ground force"] == pytest.approx(STANCE / 100.0, abs=0.06)


def test_a_slow_or_backward_walk_is_not_measured_by_norms(scene: Scene):
    backward = normal_walk(scene)
    found = gait_measures(with_arrays(backward, com_velocity=0.0 * backward.com_velocity), scene)
    assert found["deviation of the hip"] is None
    assert found["hip flexion within the norm band"] is None
    assert found["cost of transport"] is None
    assert found["metabolic power"] is not None
    assert TIMING not in found


def test_legs_that_are_bent_where_their_angles_are_zero_are_not_measured_by_norms_of_people(scene: Scene):
    joints = dict(scene.character.joints)
    for name in ("lAnkle", "rAnkle"):
        x, y, z = joints[name].position_in_parent
        joints[name] = msgspec.structs.replace(joints[name], position_in_parent=(x, y, z - 0.4))
    crouched = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, joints=joints))
    found = gait_measures(normal_walk(scene), crouched)
    assert "angles outside the norms" not in found
    assert found["deviation of the knee"] is None
    assert found["knee, maximum in swing"] is not None


@pytest.mark.parametrize(("flight", "running"), [(0.0, False), (0.9, False), (1.1, True), (1.2, True), (30.0, True)])
def test_a_gait_runs_whose_feet_are_both_off_the_ground_for_more_than_a_percent(
    scene: Scene, flight: float, running: bool
):
    assert runs(scene, Support(50.0, 0.0, flight)) is running
    assert runs(msgspec.structs.replace(scene, objective=Objective(gait="run")), Support(60.0, 20.0, 0.0))


def test_a_heading_that_turns_evenly_drifts_from_the_first_cycle_to_the_last(scene: Scene):
    motion = normal_walk(scene)
    motion = with_arrays(motion, root_orientation=about([0.0, 1.0, 0.0], np.radians(6.0) * motion.time))
    found = gait_measures(motion, scene)
    assert found["drift of the heading"] == pytest.approx(6.0 * STRIDE, abs=0.2)  # of two cycles
    assert found["maximum error of the heading"] == pytest.approx(6.0 * 3.5, abs=0.2)


def percent_of(time: np.ndarray, side: str) -> np.ndarray:
    """Percent of the gait cycle of a leg in the walk above."""
    return 100.0 * ((time - (0.0 if side == "left" else 0.5 * STRIDE)) % STRIDE) / STRIDE


def with_moments(scene: Scene, moments: dict, speeds: dict) -> Recording:
    """The walk with internal moments, N m/kg, of extensors and plantarflexors by percent, and speeds about x, rad/s."""
    motion = normal_walk(scene)
    torque, speed = 0.0 * motion.joint_torque, 0.0 * motion.joint_angular_velocity
    for side in ("left", "right"):
        for name, (joint, sign) in JOINTS.items():
            index = motion.joint_names.index(side[0] + joint)
            of_cycle = moments[name](percent_of(motion.time, side))
            torque[:, index, 0] = sign * body_mass(scene.character) * of_cycle  # on the parent; x points to the left
            speed[:, index, 0] = speeds[name]
    still = 0.0 * motion.body_orientation + [0.0, 0.0, 0.0, 1.0]
    return with_arrays(motion, joint_torque=torque, joint_angular_velocity=speed, body_orientation=still)


def test_moments_and_powers_are_read_where_people_have_most(scene: Scene):
    moments = {
        "Hip flexion": lambda percent: 1.0 - np.abs(percent - 40.0) / 50.0,
        "Knee flexion": lambda percent: 0.6 - np.maximum(np.abs(percent - 48.0) - 4.0, 0.0) / 100.0,
        "Ankle dorsiflexion": lambda percent: 1.2 - np.abs(percent - 50.0) / 50.0,
    }
    extending = {"Hip flexion": 1.0, "Knee flexion": -2.0, "Ankle dorsiflexion": 3.0}  # rad/s, about x
    found = gait_measures(with_moments(scene, moments, extending), scene)
    expected = {
        "hip moment in loading": 0.5, "knee moment in loading": 0.31, "knee moment before push-off": 0.6,
        "ankle moment, maximum": 1.2, "hip power, maximum": 1.0, "knee power, maximum": 1.2,
        "ankle power, maximum": 3.6,
    }  # fmt: skip
    assert {name: found[name] for name in expected} == pytest.approx(expected, abs=0.03)


def test_moments_of_people_are_theirs_and_a_deviation_away_from_them_is_one(scene: Scene):
    def away(deviations: float) -> dict:
        def of(name: str):
            norm = MOMENTS[name]
            return lambda percent: norm.mean(percent) + deviations * norm.sd(np.arange(101.0)).mean()

        moments = {name: of(f"{joint} moment") for name, (joint, _) in JOINTS.items()}
        return gait_measures(with_moments(scene, moments, dict.fromkeys(JOINTS, 0.0)), scene)

    people, others = away(0.0), away(1.0)
    for joint in ("hip", "knee", "ankle"):
        assert people[f"{joint} moment from people"] == pytest.approx(0.0, abs=0.08)
        assert others[f"{joint} moment from people"] == pytest.approx(1.0, abs=0.08)
        assert people[f"likeness of the {joint} moment"] == pytest.approx(1.0, abs=0.01)
        assert others[f"likeness of the {joint} moment"] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_sway_bobbing_and_fore_aft_force_are_told_along_the_way(scene: Scene, yaw: float):
    motion, (sin, cos) = normal_walk(scene), (np.sin(yaw), np.cos(yaw))
    phase, forces = 2.0 * np.pi * motion.time / STRIDE, {}
    aside = 0.02 * np.sin(phase) + 0.05 * motion.time  # walks aside, too
    com = np.stack([cos * aside, 0.9 + 0.015 * np.cos(2.0 * phase), -sin * aside], axis=1)
    for side in ("left", "right"):
        percent = percent_of(motion.time, side)
        braking, driving = (np.sin(np.pi * (percent - begin) / 30.0) for begin in (0.0, 30.0))
        along = np.where(percent < 30.0, -0.2 * braking, np.where(percent < 60.0, 0.25 * driving, 0.0))
        along *= body_weight(scene)
        force = motion[f"foot_force_{side}"].copy()
        force[:, 0], force[:, 2] = sin * along, cos * along
        forces[f"foot_force_{side}"] = force
    turned = np.tile(about([0.0, 1.0, 0.0], yaw), (len(motion.time), 1))
    found = gait_measures(with_arrays(motion, com=com, root_orientation=turned, **forces), scene)
    expected = {
        "sway of the centre of mass": 4.0, "bobbing of the centre of mass": 3.0, "maximum braking force": 0.2,
        "maximum driving force": 0.25,
    }  # fmt: skip
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=0.02)


def test_cost_at_a_common_tension_is_that_of_the_scene_with_such_muscles(scene: Scene):
    motion, common = normal_walk(scene), at_common_tension(scene)
    found, other = gait_measures(motion, scene), gait_measures(motion, common)
    assert found["cost of transport at 0.25 MPa"] == pytest.approx(other["cost of transport"], rel=1e-5)
    assert found["cost of transport"] == pytest.approx(found["metabolic power"] / 1.27, rel=1e-5)
    assert other["muscle mass"] == pytest.approx(common_mass(list(scene.character.muscles.values())))
    assert found["cost of transport"] < found["cost of transport at 0.25 MPa"]


def test_a_speed_counts_as_asked_for_if_the_objective_or_a_stage_says_so(scene: Scene):
    def aimed(objective: Objective, *stages: SearchStage) -> float | None:
        return aimed_speed(msgspec.structs.replace(scene, objective=objective, stages=list(stages)))

    assert aimed(Objective()) is None
    assert aimed(Objective(speed=2.0)) == 1.0
    assert aimed(Objective(stride_speed=2.0)) == 1.0
    assert aimed(Objective(target_speed=1.25)) == 1.25
    assert aimed(Objective(), SearchStage("a", objective={"speed": 3.0})) == 1.0
    fast = msgspec.structs.replace(scene, objective=Objective(speed=1.0, target_speed=1.25))
    motion = normal_walk(scene)
    found = gait_measures(with_arrays(motion, com_velocity=0.0 * motion.com_velocity + [0.0, 0.0, 1.2]), fast)
    assert found["error of the speed"] == pytest.approx(-0.05)


def test_every_measure_has_a_unit_and_a_torque_driven_walk_has_none_of_muscles(scene: Scene):
    muscles = gait_measures(normal_walk(scene), scene)
    torques = gait_measures(
        walk_result("fwalk").replays[0], substitute(walk_scene("fwalk"), start_values(walk_scene("fwalk")))
    )
    rows = {row.name: row for row in gait_table([torques, muscles])}
    assert all(row.unit for row in rows.values())
    for name in ("cost of transport", "share of passive force", "mean activation"):
        assert rows[name].values[0] is None
        assert rows[name].values[1] is not None


def test_every_measure_of_a_walk_is_known_by_name_and_every_name_is_of_a_walk(scene: Scene):
    torques = substitute(walk_scene("fwalk"), start_values(walk_scene("fwalk")))
    found = gait_measures(normal_walk(scene), scene) | gait_measures(walk_result("fwalk").replays[0], torques)
    given = {name for name in found if not name.endswith((" at", "norm band", "target speed"))}
    assert not [name for name in given if not can_be_measured(name)]
    others = {name for name in measure_names() if not name.startswith("timing of ")} - given
    of_others = {
        "angles from Fukuchi 2017",
        "gastrocnemius in swing, of stance",
    }  # of a run, of bodies with that muscle
    assert others == of_others


def test_what_humans_have_is_read_off_the_norms():
    assert human("knee, maximum in swing") == ("63.4 ± 5.3", "norm curves in SCONE Studio")
    assert human("knee, maximum in swing at")[0] == "72"
    assert human("depth of the valley")[0] == "0.25"
    assert human("stance")[0] == "64"
    assert human("depth of the feet") == ("", "")
    assert (unit_of("hip, minimum at"), unit_of("hip, minimum")) == ("% of the cycle", "deg")


def test_toe_off_and_flight_are_the_same_at_any_frame_rate_but_for_a_frame():
    scene = load("fjog")
    scene = msgspec.structs.replace(substitute(scene, start_values(scene)), duration=6.0)
    found = {}
    for rate in (500.0, 100.0, 50.0):
        rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=rate)
        rollout.run()
        found[rate] = gait_measures(rollout.recording(), scene)
    fine = found[500.0]
    assert fine["stance"] == pytest.approx(43.3, abs=0.5)
    assert fine["flight"] == pytest.approx(100.0 - 2.0 * fine["stance"], abs=0.5)  # both feet are off as long
    for rate in (100.0, 50.0):
        frame = 100.0 / rate * 0.5 * fine["cadence"] / 60.0  # % of the cycle
        assert found[rate]["stance"] == pytest.approx(fine["stance"], abs=frame)
        assert found[rate]["flight"] == pytest.approx(fine["flight"], abs=2.0 * frame)
