"""A gait that is imitated: what its own controller does earns nearly all, and the clock stands as the gait does."""

import dataclasses
from dataclasses import fields

import msgspec
import numpy as np
import pytest

from person_walk import SCENE, as_of_policy
from small_result import no_parameters
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.core.pose import conjugate, rotate, twist_angle
from warpmuscle.formats import load, toml
from warpmuscle.gait.foot_contact import touch_downs
from warpmuscle.gait.likeness import dimensionless_speed, leg_length, trend
from warpmuscle.kernels.learning.rewards import FORCE, IMITATION, TERMS
from warpmuscle.learning import EpisodeBatch, Imitation, Rewards, Sense, Task, Variation
from warpmuscle.learning.imitation import (
    BINS,
    CARRYING,
    SPEEDS,
    Gait,
    gait_kept,
    imitated,
    kept,
    measured_gait,
    recorded_gait,
    run_from,
    seen_time,
    smoothed_over_cycle,
    with_norm,
    with_step_width,
)  # fmt: skip
from warpmuscle.learning.imitation.gait import LEFT, changed
from warpmuscle.learning.imitation.pelvis import obliquity, tilt
from warpmuscle.learning.imitation.table import gait_at, wanted_forces
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.results.partial_motion import reduced
from warpmuscle.results.records import Result
from warpmuscle.results.result import write
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.learning import ImitatedRun
from warpmuscle.scene.norms import IMITATED, LEG_ANGLES, PERCENT_OF_BIN, WALKING, is_run, running_force, walking_force
from warpmuscle.scene.objective import Objective
from warpmuscle.scene.parameters import at_start
from warpmuscle.simulation.rollout import Rollout

replace = msgspec.structs.replace
NOTHING = dict.fromkeys(TERMS, 0.0)


@pytest.fixture(scope="module")
def batch() -> EpisodeBatch:
    rewards = Rewards(**(NOTHING | {"imitation": 1.0}), imitation_width=0.3)
    task = Task(
        observations={"clock": Sense(), "coordinates": Sense()}, imitation=Imitation(norm="Fukuchi 2018"),
        rewards=rewards, symmetric=True, variation=Variation(start_states=12, start_after=0.0, velocity_noise=0.0),
    )  # fmt: skip
    return EpisodeBatch(as_of_policy(), 12, "cpu", task, threads=1)


@pytest.fixture(scope="module")
def walker() -> Rollout:
    rollout = Rollout(SCENE, 1, "cpu", record=[0], threads=1)
    rollout.run()
    return rollout


def gait_in(walker: Rollout, imitation: Imitation, body: BodySymmetry | None = None) -> Gait:
    measured = measured_gait(walker.recording().window(0.0, seen_time(imitation)), walker, imitation)
    return imitated(measured, walker, imitation, body)


@pytest.fixture(scope="module")
def gait(walker: Rollout) -> Gait:
    return gait_in(walker, Imitation(settle=1.0))


def test_the_clock_says_when_feet_touch_down(walker: Rollout, gait: Gait):
    recording = walker.recording()
    away = np.exp(2j * np.pi * gait.phases(touch_downs(recording, "left")[1:]))
    np.testing.assert_allclose(away, 1.0, atol=0.1)
    np.testing.assert_allclose(gait.phases(touch_downs(recording, "right")[2:]), gait.right, atol=0.03)
    assert gait.right == pytest.approx(0.5, abs=0.02)


def test_the_gait_is_where_its_recording_is(walker: Rollout, gait: Gait):
    recording = walker.recording()
    late = recording.time > 2.0
    rows = (gait.phases(recording.time[late]) * BINS).astype(int)
    for k, name in enumerate(walker.coordinate_names[7:], start=7):
        away = gait.coordinate[rows, k] - recording.coordinate[late, k]
        assert np.sqrt(np.mean(away**2)) < 0.06, name


