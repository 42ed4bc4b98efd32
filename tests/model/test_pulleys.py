"""Muscles on pulleys: lengths and moment arms, torques, what MuJoCo makes of them, and errors."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from muscle_arm import arm, muscle
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.save import save
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import JointState, Muscle, Pulley, Scene, ViaPoint
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.validation.muscles import initial_path_lengths, slack_warnings
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import moment_arms

GIVEN = {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1, "rest_length": 0.26}


def pulleyed(kind: str = "hinge", *pulleys: Pulley, **properties) -> Scene:
    """The arm with a muscle on pulleys, by default over the first angle, besides its two others."""
    scene = arm(kind)
    over = list(pulleys) or [Pulley("elbow", 0.03, 0.2)]
    scene.character.muscles["winch"] = Muscle(pulleys=over, **(GIVEN | properties))
    return scene


def at(scene: Scene, angles: np.ndarray, rates: np.ndarray) -> Stages:
    """States with these angles and rates (n, k) of the elbow."""
    stages = Stages(scene, len(angles), "cpu")
    coordinates, speeds = stages.state.coordinates.numpy().copy(), stages.state.speeds.numpy().copy()
    coordinates[:, 7:], speeds[:] = angles, rates
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(speeds)
    return stages


def drawn(count: int, axes: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(axes)
    return rng.uniform(-1.0, 1.0, (count, axes)), rng.normal(size=(count, axes))


def test_length_and_speed_follow_the_angle():
    q, v = drawn(20, 1)
    paths = at(pulleyed(), q, v).muscle_paths()
    np.testing.assert_allclose(paths.length[:, 2], 0.26 - 0.03 * (q[:, 0] - 0.2), atol=1e-7)
    np.testing.assert_allclose(paths.speed[:, 2], -0.03 * v[:, 0], atol=1e-7)


def test_pulleys_over_both_angles_of_a_universal_joint_add_up():
    q, v = drawn(20, 2)
    scene = pulleyed("universal", Pulley("elbow", 0.03, 0.2), Pulley("elbow", -0.02, -0.1, axis=1))
    paths = at(scene, q, v).muscle_paths()
    length = 0.26 - 0.03 * (q[:, 0] - 0.2) + 0.02 * (q[:, 1] + 0.1)
    np.testing.assert_allclose(paths.length[:, 2], length, atol=1e-7)
    np.testing.assert_allclose(paths.speed[:, 2], -0.03 * v[:, 0] + 0.02 * v[:, 1], atol=2e-7)
    assert [paths.muscle.count(i) for i in range(3)] == [1, 1, 1]  # one crossing each


@pytest.mark.parametrize(("axis", "expected"), [(0, 0.03), (1, -0.02)])
def test_moment_arms_are_constant(axis: int, expected: float):
    scene = pulleyed("universal", Pulley("elbow", 0.03, 0.2), Pulley("elbow", -0.02, -0.1, axis=1))
    turn = tuple((np.array([0.2, 0.1, 0.3, 0.9]) / np.linalg.norm([0.2, 0.1, 0.3, 0.9])).tolist())
    scene.initial_state.joints = {"elbow": JointState(turn)}
    arms = moment_arms(scene, "elbow", axis, np.linspace(-0.8, 0.8, 9))
    np.testing.assert_allclose(arms.arm[:, arms.muscles.index("winch")], expected, rtol=1e-5)


def test_muscle_on_a_pulley_turns_its_joint_as_force_times_moment_arm():
    """Angular acceleration of the hanging arm in the first step, the pulley's muscle alone pulling (eq. 3 to 9)."""
    scene = pulleyed()
    scene.character.muscles = {"winch": scene.character.muscles["winch"]}
    scene.gravity, scene.muscle_model.initial_activation, scene.muscle_model.fall_time = 0.0, 0.5, 1e6
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run(0.0005)
    force = rollout.recording().muscle_force[0, 0]
    x = (0.26 + 0.03 * 0.2 - 0.1) / 0.15
    passive = (math.exp(4.0 * (x - 1.0) / 0.6) - 1.0) / (math.exp(4.0) - 1.0)
    assert force == pytest.approx(400.0 * (0.5 * math.exp(-((x - 1.0) ** 2) / 0.5) + passive), rel=1e-4)
    about_joint = 0.03 + 2.0 * 0.2**2
    assert rollout.state.accelerations.numpy()[0, 0] == pytest.approx(force * 0.03 / about_joint, rel=1e-4)


def test_muscle_over_two_joints_does_the_work_that_its_shortening_takes():
    scene = pulleyed("universal", Pulley("elbow", 0.03), Pulley("elbow", 0.05, axis=1))
    q, v = drawn(30, 2)
    stages = at(scene, q, v)
    paths, joint_velocity = stages.muscle_paths(), stages.forward_kinematics()["angular_velocity"]
    k = paths.muscle.index(2)
    power = np.sum(paths.moment_arm[:, k].astype(float) * (joint_velocity[:, 1] - joint_velocity[:, 0]), axis=1)
    np.testing.assert_allclose(power, paths.speed[:, 2], atol=1e-6)


