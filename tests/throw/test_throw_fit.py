"""The throwing arm fitted to the mean throw of its own scene, and thrown with: every stage on real simulations."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from described import assert_described
from small_disk import disk_of
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.formats import load
from warpmuscle.formats.toml import loads as load_text
from warpmuscle.plots import KINDS, Absent, Choices, Subject, draw
from warpmuscle.report.page import report_html
from warpmuscle.report.summary import report
from warpmuscle.results.result import read
from warpmuscle.scene.parameters import start_values
from warpmuscle.throw.arm import Arm, joint_positions, needed_torques, root_motion, states
from warpmuscle.throw.equation_error import Capacity
from warpmuscle.throw.fit import Settings
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, Options
from warpmuscle.throw.motion import Motion, resample
from warpmuscle.throw.problem import (
    Lack,
    check_limits,
    check_range,
    computed_excitation,
    computed_synergies,
    lacking,
    motion_of,
    shortcoming,
    sparsest,
)
from warpmuscle.throw.published import as_published
from warpmuscle.throw.report import write
from warpmuscle.throw.signals import computed_activation, to_activation, to_excitation
from warpmuscle.throw.strength import missing_torque
from warpmuscle.throw.synthesis import Thrower
from warpmuscle.view.sources import of_replays, tracks_of


@pytest.fixture(scope="module")
def job() -> Job:
    """Fitted from literature parameters to signals computed with others."""
    made = Job(load("throw"), [], Options())
    made.settings = Settings(common_steps=4, early_steps=3, signal_steps=6)
    made.fit()
    return made


def arm_and_motion() -> tuple[Arm, Motion]:
    scene = load("throw")
    arm = Arm(scene)
    return arm, motion_of(scene, arm)


def faster(motion: Motion, factor: float) -> Motion:
    return Motion("fast", 0.0, motion.time / factor, motion.angles, motion.pitch, motion.place)


def test_the_fit_meets_all_bars_from_literature_parameters(job: Job):
    agreement = job.fitted.agreement
    assert agreement.good().all(), agreement
    assert job.fitted.stages[0].agreement.r2.min() < 0.0


@pytest.mark.long
def test_a_throw_whose_signals_miss_narrowly_is_fitted_nearer_to_the_extracted_ones(
    reference_data: Path, tmp_path: Path
):
    """T0012 with the trunk and the place of the shoulder: five times the price would take the hand too far away."""
    with np.load(reference_data / "spl_freethrow" / "throws22.npz") as data:
        row, point = (list(data[name]).index(one) for name, one in (("trial", "T0012"), ("keypoints", "R_SHOULDER")))
        names = ("shoulder_flexion", "elbow_flexion", "wrist_flexion", "shoulder_flexion_gravity")
        columns = {"time": data["time"]} | {f"{name}_deg": data[name][row] for name in names}
        place = data["keypoint_pos_m"][row, :, point]
    columns |= {"shoulder_forward_m": place[:, 0], "shoulder_up_m": place[:, 2]}
    path = tmp_path / "throw.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6g", ",", header=",".join(columns), comments="")
    agreement = Job(load("throw"), [path], Options(threads=1)).fit().agreement
    assert agreement.good().all(), agreement


@pytest.mark.long
def test_recorded_throws_meet_all_bars(reference_data: Path):
    """All 22 free throws, every other one held out of the fit of the parameters."""
    job = Job(load("throw"), sorted((reference_data / "spl_freethrow").glob("throw_T*.csv")), Options(seed=1))
    assert len(job.motions) == 22
    assert job.fit().agreement.good().all(), job.fitted.agreement


def test_parameters_stay_within_the_intervals_of_the_scene(job: Job):
    for parameter, value in zip(job.arm.parameters, job.arm.values(job.fitted.unknowns), strict=True):
        assert parameter.min * (1 - 1e-9) <= value <= parameter.max * (1 + 1e-9) or parameter.min < 0.0
    values = np.array([p.value for p in job.arm.parameters])
    np.testing.assert_allclose(job.arm.values(job.arm.unknowns(values)), values, rtol=1e-12)


def test_a_fit_is_kept_whole_with_the_scene_that_it_came_to(job: Job, tmp_path):
    job.write(tmp_path / "throw.h5", {"command": "test"})
    assert_described(tmp_path / "throw.h5")
    with h5py.File(tmp_path / "throw.h5") as file:
        assert file.attrs["format"] == "warpmuscle throw"
        assert file["fit/angle"].shape == file["motions/angle"].shape == (1, 151, 3)
        assert file["fit/r2"][-1].min() > 0.999
        (tmp_path / "fitted.toml").write_text(file["fit"].attrs["scene"])
    assert load(str(tmp_path / "fitted.toml")).character.muscles["m1"].f_max.value != 1142.6


def test_a_fit_is_kept_with_some_quantities_of_its_motions(job: Job, tmp_path):
    job.write(tmp_path / "throw.h5", {"command": "test"}, ["com"], single=True)
    motion = read(tmp_path / "throw.h5").replays[0]
    assert motion.com.dtype == np.float32
    assert len(motion.com) == motion.frames > 0
    assert motion.body_position.shape[0] == 0


@pytest.fixture(scope="module")
def kept(job: Job, tmp_path_factory) -> Path:
    """The file of the fit and of a new throw."""
    path = tmp_path_factory.mktemp("kept") / "throw.h5"
    thrower = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns)
    job.throws = [thrower.throw(Goal(distance=1.5), synergies=(0, 1, 3))]
    job.write(path, {"command": "warpmuscle throw", "seed": 3})
    return path


def test_full_disk_leaves_an_older_file_of_throws(job: Job, kept, tmp_path):
    path = tmp_path / "throw.h5"
    path.write_text("older")
    with disk_of(64), pytest.raises(ResultError, match=r"throw\.h5: cannot be written: file too large"):
        job.write(path, {"command": "warpmuscle throw", "seed": 3})
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("throw.h5", "older")]


def test_the_file_holds_motions_as_other_results_do_beside_the_recorded_ones(job: Job, kept):
    result = read(kept)
    assert (result.seed, result.replay_names) == (3, ("throw", "throw at 1.5 m"))
    simulated, recorded = (
        hinge_angle(q) for q in (result.replays[0].joint_orientation, result.replays[0].joint_target)
    )
    np.testing.assert_allclose(simulated, job.fitted.replay.angle[0, :-1], atol=1e-5)
    np.testing.assert_allclose(recorded, job.motions.angles[0][0, :-1], atol=1e-6)
    thrown = hinge_angle(result.replays[1].joint_orientation)
    np.testing.assert_allclose(thrown, job.throws[0].replay.angle[0, :-1], atol=1e-5)
    assert np.abs(thrown - simulated).max() > 0.01
    best = load_text(result.scene).character.muscles["m1"].f_max.value
    assert best == pytest.approx(result.parameters.value[result.parameters.name.index("character.muscles.m1.f_max")])


def hinge_angle(quaternion: np.ndarray) -> np.ndarray:
    """Angles (F, 3) of quaternions xyzw, rad: shoulder and elbow turn about -x, the wrist about x."""
    return np.array([-2.0, -2.0, 2.0]) * np.arctan2(quaternion[..., 0], quaternion[..., 3])


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_figure_is_drawn_or_says_in_a_line_why_not(kind: str, kept):
    subject = Subject(read(kept), path=kept)
    if kind in ("angles", "feet", "ground_force", "moments", "body", "parameters"):
        with pytest.raises(Absent, match=r"no legs|holds no search") as caught:
            draw(subject, kind)
        assert "\n" not in str(caught.value)
    else:
        assert draw(subject, kind).axes


def test_angles_are_drawn_over_the_recorded_ones(kept):
    panels = draw(Subject(read(kept)), "joints").axes
    assert [len(axes.lines) for axes in panels] == [4, 3, 3]  # recorded, simulated, zero; a legend
    below, above = (line.get_ydata() for line in panels[1].lines[:2])
    np.testing.assert_allclose(below, above, atol=2.0)
    assert not np.array_equal(below, above)


@pytest.mark.parametrize(("name", "panels"), [("/fit/C", 1), ("/motions/angle", 1), ("/replay/1/muscle_force", 1)])
def test_datasets_of_recorded_motions_are_drawn_over_time(name: str, panels: int, kept):
    figure = draw(Subject(read(kept), path=kept), f"dataset:{name}")
    assert len(figure.axes) == panels
    assert figure.axes[0].get_xlabel() == "time (s)"


def test_the_viewer_shows_the_recorded_motion_as_the_desired_one(kept):
    sights = of_replays(read(kept))
    assert [sight.label for sight in sights] == ["throw", "throw at 1.5 m"]
    track = tracks_of(sights)[1]
    assert np.abs(track.desired[:, -1] - track.recording.body_orientation[:, -1]).max() > 0.01
    np.testing.assert_allclose(track.desired[:, 0], track.recording.body_orientation[:, 0])


def test_the_report_of_a_fit_says_how_it_went_and_which_motions_there_are(kept):
    lines = report(read(kept))
    assert "fit of 1 motion: r2 of shoulder, elbow, wrist" in lines
    assert lines[-2:] == ["motion 0: throw", "motion 1: throw at 1.5 m"]
    page = report_html(Subject(read(kept), Choices(replay=1), kept))
    assert "r2 of elbow" in page
    assert page.count("<iframe") == 1


@pytest.mark.parametrize("distance", [1.5, 2.0])
def test_a_ball_lands_on_its_target_by_a_few_synergies_alone(job: Job, distance: float):
    thrower = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns)
    made = thrower.throw(Goal(distance=distance), synergies=(0, 1, 3))
    assert made.met
    assert made.clearance > 0.0
    changed = job.follower.shaped((made.own != job.fitted.own[0])[None])[0].any(axis=1)
    assert set(np.flatnonzero(changed)) <= set(made.synergies)
    free = made.flight.position[0] + made.flight.velocity[0] * made.flight.duration[0]
    assert free[1] - 0.5 * thrower.gravity * made.flight.duration[0] ** 2 == pytest.approx(0.0, abs=1e-6)


def test_no_joint_of_a_new_throw_passes_its_limits_before_the_release_and_one_that_does_misses(job: Job):
    """Measured from the angles themselves: limits as the scene's joints have them, in radians."""
    made = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns).throw(Goal(distance=2.0))
    joints = load("throw").character.joints
    for column, name in enumerate(job.arm.joints):
        low, high = joints[name].limits[0]
        angle = made.replay.angle[0, : round(made.release / 0.01) + 1, column]
        assert max(low - angle.min(), angle.max() - high) <= np.radians(1.0), name
    assert made.met
    beyond = replace(made, past_limits={"elbow": np.radians(7.0)})
    assert (beyond.met, list(beyond.missed)) == (False, ["limits"])


