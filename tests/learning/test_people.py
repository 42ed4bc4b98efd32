"""The gait of people by a norm alone: poses, speeds, and starts of an imported model that no controller moves."""

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.learning import EpisodeBatch, Imitation, Sense, Task, Variation
from warpmuscle.learning.imitation import BINS
from warpmuscle.learning.imitation.gait import _bend
from warpmuscle.learning.imitation.people import CYCLE_TIME, bounced, by_norm_alone, people_gait, people_states
from warpmuscle.scene import Body, Displacement, Joint, Scene
from warpmuscle.scene.character.shapes import Box
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.learning import ImitatedRun
from warpmuscle.scene.norms import NORMS, RUNNING, RUNNING_STANCE
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.inverse_dynamics import body_motions

SPEED = 1.3
IMITATION = Imitation(norm="key points")


def imported() -> Scene:
    """OpenSim's gait2392 as it is imported, with soles."""
    scene = load("gait2392")
    assert scene.simbicon is None
    sole = [Box(low=[-0.03, -0.045, -0.115], high=[0.03, -0.01, 0.08])]
    bodies = {
        name: msgspec.structs.replace(body, shapes=sole) if name.startswith("calcn") else body
        for name, body in scene.character.bodies.items()
    }
    character = msgspec.structs.replace(scene.character, bodies=bodies, feet=("calcn_l", "calcn_r"))
    return msgspec.structs.replace(scene, character=character)


@pytest.fixture(scope="module")
def rollout() -> Rollout:
    return Rollout(imported(), BINS, "cpu", threads=1)


def test_the_left_leg_bends_as_the_norm_says_and_the_right_one_half_a_cycle_later(rollout: Rollout):
    gait = people_gait(rollout, IMITATION)
    percent = np.arange(0.0, 100.0)
    for side, later in zip("lr", (0.0, 50.0), strict=True):
        at = (percent - later) % 100.0
        knee = gait.coordinate[:, rollout.coordinate_names.index(f"knee_angle_{side}")]
        ankle = gait.coordinate[:, rollout.coordinate_names.index(f"ankle_angle_{side}")]
        np.testing.assert_allclose(-np.degrees(knee), NORMS["Knee flexion"].mean(at), atol=0.2)
        np.testing.assert_allclose(np.degrees(ankle), NORMS["Ankle dorsiflexion"].mean(at), atol=0.8)
    assert gait.cycle_time == CYCLE_TIME == pytest.approx(1.026, abs=1e-3)
    assert gait.right == 0.5


def test_a_knee_that_two_coordinates_bend_is_bent_by_the_first_of_them():
    """It follows the toes, less far the more the foot is turned: -q + 0.2 q p."""
    scene = imported()
    character = scene.character
    knee, terms = character.joints["knee_angle_l"], [(-1.0, 1, 0), (0.2, 1, 1)]
    turn = Displacement((1.0, 0.0, 0.0), terms=terms)
    back = Displacement((1.0, 0.0, 0.0), terms=[(a, n, m) for a, m, n in terms])
    first, second = "mtp_angle_l", "subtalar_angle_l"
    leader = Joint("coupled", knee.parent, "half", knee.position_in_parent, (0.0, 0.0, 0.0), rotations=[turn],
                   follows=first, beside=second)  # fmt: skip
    rate = Joint("coupled", "half", knee.child, (0.0, 0.0, 0.0), knee.position_in_child, rotations=[back],
                 follows=second, beside=first, rate_only=True)  # fmt: skip
    others = {name: joint for name, joint in character.joints.items() if name != "knee_angle_l"}
    bodies = {**character.bodies, "half": Body(0.0, (0.0, 0.0, 0.0))}
    joints = {"bend": leader, "bend_rate": rate, **others}
    names = topology(msgspec.structs.replace(character, bodies=bodies, joints=joints, muscles={}))
    start = np.zeros((BINS, names.coordinates))
    turned = names.coordinate_start[names.body_of_joint(second)]
    start[:, turned] = 0.3
    wanted = -np.radians(NORMS["Knee flexion"].mean(np.arange(0.0, 100.0)))
    _bend(leader, names.body_of_joint("bend"), wanted, start, names)
    toes = start[:, names.coordinate_start[names.body_of_joint(first)]]
    np.testing.assert_allclose(toes * (-1.0 + 0.2 * 0.3), wanted, atol=1e-9)
    assert (start[:, turned] == 0.3).all()
    assert wanted.min() < -1.0