def test_both_sides_of_an_even_gait_are_each_others_images(walker: Rollout):
    body = BodySymmetry(walker)
    even = gait_in(walker, Imitation(settle=1.0), body)
    later = np.roll(even.coordinate, BINS // 2, axis=0)
    names = walker.coordinate_names
    for name, (other, sign) in body.coordinates.items():
        np.testing.assert_allclose(
            even.coordinate[:, names.index(name)], sign * later[:, names.index(other)], atol=1e-6, err_msg=name
        )


def test_a_kept_gait_is_the_measured_one_for_its_scene_alone(walker: Rollout):
    imitation = Imitation(settle=1.0, norm="key points")
    measured = measured_gait(walker.recording().window(0.0, seen_time(imitation)), walker, imitation)
    found = kept(measured, walker.scene, imitation)
    again = gait_kept(found, walker, imitation)
    for field in fields(Gait):
        np.testing.assert_array_equal(getattr(again, field.name), getattr(measured, field.name))
    assert gait_kept(found, walker, replace(imitation, cycle_time=1.3, norm="")) is not None
    assert gait_kept(found, walker, replace(imitation, settle=2.0)) is None
    assert gait_kept(found, walker, None) is gait_kept(None, walker, imitation) is None

    def fits(changed: Scene) -> bool:
        return kept(measured, changed, imitation).scene == found.scene

    scene = walker.scene
    same = replace(
        scene, name="x", duration=3.0, learning=Task(), objective=Objective(speed=2.0),
        failure=replace(scene.failure, heading=0.0),
    )  # fmt: skip
    assert fits(same)
    assert fits(at_start(scene))
    assert not fits(replace(scene, gravity=9.81))
    weaker = load(SCENE)
    weaker.character.muscles["lVAS"].f_max *= 0.5
    assert not fits(weaker)
    assert kept(measured, replace(scene, custom_controller="mine:steer"), imitation) is None
    initial = replace(scene.initial_state, file="start.h5")
    assert kept(measured, replace(scene, initial_state=initial), imitation) is None


def test_a_kept_gait_that_says_it_fits_and_does_not_is_refused_in_one_line(walker: Rollout, gait: Gait):
    imitation = Imitation(settle=1.0)
    found = kept(gait, walker.scene, imitation)
    less = dataclasses.replace(found, coordinate=found.coordinate[:, 1:])
    with pytest.raises(RolloutError, match=r"damaged policy: its gait has \d+ coordinates in 100 frames") as caught:
        gait_kept(less, walker, imitation)
    assert "\n" not in str(caught.value)
    longer = dataclasses.replace(found, coordinate=2.0 * found.coordinate)
    with pytest.raises(RolloutError, match=r"quaternions at \w+\.q\w whose length is not 1"):
        gait_kept(longer, walker, imitation)


@pytest.mark.parametrize("norm", IMITATED, ids=lambda norm: norm.source)
def test_hips_knees_and_ankles_bend_as_a_norm_says(walker: Rollout, norm):
    gait = gait_in(walker, Imitation(norm=norm.source, settle=1.0))
    percent = PERCENT_OF_BIN - 0.5
    names = walker.coordinate_names
    knee, ankle, hip = (gait.coordinate[:, names.index(name)] for name in ("lKnee", "lAnkle.0", "lHip.qx"))
    np.testing.assert_allclose(np.degrees(knee), norm.angles["Knee flexion"].mean(percent), atol=1e-6)
    np.testing.assert_allclose(np.degrees(-ankle), norm.angles["Ankle dorsiflexion"].mean(percent), atol=1e-6)
    w = gait.coordinate[:, names.index("lHip.qw")]
    np.testing.assert_allclose(-2 * np.degrees(np.arctan2(hip, w)), norm.angles["Hip flexion"].mean(percent), atol=1e-6)


@pytest.mark.long
def test_what_is_earned_is_the_mean_closeness_of_joints(batch: EpisodeBatch):
    batch.reset(1)
    phases = batch.episodes.phase.numpy().copy()
    assert len(set(phases.round(3))) > 5
    for _ in range(3):
        batch.step()
    np.testing.assert_allclose(batch.episodes.phase.numpy(), (phases + 0.03 * batch._rules.cycle_rate) % 1.0, atol=1e-5)
    table, q = batch.judge._rules.gait, batch.rollout.state.coordinates.numpy().astype(float)
    rows = (batch.episodes.phase.numpy() * BINS).astype(int)
    wanted = table.coordinate.numpy()[rows].astype(float)
    w, x, y, z = q[:, 6], q[:, 3], q[:, 4], q[:, 5]
    up = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1)
    total = table.up_weight * np.exp(-np.sum((up - table.up.numpy()[rows]) ** 2, axis=1) / 0.09)
    for first, end, weight in zip(table.first.numpy(), table.end.numpy(), table.weight.numpy(), strict=True):
        one, other = q[:, first:end], wanted[:, first:end]
        away = np.sum((one - other) ** 2, axis=1)
        if end - first == 4:
            away = 4.0 * (1.0 - np.sum(one * other, axis=1) ** 2)
        total += weight * np.exp(-away / 0.09)
    before = batch.judge.gains.sums.numpy()[:, IMITATION].copy()
    earned = batch.judge.gains.reward.numpy() / batch.dt
    np.testing.assert_allclose(earned, total, rtol=1e-4)
    assert before.min() > 2.0 * batch.dt  # as the controller's own gait is near