def test_stronger_muscles_are_not_tried_where_limits_alone_are_missed(job: Job, monkeypatch: pytest.MonkeyPatch):
    thrower = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns)
    made = replace(thrower.throw(Goal(distance=1.5)), past_limits={"elbow": np.radians(7.0)})
    monkeypatch.setattr(job, "throws", [])
    monkeypatch.setattr(Thrower, "throws", lambda *_: [made])
    monkeypatch.setattr("warpmuscle.throw.job.what_lacks", lambda *_: pytest.fail("tried"))
    assert [one.lack for one in job.throw([Goal(distance=1.5)])] == [""]


def test_goals_releases_flights_and_landings_are_in_the_file(kept: Path):
    with h5py.File(kept) as file:
        one = file["throws"]
        assert one["goal/distance"][:] == pytest.approx([1.5])
        assert np.isnan(one["goal/speed"][0])
        place, velocity, duration = one["release_position"][0], one["release_velocity"][0], one["flight_time"][0]
        forward, up = place + velocity * duration - [0.0, 0.5 * 9.81 * duration**2]
        np.testing.assert_allclose(one["landing_position"][0], [forward, up], atol=1e-6)
        assert one["landing_position"][0, 0] == pytest.approx(1.5, abs=0.05)
        assert one["release_speed"][0] == pytest.approx(np.hypot(*velocity))
        assert one["release_time"].attrs["units"] == "s"
        assert one["met"][0]


