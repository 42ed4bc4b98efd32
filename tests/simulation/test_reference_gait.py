"""A tracked gait: tables of means over the phase, and an error that is zero for the gait itself."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import ResultError, RolloutError, SceneError
from warpmuscle.core.pose import about
from warpmuscle.formats import load, toml
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import write
from warpmuscle.scene import Objective, Scene, Tracking
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation import reference_gait
from warpmuscle.simulation.rollout import Rollout


def tracked(name: str, source: Tracking, duration: float = 4.0) -> Scene:
    return msgspec.structs.replace(
        load(name), duration=duration, objective=Objective(tracking=1.0), tracking=source, description=""
    )


def error_of(scene: Scene) -> float:
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    return float(rollout.terms()["tracking"][0])


def test_a_gait_is_nearer_to_itself_than_to_another():
    itself, other = (error_of(tracked("fwalk", Tracking(scene=name))) for name in ("fwalk", "bwalk"))
    assert itself < 0.05 * other
    assert other > 1.0


def test_a_scene_that_tracks_a_scene_may_be_tracked_even_by_itself(tmp_path):
    path = tmp_path / "own.toml"
    source = Tracking(scene=str(path), start=0.0)
    toml.write(tracked("fwalk", source, 2.0), path)
    assert error_of(load(path)) < 0.1
    toml.write(tracked("fwalk", Tracking(scene="bwalk"), 2.0), path)
    assert error_of(tracked("fwalk", source, 2.0)) < 0.1


@pytest.mark.long
def test_a_walk_on_muscles_is_near_to_that_on_torques_by_a_root_mean_square_of_some_degrees():
    error = error_of(tracked("walk56", Tracking(scene="fwalk", joints=["lHip", "rHip", "lKnee", "rKnee"])))
    assert 1.0 < np.degrees(np.sqrt(error / 4.0 / 4.0)) < 8.0


def test_a_file_gives_the_same_reference_as_the_scene_that_made_it(tmp_path):
    scene = load("bwalk")
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run()
    table = parameter_table(free_parameters(scene))
    write(tmp_path / "walk.h5", Result("", "cpu", "", 0, table, replays=(rollout.recording(),)))
    sources = Tracking(file=str(tmp_path / "walk.h5")), Tracking(scene="bwalk")
    first, second = (error_of(tracked("fwalk", source, 1.0)) for source in sources)
    assert first == second > 0.0


def test_a_run_saved_with_numpy_gives_the_same_error_as_its_result_file_bit_for_bit(tmp_path):
    scene = load("fwalk")
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run(5.0)
    motion = rollout.recording()
    table = parameter_table(free_parameters(scene))
    write(tmp_path / "walk.h5", Result("", "cpu", "", 0, table, replays=(motion,)))
    joints = {name: motion.joint_orientation[:, k] for k, name in enumerate(motion.joint_names)}
    np.savez(tmp_path / "walk.npz", time=motion.time, phase=motion.phase, stance=motion.stance, **joints)
    sources = [Tracking(file=str(tmp_path / name)) for name in ("walk.h5", "walk.npz")]
    first, second = (error_of(tracked("fwalk", source, 1.0)) for source in sources)
    assert first == second > 0.0


def test_a_recording_of_the_original_program_is_near_to_the_same_gait_here(reference_data: Path):
    near, far = (
        error_of(tracked("fwalk", Tracking(file=str(reference_data / f"simbicon/reference/bipV2_{gait}.npz"))))
        for gait in ("fWalk", "bWalk")
    )
    assert near < 0.1 * far


def test_knees_over_a_gait_cycle_are_tracked_without_times(tmp_path):
    cycle = np.arange(100) / 100.0
    knee = 0.1 + 0.9 * np.exp(-(((cycle - 0.72) / 0.1) ** 2))  # rad, of the left leg, bent in its swing
    np.savez(tmp_path / "knees.npz", cycle=cycle, lKnee=knee, rKnee=np.roll(knee, 50))
    error = error_of(tracked("fwalk", Tracking(file=str(tmp_path / "knees.npz")), 2.0))
    both = error_of(tracked("fwalk", Tracking(file=str(tmp_path / "knees.npz"), joints=["lKnee", "rKnee"]), 2.0))
    assert error == both
    assert 0.0 < np.degrees(np.sqrt(error / 2.0 / 2.0)) < 60.0


def test_a_file_without_motion_after_the_start_or_without_the_replay_is_an_error(tmp_path):
    path = str(tmp_path / "a.npz")
    np.savez(path, time=np.arange(4) * 0.1, phase=np.arange(4) / 4, stance=[0, 0, 1, 1], lKnee=np.zeros(4))
    with pytest.raises(RolloutError, match=r"a\.npz has no motion from 2 s on, which `tracking.start` asks for"):
        Rollout(tracked("fwalk", Tracking(file=path)), 1, "cpu")
    with pytest.raises(RolloutError, match=r"a\.npz has 1 motion, none with number 1"):
        Rollout(tracked("fwalk", Tracking(file=path, start=0.0, replay=1)), 1, "cpu")
    with pytest.raises(RolloutError, match="has no joint 'rKnee'"):
        Rollout(tracked("fwalk", Tracking(file=path, start=0.0, joints=["rKnee"])), 1, "cpu")
    with pytest.raises(ResultError, match=r"there is no such file"):
        Rollout(tracked("fwalk", Tracking(file=str(tmp_path / "b.NPZ"))), 1, "cpu")


def test_means_over_the_phase_are_those_of_the_frames_in_each_bin():
    scene = load("fwalk")
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run(5.0)
    motion = rollout.recording().window(2.0)
    table, counts = reference_gait.reference_table(motion, rollout.names, ["lKnee"])
    body = rollout.names.body_of_joint("lKnee")
    assert np.flatnonzero(counts).tolist() == [body]
    here = (motion.stance == 1) & ((motion.phase * reference_gait.BINS).astype(int) == 20)
    mean = motion.joint_orientation[here, motion.joint_names.index("lKnee")].mean(axis=0)
    np.testing.assert_allclose(table[reference_gait.BINS + 20, body], mean / np.linalg.norm(mean), atol=1e-6)


def test_squared_angles_count_by_the_weights_of_their_joints():
    knees = ["lKnee", "rKnee"]
    both, left, right, weighted = (
        error_of(tracked("fwalk", Tracking(scene="bwalk", joints=joints, weights=weights), 1.0))
        for joints, weights in (
            (knees, {}), (knees, {"rKnee": 0.0}), (knees, {"lKnee": 0.0}), (knees, {"lKnee": 3.0, "rKnee": 0.5}),
        )
    )  # fmt: skip
    assert left + right == pytest.approx(both, rel=1e-5)
    assert weighted == pytest.approx(3.0 * left + 0.5 * right, rel=1e-5)


def test_a_gait_over_the_cycle_does_not_count_before_the_cycle_is_known(tmp_path, unoptimized_test):
    np.savez(tmp_path / "bent.npz", cycle=np.linspace(0.0, 1.0, 50), lKnee=np.ones(50))
    scene = tracked("fwalk", Tracking(file=str(tmp_path / "bent.npz"), start=0.0), 0.1)
    assert error_of(scene) > 0.05  # by the phase of the controller
    assert error_of(msgspec.structs.replace(scene, controller=None)) == 0.0


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (Tracking(scene="fwalk", weights={"lKne": 1.0}), "tracking.weights.lKne.*lKnee"),
        (Tracking(scene="fwalk", weights={"lKnee": -1.0}), "must not be negative, is -1"),
        (Tracking(scene="fwalk", weights={"lKnee": float("nan")}), "not a finite number"),
        (Tracking(), "either a scene or a file"),
        (Tracking(scene="fwalk", file="a.h5"), "either a scene or a file"),
        (Tracking(scene="fwalk", joints=["lKne"]), "lKnee"),
        (None, "no gait to track"),
    ],
)
def test_impossible_tracking_is_an_error_of_the_scene(source, message):
    with pytest.raises(SceneError, match=message):
        check_scene(tracked("fwalk", source))


def test_a_motion_without_a_joint_or_a_side_is_an_error():
    rollout = Rollout(load("fwalk"), 1, "cpu", record=[0])
    rollout.run(3.0)
    motion, names = rollout.recording(), rollout.names
    bird = replace(motion, joint_names=tuple(name.replace("Elbow", "Wing") for name in motion.joint_names))
    with pytest.raises(RolloutError, match="has no joint 'lElbow'"):
        reference_gait.reference_table(bird, names, ["lElbow"])
    with pytest.raises(RolloutError, match="never stands on the right"):
        reference_gait.reference_table(motion.window(0.0, 0.1), names, [])


def test_phases_of_a_recording_without_a_controller_follow_from_contacts():
    time = np.arange(300) / 100.0
    loaded = (time % 1.0 > 0.2) & (time % 1.0 < 0.8)  # the left foot comes down at 0.2, 1.2 and 2.2 s
    force = np.zeros((300, 3))
    force[:, 1] = np.where(loaded, 800.0, 0.0)
    turn = np.zeros((300, 1, 4))
    turn[..., 3] = 1.0
    motion = Recording.of(
        {"time": time, "joint_orientation": turn, "foot_force_left": force}, ("knee",), ("thigh", "shank"),
        kept=["joint_orientation", "foot_force_left"],
    )  # fmt: skip
    scene = load("fwalk")
    found = reference_gait._by_contact(motion, substitute(scene, start_values(scene)), "a.h5")
    assert found.by_contact
    assert found.period == pytest.approx(1.0, abs=0.01)
    assert found.time[0] == pytest.approx(0.21)
    assert found.time[-1] == pytest.approx(2.19)
    assert set(found.stance.tolist()) == {0, 1}
    with pytest.raises(RolloutError, match=r"a\.h5 has no phases.* nor ground forces of a whole gait cycle"):
        reference_gait._by_contact(motion.window(0.0, 1.0), substitute(scene, start_values(scene)), "a.h5")


def test_a_gait_begins_where_it_is_nearest_to_the_initial_pose():
    scene = load("reflex_planar")
    scene = substitute(scene, start_values(scene))
    names = Rollout(scene, 1, "cpu").structure.names
    knee, body = about([1.0, 0.0, 0.0], np.linspace(0.0, 1.0, 20)), names.body_of_joint("lKnee")
    table = np.tile([0.0, 0.0, 0.0, 1.0], (20, len(names.bodies), 1))
    table[:, body] = knee
    counts = np.zeros(len(names.bodies))
    counts[body] = 1.0
    scene.initial_state.joints["lKnee"].orientation = tuple(knee[13])
    assert reference_gait.nearest_part(table, counts, scene, names) == pytest.approx(13.5 / 20)