def test_the_clock_is_sine_and_cosine_of_the_phase(batch: EpisodeBatch):
    batch.reset(2)
    batch.step()
    seen = dict(zip(batch.senses.names, batch.senses.observation.numpy().T, strict=True))
    angle = 2.0 * np.pi * batch.episodes.phase.numpy()
    np.testing.assert_allclose(seen["clock.sin"], np.sin(angle), atol=1e-5)
    np.testing.assert_allclose(seen["clock.cos"], np.cos(angle), atol=1e-5)


@pytest.fixture(scope="module")
def by_speed() -> EpisodeBatch:
    """Bodies that are told to walk at several speeds, rewarded by the force on their feet alone."""
    rewards = Rewards(**(NOTHING | {"force": 1.0}), force_width=0.2, force_smoothing=0.03)
    task = Task(
        speed=(0.7, 1.8), observations={"clock": Sense()}, rewards=rewards, symmetric=True,
        imitation=Imitation(norm="key points", moving=True, cycle_time=1.03, cadence_power=0.58),
        variation=Variation(start_states=12, start_after=0.0, velocity_noise=0.0),
    )  # fmt: skip
    return EpisodeBatch(as_of_policy(), 12, "cpu", task, threads=1)


def test_the_clock_runs_as_people_step_at_the_wanted_speed(by_speed: EpisodeBatch):
    by_speed.reset(1)
    speed, before = by_speed.episodes.command.numpy()[:, 0].astype(float), by_speed.episodes.phase.numpy().copy()
    by_speed.step()
    gone = (by_speed.episodes.phase.numpy() - before) % 1.0
    assert np.ptp(speed) > 0.5
    np.testing.assert_allclose(gone, by_speed.dt / 1.03 * (speed / 1.25) ** 0.58, atol=1e-6)


def test_what_the_force_earns_is_the_closeness_of_smoothed_forces_to_peoples(by_speed: EpisodeBatch):
    by_speed.reset(1)
    speed = by_speed.episodes.command.numpy()[:, 0].astype(float)
    rows = np.rint((speed - 0.7) / (1.1 / (SPEEDS - 1))).astype(int)
    numeric = by_speed.rollout.numeric
    weight = numeric.gravity * sum(body.mass for body in numeric.character.bodies.values())
    share, smoothed, earned = 1.0 - np.exp(-by_speed.dt / 0.03), None, 0.0
    for _ in range(6):
        by_speed.step()
        load = np.maximum(by_speed.rollout.state.foot_force.numpy()[:, :, 1].astype(float) / weight, 0.0)
        smoothed = load if smoothed is None else smoothed + share * (load - smoothed)
        phase = by_speed.episodes.phase.numpy().astype(float)
        each = np.linspace(0.7, 1.8, SPEEDS)[rows]
        cycles = 1.03 * (each / 1.25) ** -0.58
        curves = np.stack([
            smoothed_over_cycle(walking_force(PERCENT_OF_BIN, v), cycle, 0.03)
            for v, cycle in zip(each, cycles, strict=True)
        ])  # fmt: skip
        bins = [((phase - lag) % 1.0 * BINS).astype(int) for lag in (0.0, 0.5)]
        wanted = np.stack([curves[np.arange(12), one] for one in bins], axis=1)
        earned += np.exp(-(((smoothed - wanted) / 0.2) ** 2)).mean(axis=1)
    found = by_speed.judge.gains.sums.numpy()[:, FORCE] / by_speed.dt
    lasted = by_speed.episodes.length.numpy() == 6
    assert lasted.sum() > 8
    assert np.ptp(load[lasted]) > 0.5
    np.testing.assert_allclose(found[lasted], earned[lasted], rtol=2e-4)