def test_a_goal_is_met_only_if_all_that_it_names_is(job: Job):
    made = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns).throw(Goal(distance=1.5))
    speed = float(made.flight.speed[0])
    assert made.met
    assert replace(made, goal=Goal(distance=1.5, speed=speed)).met
    assert not replace(made, goal=Goal(distance=1.5, speed=speed + 1.0)).met
    assert not replace(made, goal=Goal(angle=float(made.flight.angle[0]) + 0.1)).met
    nowhere = replace(made.flight, distance=np.array([np.nan]))
    assert not replace(made, flight=nowhere).met


def test_the_published_procedure_meets_the_angles_before_its_filter(job: Job, tmp_path):
    result = as_published(job.arm, job.motions, job.follower.synergies, job.start, evaluations=3)
    names = [stage.name for stage in result.stages]
    assert names[-2:] == ["signals step by step", "signals filtered"]
    assert np.isfinite(result.stages[-1].r2).all()
    assert result.stages[-2].r2.mean() > result.stages[0].r2.mean()
    write(tmp_path / "published.h5", job.follower, None, result, [0], {})
    kept = read(tmp_path / "published.h5")
    assert kept.fit.stages[-1] == "signals filtered"
    np.testing.assert_allclose(hinge_angle(kept.replays[0].joint_orientation), result.replay.angle[0, :-1], atol=1e-4)