@pytest.mark.parametrize("tilt", [0.0, 11.0])
def test_states_stand_on_the_ground_and_move_on_as_the_next_ones_are(rollout: Rollout, tilt: float):
    imitation = msgspec.structs.replace(IMITATION, pelvis_tilt=tilt)
    states = people_states(people_gait(rollout, imitation), rollout, SPEED, BINS)
    assert len(states.coordinates) == BINS
    assert (states.speeds[:, :6] == [0.0, 0.0, SPEED, 0.0, 0.0, 0.0]).all()
    moved, character = body_motions(imported(), states.coordinates, states.speeds), imported().character
    lowest = []
    for side in "lr":
        foot, joint = moved[f"calcn_{side}"], character.joints[f"subtalar_angle_{side}"]
        corners = np.array([place for place, _ in contact_points(character.bodies[f"calcn_{side}"].shapes[0])])
        from_joint = np.tile(corners - joint.position_in_child, (BINS, 1))
        turned = Rotation.from_quat(foot.orientation.repeat(8, axis=0)).apply(from_joint)
        lowest.append(foot.position[:, 1] + turned.reshape(BINS, 8, 3)[:, :, 1].min(axis=1))
    np.testing.assert_allclose(np.min(lowest, axis=0), 0.0, atol=1e-9)
    fastest = {}
    for name, body in moved.items():
        after, before = (Rotation.from_quat(np.roll(body.orientation, shift, axis=0)) for shift in (-1, 1))
        turning = (after * before.inv()).as_rotvec() * (BINS / (2.0 * CYCLE_TIME))
        np.testing.assert_allclose(body.angular_velocity, turning, atol=0.05, err_msg=name)
        fastest[name] = np.abs(turning).max()
    assert fastest["tibia_l"] > 4.0  # rad/s, in swing
    assert fastest["torso"] < 1e-9
    turned = {name: Rotation.from_quat(moved[name].orientation).as_rotvec(degrees=True) for name in ("pelvis", "torso")}
    np.testing.assert_allclose(turned["pelvis"], np.tile([tilt, 0.0, 0.0], (BINS, 1)), atol=1e-9)
    np.testing.assert_allclose(turned["torso"], 0.0, atol=1e-9)


RUN = Imitation(norm="Fukuchi 2017", norm_alone=True, cycle_time=0.7, pelvis_tilt=5.0)