def test_the_force_of_a_run_is_half_a_sine_in_which_no_foot_carries_in_flight(gait: Gait):
    task = Task(imitation=Imitation(norm="Fukuchi 2017"), rewards=Rewards(force_smoothing=0.0))
    force = wanted_forces(gait, task, 3.0)
    stance = 50.0 / 1.4  # %, of a mean of 1.4 weights while a foot carries at 3 m/s (Munro et al. 1987)
    np.testing.assert_allclose(force, running_force(PERCENT_OF_BIN, stance), rtol=1e-9)
    assert (force[36:] == 0.0).all()
    assert force.max() == pytest.approx(0.5 * np.pi * 1.4, rel=0.01)
    for speed in (2.0, 3.0, 5.0):
        assert 2.0 * wanted_forces(gait, task, speed).mean() == pytest.approx(1.0, abs=0.01)
    assert (wanted_forces(gait, task, 5.0)[30:] == 0.0).all()  # 1.7 weights
    walking = msgspec.structs.replace(task, imitation=Imitation(norm="key points"))
    np.testing.assert_allclose(wanted_forces(gait, walking, 1.25), walking_force(PERCENT_OF_BIN, 1.25), rtol=1e-9)


def test_a_walk_becomes_a_run_in_its_angles_and_forces_above_a_speed(gait: Gait, walker: Rollout):
    """Between two of the tables' speeds, of which the slower one walks still."""
    run = ImitatedRun(above=2.1, cycle_time=0.7, clock_speed=2.5, cadence_power=0.1)
    imitation = Imitation(norm="key points", moving=True, run=run)
    task = Task(speed=(1.0, 3.2), imitation=imitation, rewards=Rewards(force_smoothing=0.03))
    both = changed(gait, walker, imitation, None)
    running = both.running
    assert running is not None
    assert running.runs
    assert not both.runs
    assert run_from(task) == pytest.approx(2.1)  # of 2.0 and 2.2
    slow, fast = (gait_at(both, task, walker, speed) for speed in (2.0, 2.2))
    np.testing.assert_allclose(slow.coordinate, with_norm(both, "key points", walker, 2.0).coordinate)
    np.testing.assert_allclose(fast.coordinate, with_norm(gait, "Fukuchi 2017", walker).coordinate)
    cycle = 0.7 * (2.2 / 2.5) ** -0.1
    force = smoothed_over_cycle(running_force(PERCENT_OF_BIN, 50.0 / (1.4 - 0.15 * 0.8)), cycle, 0.03)
    np.testing.assert_allclose(wanted_forces(both, task, 2.2), force)
    force = smoothed_over_cycle(walking_force(PERCENT_OF_BIN, 2.0), gait.cycle_time, 0.03)
    np.testing.assert_allclose(wanted_forces(both, task, 2.0), force)
    poses = np.stack([both.coordinate[30], running.coordinate[60]])
    np.testing.assert_allclose(both.nearest(poses, walker), [0.3, 0.6], atol=0.02)


def test_a_run_bends_as_people_do_at_its_speed_where_the_norm_moves(gait: Gait, walker: Rollout):
    """At 3.5 m/s hips bend 9 degrees more and knees 14 in swing than at 2.5 m/s; in between evenly, beyond no more."""
    alone = Imitation(norm="Fukuchi 2017", moving=True)
    after_walk = Imitation(norm="key points", moving=True, run=ImitatedRun(above=2.0))
    greatest = {}
    for imitation in (alone, after_walk):
        task, one = Task(speed=(1.0, 5.0), imitation=imitation), changed(gait, walker, imitation, None)
        for speed in (2.4, 3.0, 3.5, 4.5):
            moved = gait_at(one, task, walker, speed).coordinate
            joints = [leg_joints(walker.numeric, 0)[k] for k in (0, 1)]
            spans = [walker.names.joint_coordinates(walker.names.body_of_joint(name)) for name in joints]
            hip = np.degrees([-twist_angle(q, LEFT) for q in moved[:, spans[0]]])
            knee = np.degrees(np.abs(moved[:, spans[1]][:, 0]))
            greatest[imitation.norm, speed] = float(hip.max()), float(knee.max())
    for norm in ("Fukuchi 2017", "key points"):
        (hip, knee), (hip_at_3, knee_at_3), fast, faster = (greatest[norm, speed] for speed in (2.4, 3.0, 3.5, 4.5))
        assert (hip, knee) == pytest.approx((43.5, 92.6), abs=0.2)
        assert fast == pytest.approx((52.4, 106.5), abs=0.2)
        assert faster == fast
        assert (hip_at_3, knee_at_3) == pytest.approx((0.5 * (hip + fast[0]), 0.5 * (knee + fast[1])), abs=0.6)