def test_solutions_of_a_goal_are_unlike_each_other(job: Job):
    first, second = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns).throws(Goal(distance=1.5), 2)
    assert first.met
    assert second.met
    assert np.sqrt(np.mean((first.own - second.own) ** 2)) > 0.14


def test_torque_is_lacking_where_muscles_are_too_weak_for_a_throw_and_only_there(job: Job):
    thrower = Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns)
    made = thrower.throw(Goal(distance=1.5))
    assert missing_torque(thrower, made) == {}
    lacking = missing_torque(thrower.stronger(0.3), made)
    assert lacking  # of which joint is another matter: throws that meet a goal differ between machines
    for needed, available, time in lacking.values():
        assert abs(needed) > abs(available)
        assert 0.0 <= time <= made.release


def test_a_release_beyond_the_throw_is_refused(job: Job):
    with pytest.raises(Error, match="within the throw"):
        Thrower(job.follower, job.fitted.own[0], job.fitted.unknowns, release=9.0)


def test_computed_activations_make_the_torques_that_the_motion_needs():
    arm, motion = arm_and_motion()
    strong = Job(arm.scene, [], Options()).strong
    motions = resample([motion])
    unknowns = np.zeros(0)
    activation, found = computed_activation(strong, motions, unknowns)
    angle, speed = motions.angles[0][0], motions.angles[1][0]
    made = strong.muscle_table(unknowns[None]).torques(activation[0], angle, speed)[0].sum(axis=1)
    needed = needed_torques(strong, motions)[0]
    np.testing.assert_allclose(made[found.feasible], needed[found.feasible], atol=1e-3)
    assert found.feasible.mean() > 0.97


def test_excitations_lead_back_to_the_activations_that_they_are_computed_from():
    arm, _ = arm_and_motion()
    time = np.arange(0.0, 1.5, 0.01)
    activation = (0.4 + 0.3 * np.sin(4.0 * time))[None, :, None]
    back = to_activation(arm, to_excitation(arm, activation), activation[:, 0])
    np.testing.assert_allclose(back, activation, atol=0.03)