def test_mujoco_computes_the_same_lengths_and_moment_arms(mujoco_oracle):
    mujoco, compile_model = mujoco_oracle.mujoco, mujoco_oracle.compile_model
    scene = pulleyed("universal", Pulley("elbow", 0.03, 0.2), Pulley("elbow", -0.02, -0.1, axis=1))
    q, v = drawn(10, 2)
    paths, model = at(scene, q, v).muscle_paths(), compile_model(scene)
    data, tendon = mujoco.MjData(model), model.tendon("winch").id
    reference = 0.26 + 0.03 * 0.2 + 0.02 * 0.1 * 1.0
    for i in range(10):
        for axis, suffix in enumerate("ab"):
            data.qpos[model.joint(f"elbow_{suffix}").qposadr[0]] = q[i, axis]
            data.qvel[model.joint(f"elbow_{suffix}").dofadr[0]] = v[i, axis]
        mujoco.mj_forward(model, data)
        assert data.ten_length[tendon] + reference == pytest.approx(paths.length[i, 2], abs=1e-6)
        assert data.ten_velocity[tendon] == pytest.approx(paths.speed[i, 2], abs=1e-6)
    optimal = 0.1 + 0.15 - reference
    low, high = model.actuator("winch").lengthrange
    assert low < optimal < high


def test_every_number_of_a_pulley_may_be_free():
    pulley = Pulley("elbow", Free(0.03, 0.01, 0.05), Free(0.2, -1.0, 1.0))
    scene = pulleyed("hinge", pulley, rest_length=Free(0.26, 0.2, 0.3))
    names = [parameter.name.removeprefix("character.muscles.winch.") for parameter in free_parameters(scene)]
    assert names == ["pulleys.0.moment_arm", "pulleys.0.rest_angle", "rest_length"]
    stages = Stages(scene, 2, "cpu")
    stages.set_parameters([[0.03, 0.2, 0.26], [0.02, -0.3, 0.22]])
    np.testing.assert_allclose(stages.muscle_paths().length[:, 2], [0.26 + 0.03 * 0.2, 0.22 - 0.02 * 0.3], atol=1e-7)
    assert [parameter.unit for parameter in free_parameters(scene)] == ["m", "rad", "m"]


def test_a_pulley_muscle_is_read_back_as_written():
    scene = pulleyed("universal", Pulley("elbow", 0.03, 0.2), Pulley("elbow", -0.02, axis=1))
    assert loads(dumps(scene)) == scene


def test_length_in_the_initial_pose_and_a_slack_tendon_are_known():
    scene = pulleyed(l_slack=0.3)
    scene.initial_state.joints = {"elbow": JointState((math.sin(0.2), 0.0, 0.0, math.cos(0.2)))}
    assert initial_path_lengths(scene)["winch"] == pytest.approx(0.26 - 0.03 * (0.4 - 0.2))
    assert [warning.key for warning in slack_warnings(scene)] == ["character.muscles.winch.l_slack"]


HERE = [ViaPoint("base", (0.0, 0.1, 0.0)), ViaPoint("tip", (0.0, 0.1, 0.0))]


@pytest.mark.parametrize(
    ("changes", "key", "message"),
    [
        ({"path": HERE}, ".pulleys", "either a `path` or `pulleys`"),
        ({"pulleys": []}, ".rest_length", "only a muscle with pulleys has a rest length"),
        ({"pulleys": [], "rest_length": None}, "", "needs a `path`, `pulleys` and"),
        ({"rest_length": None}, "", "needs a `rest_length`"),
        ({"rest_length": 0.0}, ".rest_length", "must be greater than 0"),
        ({"pulleys": [Pulley("knee", 0.03)]}, ".pulleys.0.joint", "there is no joint 'knee'"),
        ({"pulleys": [Pulley("elbow", 0.03, axis=1)]}, ".pulleys.0.axis", "a hinge joint has no angle 1"),
    ],
)
def test_muscles_without_a_proper_route_are_refused(changes: dict, key: str, message: str):
    scene = pulleyed()
    scene.character.muscles["winch"] = replace(scene.character.muscles["winch"], **changes)
    with pytest.raises(SceneError, match=message) as caught:
        check_scene(scene)
    assert caught.value.key == f"character.muscles.winch{key}"


def test_a_ball_joint_has_no_angle_for_a_pulley():
    with pytest.raises(SceneError, match="a ball joint has no angle for a pulley"):
        check_scene(pulleyed("ball"))


def test_files_of_the_original_program_hold_no_pulleys(tmp_path):
    with pytest.raises(SceneError, match="has no pulleys"):
        save(pulleyed(), tmp_path / "arm.rbs")
    assert not list(tmp_path.iterdir())


def test_paths_through_points_are_untouched_by_pulleys_beside_them():
    q, v = drawn(5, 1)
    beside, alone = (at(scene, q, v).muscle_paths() for scene in (pulleyed(), arm()))
    assert np.array_equal(beside.length[:, :2], alone.length)
    assert muscle(("base", (0.0, 0.2, 0.04)), ("tip", (0.0, 0.1, 0.04))).pulleys == []