def test_a_runner_bounces_as_a_mass_that_half_a_sine_of_force_carries(rollout: Rollout):
    """In flight it falls freely; over a stance its speed turns from down to up; a cycle has two bounces."""
    gait = people_gait(rollout, RUN)
    above, rise = bounced(gait, 9.81, RUNNING_STANCE)
    assert above.mean() == pytest.approx(0.0, abs=1e-12)
    flight = 0.01 * (50.0 - RUNNING_STANCE) * 0.7  # s
    assert -rise[0] == pytest.approx(0.5 * 9.81 * flight, rel=0.02)
    np.testing.assert_allclose(np.diff(rise[40:51]), -9.81 * 0.7 / BINS, rtol=1e-3)
    np.testing.assert_allclose(above, np.roll(above, BINS // 2), atol=1e-9)
    assert above[20] == above.min()  # in the middle of the stance
    assert above[45] == pytest.approx(above.max())
    height = 9.81 * flight**2 / 8.0
    assert above[45] - above[40] == pytest.approx(height, rel=0.02)


def test_states_of_a_run_bend_as_runners_do_and_none_is_below_the_ground(rollout: Rollout):
    states = people_states(people_gait(rollout, RUN), rollout, 3.0, BINS)
    knee = states.coordinates[:, rollout.coordinate_names.index("knee_angle_l")]
    np.testing.assert_allclose(
        -np.degrees(knee), RUNNING[0].angles["Knee flexion"].mean(np.arange(0.0, 100.0)), atol=0.2
    )
    root = states.coordinates[:, 1]
    np.testing.assert_allclose(root, np.roll(root, BINS // 2), atol=1e-9)
    assert root[np.arange(40, 50)].min() > root[np.arange(10, 25)].max() + 0.03
    assert (states.speeds[:, 2] == 3.0).all()
    assert states.speeds[0, 1] < -0.3 < 0.3 < states.speeds[35, 1]
    moved, character = body_motions(imported(), states.coordinates, states.speeds), imported().character
    for side in "lr":
        corners = np.array([place for place, _ in contact_points(character.bodies[f"calcn_{side}"].shapes[0])])
        foot, joint = moved[f"calcn_{side}"], character.joints[f"subtalar_angle_{side}"]
        turned = Rotation.from_quat(foot.orientation.repeat(8, axis=0)).apply(
            np.tile(corners - joint.position_in_child, (BINS, 1))
        )
        assert (foot.position[:, 1] + turned.reshape(BINS, 8, 3)[:, :, 1].min(axis=1)).min() > -1e-9


def test_a_norm_alone_does_not_look_at_the_controller_of_a_scene_that_has_one():
    scene = load("walk56_person")
    assert scene.simbicon is not None
    assert not by_norm_alone(scene, Imitation(norm="key points"))
    assert by_norm_alone(scene, Imitation(norm="key points", norm_alone=True))
    assert not by_norm_alone(scene, Imitation(norm="key points", norm_alone=True, file="walk.h5"))


def test_a_norm_needs_feet_and_nothing_without_shapes_can_stand_on_them():
    with pytest.raises(SceneError, match="a gait is imitated with two feet") as caught:
        EpisodeBatch("gait2392", 1, "cpu", Task(imitation=IMITATION))
    assert caught.value.key == "learning.imitation"
    scene = imported()
    bodies = {name: msgspec.structs.replace(body, shapes=[]) for name, body in scene.character.bodies.items()}
    bare = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, bodies=bodies))
    flying = Task(imitation=IMITATION, variation=Variation(start_states=4))
    with pytest.raises(SceneError, match="no body has a shape to stand on") as caught:
        EpisodeBatch(bare, 1, "cpu", flying)
    assert caught.value.key == "learning.variation.start_states"


@pytest.mark.usefixtures("unoptimized_test")
def test_episodes_start_over_the_whole_cycle_with_the_clock_of_their_pose():
    task = Task(
        observations={"clock": Sense()}, imitation=IMITATION, speed=(SPEED, SPEED),
        variation=Variation(start_states=20, velocity_noise=0.0),
    )  # fmt: skip
    batch = EpisodeBatch(imported(), 60, "cpu", task, threads=1)
    gait, phase = batch.gait, batch.episodes.phase.numpy()
    assert gait is not None
    knee = batch.rollout.coordinate_names.index("knee_angle_l")
    bent = batch.rollout.state.coordinates.numpy()[:, knee]
    walking = batch.rollout.state.speeds.numpy()[:, 2] > 0.0  # others start as the scene does
    assert 40 < walking.sum() < 60
    np.testing.assert_allclose(
        bent[walking], gait.coordinate[np.round(phase[walking] * BINS).astype(int), knee], atol=1e-5
    )
    assert len(set(phase[walking].round(4))) > 12


@pytest.mark.usefixtures("unoptimized_test")
def test_who_walks_and_runs_starts_as_either_and_the_clock_runs_as_the_wanted_speed_says():
    run = ImitatedRun(above=2.05, cycle_time=0.7, clock_speed=2.5, cadence_power=0.1)
    imitation = msgspec.structs.replace(IMITATION, cycle_time=1.0, cadence_power=0.5, pelvis_tilt=5.0, run=run)
    task = Task(
        observations={"clock": Sense()}, imitation=imitation, speed=(1.0, 3.2),
        variation=Variation(start_states=20, velocity_noise=0.0),
    )  # fmt: skip
    batch = EpisodeBatch(imported(), 60, "cpu", task, threads=1)
    forward = batch.rollout.state.speeds.numpy()[:, 2]
    starts, counts = np.unique(forward[forward > 0.0].round(3), return_counts=True)
    np.testing.assert_allclose(starts, [1.55, 2.65])  # the middles of 1.0 to 2.1 and of 2.1 to 3.2 m/s
    assert counts.min() > 10
    speed, before = batch.episodes.command.numpy()[:, 0].astype(float), batch.episodes.phase.numpy().copy()
    gait, knee = batch.gait, batch.rollout.coordinate_names.index("knee_angle_l")
    assert gait is not None
    assert gait.running is not None
    bent, at = batch.rollout.state.coordinates.numpy()[:, knee], np.round(before * BINS).astype(int) % BINS
    for one, each in ((gait, starts[0]), (gait.running, starts[1])):
        here = np.abs(forward - each) < 0.01
        np.testing.assert_allclose(bent[here], one.coordinate[at[here], knee], atol=1e-5)
    batch.step(restart=False)
    gone = (batch.episodes.phase.numpy() - before) % 1.0
    rate = np.where(speed >= 2.1, (speed / 2.5) ** 0.1 / 0.7, (speed / 1.25) ** 0.5)
    assert 10 < (speed >= 2.1).sum() < 50
    np.testing.assert_allclose(gone, batch.dt * rate, atol=1e-5)