def test_a_motion_beyond_the_strength_of_the_muscles_says_which_lack_how_much():
    arm, motion = arm_and_motion()
    strong = Job(arm.scene, [], Options()).strong
    usual, fast = resample([motion]), resample([faster(motion, 3.0)])
    unknowns = np.zeros(0)
    assert not lacking(strong, usual, computed_excitation(strong, usual)[-1], unknowns)
    lack = lacking(strong, fast, computed_excitation(strong, fast)[-1], unknowns)[0]
    assert "m1 lacks" in lack.explanation or "m4 lacks" in lack.explanation
    assert lack.joint in arm.driven
    assert lack.weak
    assert abs(lack.bound) < abs(lack.needed)


def test_what_an_arm_lacks_is_told_once_in_a_sentence():
    """Where muscles are far too weak, as for a pitch, turns that a planar arm does not have are named."""
    arm, motion = arm_and_motion()
    strong = Job(arm.scene, [], Options()).strong
    fast = resample([motion, faster(motion, 4.0), faster(motion, 3.0)])
    lacks = lacking(strong, fast, computed_excitation(strong, fast)[-1], np.zeros(0))
    text = shortcoming(arm, lacks, 3, "the muscle groups")
    assert text.startswith("the muscle groups cannot make 2 of 3 motions: the ")
    assert "N m in fast at " in text
    assert "turning trunk, upper arm and forearm about themselves" in text
    assert "\n" not in text
    assert shortcoming(arm, [], 3, "the muscle groups") == ""
    weak = [replace(lacks[0], needed=10.0, least=-5.0, most=8.0, others=())]
    assert shortcoming(arm, weak, 1, "the fitted muscles").endswith("and they make at most 8")


def test_a_torque_that_muscles_make_too_much_of_is_told_apart_from_weakness():
    """Passive forces of stretched muscles, and muscles over two joints, are no lack of strength."""
    arm, _ = arm_and_motion()
    stretched = Lack("m", "", 0.1, "shoulder", 0.5, 4.25, 0.48, 4.73, 119.0)
    assert "shoulder needs 4.25 N m at 0.50 s, and stretched as they are they make at least 4.73" in shortcoming(
        arm, [stretched], 1, "the fitted muscles"
    )
    other_way = replace(stretched, needed=-3.5, least=2.0, most=20.0)
    assert "make 2 or more the other way" in shortcoming(arm, [other_way], 1, "the fitted muscles")
    together = replace(stretched, least=-9.0, most=9.0, others=("elbow", "wrist"))
    text = shortcoming(arm, [together], 1, "the fitted muscles")
    assert "which they do not make together with the torques of elbow and wrist" in text
    assert not any(lack.weak for lack in (stretched, other_way, together))


def test_motions_beyond_the_limits_of_a_joint_are_refused():
    arm, motion = arm_and_motion()
    angles = motion.angles.copy()
    angles[70, 1] = 4.0
    scene = arm.scene
    if not scene.character.joints["elbow"].limits:
        scene.character.joints["elbow"].limits = [(-0.2, 2.7)]
    with pytest.raises(Error, match=r"elbow is at 229\.2 deg after 0\.7 s"):
        check_limits(Arm(scene), Motion("m", 0.0, motion.time, angles, motion.pitch, motion.place))
    for zero, sign, what in ((0.0, -1.0, "its negative"), (np.pi, -1.0, "180 deg less it")):
        angles[:, 1] = zero + sign * np.linspace(0.1, 2.0, len(angles))
        with pytest.raises(Error, match=rf"a straight arm that hangs down\? Within them would be .*{what}"):
            check_limits(Arm(scene), Motion("m", 0.0, motion.time, angles, motion.pitch, motion.place))


def test_activations_start_where_the_motion_has_them_and_not_at_the_first_excitation():
    """A relaxing muscle is told less than it still does: what it is told before the file begins is in nothing else."""
    arm, motion = arm_and_motion()
    motions = resample([motion])
    strong = Job(arm.scene, [], Options()).strong
    activation, excitation, _ = computed_excitation(strong, motions)
    synergies, _ = computed_synergies(arm, motions, strong, 6)
    assert np.abs(excitation[0, 0] - activation[0, 0]).max() > 0.05
    np.testing.assert_allclose(synergies.excitation(synergies.start)[0], activation[0, 0], atol=0.02)


