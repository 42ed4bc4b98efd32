"""Measures of walks that are made up: angles and forces of the norms, headings that turn, speeds that are asked for."""

import msgspec
import numpy as np
import pytest

from small_result import STRIDE, march, walk_result, walk_scene, with_arrays
from warpmuscle.core.pose import about
from warpmuscle.gait.cycles import body_weight
from warpmuscle.gait.quality import aimed_speed, gait_measures
from warpmuscle.gait.table import gait_table, human, unit_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene, SearchStage
from warpmuscle.scene.norms import NORMS
from warpmuscle.scene.parameters import start_values, substitute

STANCE = 63.0  # % of the cycle; the norm's toe-off is at 64
JOINTS = {"Hip flexion": ("Hip", -1.0), "Knee flexion": ("Knee", 1.0), "Ankle dorsiflexion": ("Ankle", -1.0)}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


def normal_walk(scene: Scene, away: float = 0.0) -> Recording:
    """A march whose legs move as the norms do, all curves of loaded legs so many half-bands above them."""
    motion = march(scene.character, 1.2, 4.0, 801, len(scene.character.muscles))
    turned, forces = motion.joint_orientation.copy(), {}
    for side in ("left", "right"):
        cycle = 100.0 * ((motion.time - (0.0 if side == "left" else 0.5 * STRIDE)) % STRIDE) / STRIDE
        for name, (joint, sign) in JOINTS.items():
            angle = np.radians(sign * (NORMS[name].mean(cycle) + away * NORMS[name].half_band))
            turned[:, motion.joint_names.index(side[0] + joint)] = about([1.0, 0.0, 0.0], angle)
        norm = NORMS["Vertical ground force"]
        mean = norm.mean(cycle)
        loaded = cycle < STANCE
        force = np.where(loaded, np.maximum(mean, 0.04) + away * norm.half_band, 0.0) * body_weight(scene)
        forces[f"foot_force_{side}"] = np.stack([0.0 * force, force, 0.0 * force], axis=1)
    velocity = np.tile([0.0, 0.0, 1.27], (len(motion.time), 1))  # the speed of the norms
    return with_arrays(motion, joint_orientation=turned, com_velocity=velocity, **forces)


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
        assert found["deviation of the ground force"] is None
        assert "angles from key points" not in found
    assert flown["flight"] == pytest.approx(20.0, abs=2.0)
    assert "angles from Fukuchi 2017" not in walking
    walk_of_flight = msgspec.structs.replace(scene, objective=Objective(gait="walk"))
    assert "angles from key points" in gait_measures(with_arrays(motion, **flying), walk_of_flight)
    assert human("stance", running=True) == ("40", "Fukuchi 2017")


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


def test_a_heading_that_turns_evenly_drifts_from_the_first_cycle_to_the_last(scene: Scene):
    motion = normal_walk(scene)
    motion = with_arrays(motion, root_orientation=about([0.0, 1.0, 0.0], np.radians(6.0) * motion.time))
    found = gait_measures(motion, scene)
    assert found["drift of the heading"] == pytest.approx(6.0 * STRIDE, abs=0.2)  # of two cycles
    assert found["maximum error of the heading"] == pytest.approx(6.0 * 3.5, abs=0.2)


def test_a_speed_counts_as_asked_for_if_the_objective_or_a_stage_says_so(scene: Scene):
    def aimed(objective: Objective, *stages: SearchStage) -> float | None:
        return aimed_speed(msgspec.structs.replace(scene, objective=objective, stages=list(stages)))

    assert aimed(Objective()) is None
    assert aimed(Objective(speed=2.0)) == 1.0
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


def test_what_humans_have_is_read_off_the_norms():
    assert human("knee, maximum in swing") == ("63.4 ± 5.3", "norm curves in SCONE Studio")
    assert human("knee, maximum in swing at")[0] == "72"
    assert human("depth of the valley")[0] == "0.25"
    assert human("stance")[0] == "64"
    assert human("depth of the feet") == ("", "")
    assert (unit_of("hip, minimum at"), unit_of("hip, minimum")) == ("% of the cycle", "deg")