def test_a_smoothed_curve_is_what_a_low_pass_makes_of_many_cycles():
    curve = walking_force(PERCENT_OF_BIN, 1.25)
    value, cycles = 0.0, np.tile(curve, 20)
    for now in cycles[:-1]:
        value += (1.0 - np.exp(-1.0 / BINS / 0.05)) * (now - value)
    last = value + (1.0 - np.exp(-1.0 / BINS / 0.05)) * (cycles[-1] - value)
    found = smoothed_over_cycle(curve, 1.0, 0.05)
    assert found[-1] == pytest.approx(last, rel=1e-6)
    assert found.mean() == pytest.approx(curve.mean(), rel=1e-6)
    np.testing.assert_allclose(smoothed_over_cycle(curve, 1.0, 0.0), curve, rtol=1e-12)


def test_a_norm_moves_with_the_speed_as_its_judge_has_it(walker: Rollout, gait: Gait):
    fast, percent = with_norm(gait, "key points", walker, 1.7), PERCENT_OF_BIN - 0.5
    more = trend("Knee flexion", dimensionless_speed(1.7, leg_length(walker.numeric)))
    knee = np.degrees(fast.coordinate[:, walker.coordinate_names.index("lKnee")])
    np.testing.assert_allclose(knee, WALKING[0].angles["Knee flexion"].mean(percent) + more[:BINS], atol=1e-6)
    assert more.max() > 1.0


def test_ankles_that_carry_are_as_far_apart_as_is_asked(walker: Rollout):
    even = gait_in(walker, Imitation(settle=1.0), BodySymmetry(walker))
    narrow = with_step_width(even, 0.08, walker).coordinate.copy()
    narrow[:, :7] = [0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 1.0]  # upright, in the air
    shown = Rollout(SCENE, BINS, "cpu", record=range(BINS), threads=1)
    shown.set_initial(coordinates=narrow)
    shown.step(1)
    shank = shown.names.bodies.index("lLowerleg")
    ankle = np.array(shown.numeric.character.joints["lAnkle"].position_in_parent, dtype=float)
    place = []
    for number in range(CARRYING):
        recording = shown.recording(number)
        q, at = recording.body_orientation[0, shank].astype(float), recording.body_position[0, shank].astype(float)
        place.append((at + rotate(q[None], ankle[None])[0])[0])
    assert np.mean(place) == pytest.approx(0.04, abs=0.003)


def test_a_pelvis_turns_as_peoples_while_legs_and_trunk_lean_as_they_did(walker: Rollout):
    mirrored = BodySymmetry(walker)
    even = gait_in(walker, Imitation(settle=1.0), mirrored)
    people = gait_in(walker, Imitation(settle=1.0, pelvis=True), mirrored)
    # Pinzone 2014, centre two, pelvis obliquity: 4.84 degrees at 10 %, -4.74 at 60 %, -0.64 at 40 % of the own cycle
    np.testing.assert_allclose(np.degrees(obliquity(people.up))[[10, 60, 40]], [4.84, -4.74, -0.64], atol=1e-6)
    before, after = (directions(walker, one.coordinate, one.up) for one in (even, people))
    for name, ways in before.items():
        np.testing.assert_allclose(after[name], ways, atol=1e-9, err_msg=name)
    assert len(before) == 3
    with_width = gait_in(walker, Imitation(settle=1.0, pelvis=True, step_width=0.08), mirrored)
    np.testing.assert_allclose(with_width.up, people.up, atol=1e-12)