def test_the_shoulder_accelerates_alike_in_the_middle_and_at_the_ends_of_a_noisy_file():
    """Its place and the trunk's pitch are differentiated once, not again as the root's place."""
    arm, motion = arm_and_motion()
    noisy = motion.pitch + np.radians(0.02) * np.random.default_rng(0).normal(size=motion.pitch.shape)
    bend = root_motion(arm, resample([replace(motion, pitch=noisy)]))[2][0]
    clean = root_motion(arm, resample([motion]))[2][0]
    error = np.abs(bend - clean).max(axis=1)
    assert error[[0, 1, -2, -1]].max() < 1.5 * error[10:-10].max()


def test_the_root_moves_so_that_the_shoulder_does_as_recorded():
    arm, motion = arm_and_motion()
    motions = resample([motion])
    q, v, a = states(arm, motions)
    shoulder = joint_positions(arm, q[0])[0][:, [2, 1]]
    np.testing.assert_allclose(shoulder - shoulder[0], motions.place[0][0] - motions.place[0][0, 0], atol=1e-9)
    np.testing.assert_allclose(np.gradient(q[0, :, :3], 0.01, axis=0)[1:-1], v[0, 1:-1, :3], atol=0.02)
    np.testing.assert_allclose(np.gradient(v[0, :, :3], 0.01, axis=0)[1:-1], a[0, 1:-1, :3], atol=0.5)


def test_what_a_motion_needs_beyond_the_muscles_strength_counts_in_fits():
    arm, motion = arm_and_motion()
    strong = Job(arm.scene, [], Options()).strong
    motions = resample([motion, faster(motion, 3.0)])
    usual, fast = Capacity(strong, motions).residuals(np.array([0, 1]), np.zeros((2, 0)))
    assert np.abs(usual).max() < 0.2 < np.abs(fast).max()
    literature = Capacity(arm, motions).residuals(np.array([0]), arm.unknowns(start_values(arm.scene))[None])
    assert np.abs(literature).max() > 2.0 * np.abs(usual).max()


def test_ties_that_other_synergies_can_take_over_are_undone():
    """Of the first muscle and the last, which have synergies of their own; the other two share one and stay tied."""
    weights = np.array([[1.0, 0.47, 0.0], [0.0, 1.0, 0.0], [0.0, 0.4, 0.0], [0.02, 0.0, 1.0]])
    expected = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 1.0]]
    np.testing.assert_array_equal(sparsest(weights), expected)


def test_joints_that_stand_still_are_refused_unless_they_are_prescribed():
    arm, motion = arm_and_motion()
    still = replace(motion, angles=motion.angles * [1.0, 1.0, 0.01])
    with pytest.raises(Error, match=r"wrist moves by no more than 0\.\d+ deg.*--prescribe wrist"):
        check_range(arm, still)
    check_range(Arm(arm.scene, ("wrist",)), still)


def test_one_angle_of_a_universal_joint_may_be_the_muscles():
    """The whole body's elbow and wrist, whose other angle stays as the scene has it."""
    arm = Arm(load("throw_body"))
    assert arm.axes == {"shoulder": 0, "elbow": 1, "wrist": 1}
    assert arm.simulated.actuation["elbow"].drive == ["kinematic", "muscle"]
    prescribed = Arm(arm.scene, ("elbow",)).simulated
    assert prescribed.actuation["elbow"].drive == ["kinematic", "kinematic"]


def test_muscles_over_two_angles_of_a_joint_are_refused_rather_than_fitted_in_part():
    scene = load("throw_body")
    scene.character.muscles["m5"].pulleys[0].axis = 0
    with pytest.raises(Error, match="wrist, which is neither a hinge nor a universal joint with one"):
        Arm(scene)


def test_joints_that_no_muscle_moves_cannot_be_prescribed():
    with pytest.raises(Error, match="knee"):
        Arm(load("throw"), ("knee",)).driven  # noqa: B018
    with pytest.raises(Error, match="all joints"):
        Arm(load("throw"), ("shoulder", "elbow", "wrist"))