def test_a_pelvis_leans_forwards_while_legs_and_trunk_lean_as_they_did(walker: Rollout):
    mirrored = BodySymmetry(walker)
    even = gait_in(walker, Imitation(settle=1.0), mirrored)
    leaning = gait_in(walker, Imitation(settle=1.0, pelvis_tilt=11.0), mirrored)
    np.testing.assert_allclose(np.degrees(tilt(leaning.up)), 11.0, atol=1e-9)
    before, after = (directions(walker, one.coordinate, one.up) for one in (even, leaning))
    for name, ways in before.items():
        np.testing.assert_allclose(after[name], ways, atol=1e-9, err_msg=name)
    bent = gait_in(walker, Imitation(settle=1.0, pelvis_tilt=11.0, norm="Pinzone 2014"), mirrored)
    hip = slice(*[walker.coordinate_names.index(f"lHip.{part}") for part in ("qx", "qw")])
    angle = 2.0 * np.arctan2(bent.coordinate[:, hip.start], bent.coordinate[:, hip.stop])
    assert -np.degrees(angle[0]) == pytest.approx(36.74, abs=1e-6)  # Pinzone 2014, centre two, at contact


def test_feet_are_flat_in_mid_stance_where_the_pelvis_leans_as_far_as_the_documentation_says():
    percent = np.arange(12.0, 33.0)
    walks = [norm for norm in IMITATED if not is_run(norm.source)]
    for norm, wanted in zip(walks, (4.0, 11.1, 10.8, 7.4), strict=True):
        hip, knee, ankle = (norm.angles[name].mean(percent) for name in LEG_ANGLES)
        pitch = hip - knee + ankle  # of the foot, toes up, over a pelvis that does not lean
        assert pitch.mean() == pytest.approx(wanted, abs=0.05), norm.source
        assert pitch.std() < 1.0, norm.source


def directions(rollout: Rollout, coordinate: Floats, up: Floats) -> dict[str, Floats]:
    """The vertical (n, 3) in every body that a ball joint hangs on the root; only its rotation matters."""
    found = {}
    for body, name in enumerate(rollout.names.joints, start=1):
        joint = rollout.numeric.character.joints[name]
        span = slice(*rollout.names.coordinate_start[body : body + 2])
        if joint.parent == rollout.numeric.character.root and joint_type(joint).quaternion:
            found[name] = rotate(conjugate(coordinate[:, span]), up)
    return found


def test_a_recorded_gait_is_that_of_the_motion_in_the_file(walker: Rollout, tmp_path):
    recording = walker.recording().window(0.0, 6.0)
    path = tmp_path / "walk.h5"
    write(path, Result(toml.dumps(walker.scene), "cpu", "", 0, no_parameters(), replays=(recording, recording)))
    found = recorded_gait(walker, Imitation(file=str(path), replay=1))
    own = imitated(measured_gait(recording, walker, Imitation(settle=0.0)), walker, Imitation(settle=0.0))
    first = walker.names.coordinate_start[1]
    np.testing.assert_allclose(found.coordinate[:, first:], own.coordinate[:, first:], atol=1e-6)
    assert found.cycle_time == pytest.approx(own.cycle_time)
    assert found.right == pytest.approx(own.right, abs=0.01)
    np.testing.assert_allclose(found.up, own.up, atol=1e-6)
    phases = found.nearest(np.stack([found.coordinate[7], own.coordinate[60]]), walker)
    np.testing.assert_allclose(phases, [0.07, 0.60], atol=0.011)


def test_files_that_are_no_gait_of_the_body_are_refused_in_a_line(walker: Rollout, tmp_path):
    recording, path = walker.recording(), tmp_path / "walk.h5"
    short, lean = recording.window(0.0, 0.3), reduced(recording, ["coordinate", "speed", "foot_force_left"])
    replays = (short, lean)
    write(path, Result(toml.dumps(walker.scene), "cpu", "", 0, no_parameters(), replays=replays))
    for replay, message in (
        (0, "has no whole gait cycle of the left foot"), (1, "the motion has no foot_force_right"),
        (2, "has 2 motions, none with number 2"),
    ):  # fmt: skip
        with pytest.raises(Error, match=message) as caught:
            recorded_gait(walker, Imitation(file=str(path), replay=replay))
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)
    with pytest.raises(Error, match="no such file"):
        recorded_gait(walker, Imitation(file=str(tmp_path / "none.h5")))
    other = Rollout("fwalk", 1, "cpu", threads=1)
    with pytest.raises(Error, match=r"no whole gait cycle|has no coordinate"):
        recorded_gait(other, Imitation(file=str(path), replay=0))
