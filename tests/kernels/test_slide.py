"""Slides against MuJoCo: accelerations, mass matrix and motion of an arm with slides among its hinges; and limits."""

import re
from typing import Any

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import mjcf, save
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.scene import (
    PD,
    Actuation,
    Body,
    Character,
    Component,
    Controller,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    MuscleModel,
    Scene,
    State,
    Trajectory,
    ViaPoint,
)
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

ORIGIN = (0.0, 0.0, 0.0)
STILL = Failure(com_height=0.0, heading=0.0, max_com_speed=1000.0)


def body(mass: float) -> Body:
    return Body(mass, (0.02 * mass, 0.015 * mass, 0.01 * mass))


def arm(root: str = "fixed") -> Scene:
    """A carriage on an oblique rail, an upper arm on a hinge, a forearm that slides out of it, a hand on a ball."""
    bodies = {"base": body(4.0), "carriage": body(2.0), "upper": body(1.5), "fore": body(1.0), "hand": body(0.5)}
    joints = {
        "rail": Joint("slide", "base", "carriage", (0.1, 0.0, 0.2), (0.0, 0.05, 0.0), [(0.6, 0.2, -0.7)]),
        "shoulder": Joint("hinge", "carriage", "upper", (0.0, -0.1, 0.05), (0.02, 0.15, 0.0), [(1.0, 0.3, 0.2)]),
        "telescope": Joint("slide", "upper", "fore", (0.01, -0.2, 0.03), (0.0, 0.1, 0.02), [(0.1, -0.9, 0.3)]),
        "wrist": Joint("ball", "fore", "hand", (0.0, -0.12, 0.0), (0.0, 0.06, 0.01)),
    }
    start = InitialState(
        joints={
            "rail": JointState(coordinate=0.15, speed=-0.4),
            "shoulder": JointState((0.3, 0.0, 0.0, 0.95), (1.0, 0.3, 0.2)),
            "telescope": JointState(coordinate=-0.05, speed=0.6),
            "wrist": JointState((0.1, 0.2, -0.1, 0.9), (1.0, -2.0, 0.5)),
        }
    )
    torque = {name: Actuation("torque") for name in joints}
    character = Character("base", bodies, joints, root)
    return Scene(
        "arm",
        character,
        initial_state=start,
        ground=Ground(stiffness=0.0),
        failure=STILL,
        actuation=torque,
        duration=1.0,
    )


def at_start(scene: Scene) -> tuple[Any, Any]:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("root", ["fixed", "planar"])
def test_accelerations_and_inertia_are_those_of_mujoco(root: str):
    mujoco = pytest.importorskip("mujoco")
    scene = arm(root)
    model, data = at_start(scene)
    stages = Stages(scene, 1, "cpu")
    rates = stages.forward_dynamics()["speed_rate"][0]
    np.testing.assert_allclose(rates, data.qacc, rtol=2e-5, atol=2e-4)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    np.testing.assert_allclose(stages.mass_matrix()[0], full, atol=2e-6)


def test_forces_along_slides_accelerate_them_as_in_mujoco():
    mujoco = pytest.importorskip("mujoco")
    scene = arm()
    model, data = at_start(scene)
    efforts = np.array([3.0, -0.5, 4.0, 0.02, -0.03, 0.01])
    data.qfrc_applied[:] = efforts
    mujoco.mj_forward(model, data)
    needed = inverse_dynamics(scene, *(part[None] for part in (ours(scene), data.qvel, data.qacc)))
    np.testing.assert_allclose(needed[0], efforts, atol=1e-9)


def ours(scene: Scene) -> np.ndarray:
    """Coordinates of the initial state in double precision."""
    from warpmuscle.model.build import start_of
    from warpmuscle.scene.topology import topology

    return start_of(scene, topology(scene.character)).coordinates[0]


def test_a_second_of_free_motion_is_that_of_mujoco():
    mujoco = pytest.importorskip("mujoco")
    scene = arm()
    model, data = at_start(scene)
    model.opt.timestep, model.opt.integrator = 1.0e-4, mujoco.mjtIntegrator.mjINT_RK4
    mujoco.mj_step(model, data, 10000)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    q = rollout.state.coordinates.numpy()[0, 7:]
    expected = [data.qpos[0], data.qpos[1], data.qpos[2], *np.roll(data.qpos[3:7], -1)]
    np.testing.assert_allclose(q[:3], expected[:3], rtol=1e-3, atol=1e-3)
    assert abs(q[3:] @ expected[3:]) > 0.9999
    bodies = rollout.recording(0).body_position[-1] - rollout.recording(0).body_position[0]
    assert np.abs(bodies[1:]).max() > 0.3


def test_a_kinematic_slide_moves_as_told_and_pulls_the_rest_along():
    scene = arm()
    scene.actuation["rail"] = Actuation("kinematic")
    time = np.linspace(0.0, 1.0, 11)
    scene.motion = {"rail": Motion(time.tolist(), value=(0.15 + 0.2 * np.sin(3.0 * time)).tolist())}
    rollout = Rollout(scene, 1, "cpu", record=[0], quantities=["coordinates", "speeds"])
    rollout.run(0.5)
    q, v = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))
    np.testing.assert_allclose(q[:50, 7], 0.15 + 0.2 * np.sin(3.0 * np.arange(50) * 0.01), atol=2e-4)
    middle, h = 25, 0.01
    a = (v[middle + 1] - v[middle - 1]) / (2.0 * h)
    needed = inverse_dynamics(scene, q[middle : middle + 1], v[middle : middle + 1], a[None])[0]
    assert np.abs(needed[1:]).max() < 0.03 * np.abs(needed[0])  # only the rail is driven


def test_limits_stop_a_slide_with_newtons_a_metre():
    scene = arm()
    rail = scene.character.joints["rail"]
    rail.axes, rail.limits, rail.limit_stiffness, rail.limit_damping = [(0.0, 1.0, 0.0)], [(-0.1, 0.1)], 2.0e4, 400.0
    for name in ("shoulder", "telescope", "wrist"):
        scene.character.joints[name].type, scene.character.joints[name].axes = "fixed", []
        del scene.initial_state.joints[name], scene.actuation[name]
    scene.initial_state.joints["rail"] = JointState(coordinate=-0.1)
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    rest = -0.1 - 5.0 * 9.8 / 2.0e4
    np.testing.assert_allclose(rollout.state.coordinates.numpy()[0, 7], rest, atol=1e-5)


def test_a_muscle_along_a_slide_pulls_with_its_whole_force():
    scene = arm()
    for name in ("shoulder", "telescope", "wrist"):
        scene.character.joints[name].type, scene.character.joints[name].axes = "fixed", []
        del scene.initial_state.joints[name], scene.actuation[name]
    points = [ViaPoint("base", (0.1, 0.0, 0.2)), ViaPoint("carriage", (0.7, 0.2, -0.6))]
    scene.character.muscles = {"puller": Muscle(path=points, f_max=100.0, l_opt=0.3, l_slack=0.2)}
    scene.muscle_model, scene.actuation = MuscleModel(), {}
    stages = Stages(scene, 1, "cpu")
    paths = stages.muscle_paths()

    def length(q: float) -> float:
        axis = np.array([0.6, 0.2, -0.7]) / np.linalg.norm([0.6, 0.2, -0.7])
        joint = np.array([0.1, 0.0, 0.2]) + q * axis
        return float(np.linalg.norm(joint + np.array([0.7, 0.15, -0.6]) - np.array([0.1, 0.0, 0.2])))

    slope = (length(0.15 + 1e-6) - length(0.15 - 1e-6)) / 2e-6
    np.testing.assert_allclose(paths.length[0, 0], length(0.15), rtol=1e-6)
    np.testing.assert_allclose(paths.speed[0, 0], -0.4 * slope, rtol=1e-5)
    axis = np.array([0.6, 0.2, -0.7]) / np.linalg.norm([0.6, 0.2, -0.7])
    np.testing.assert_allclose(paths.moment_arm[0, 0], axis * slope, rtol=1e-5)


def on_rail() -> Scene:
    """The carriage alone on a rail, with a controller that holds it; nothing else moves."""
    scene = arm()
    for name in ("shoulder", "telescope", "wrist"):
        scene.character.joints[name].type, scene.character.joints[name].axes = "fixed", []
        del scene.initial_state.joints[name], scene.actuation[name]
    scene.character.joints["rail"].axes = [(0.0, 1.0, 0.0)]
    return scene


@pytest.mark.parametrize("implicit", [False, True])
def test_pd_holds_a_slide_at_the_target_of_its_trajectory(implicit: bool):
    scene = on_rail()
    scene.initial_state.root_position = (0.0, 2.0, 0.0)  # above where torques fade
    scene.implicit_pd = implicit
    target = Trajectory([Component((0.0, 1.0, 0.0), [0.0], [0.05])])
    scene.controller = Controller(
        states=[State(time=1.0, trajectories={"rail": target})],
        pd={"rail": PD(kp=5000.0, kd=300.0)},
        feet=("carriage", "hand"),
        hips=("rail", "wrist"),
    )
    scene.character.joints["wrist"] = Joint("fixed", "base", "hand", ORIGIN, ORIGIN)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    q = rollout.state.coordinates.numpy()[0, 7]
    np.testing.assert_allclose(q, 0.05 - 4.5 * 9.8 / 5000.0, atol=1e-4)
    last = rollout.recording(0).joint_torque[-1, 0]
    np.testing.assert_allclose(last, [0.0, -4.5 * 9.8, 0.0], atol=0.5)  # a force on the parent
    assert joint_angles(rollout.recording(0), scene.character, "rail")[-1, 0] == pytest.approx(q, abs=1e-3)


def test_an_effort_is_a_force_along_the_slide():
    scene = on_rail()
    rollout = Rollout(scene, 1, "cpu")
    rollout.step(200, torques=np.array([[5.0 * 9.8 + 10.0]]))
    np.testing.assert_allclose(rollout.state.speeds.numpy()[0, 0], -0.4 + 0.1 * 10.0 / 5.0, atol=1e-4)


def test_free_parameters_of_a_slide_differ_by_instance():
    scene = on_rail()
    scene.initial_state.joints["rail"] = JointState(coordinate=Free(0.1, 0.0, 0.2), speed=Free(0.0, -1.0, 1.0))
    rollout = Rollout(scene, 2, "cpu")
    rollout.set_parameters(np.array([[0.1, 0.0], [0.2, 1.0]]))
    rollout.run(0.1)
    expected = np.array([0.1, 0.2 + 0.1]) - 0.5 * 9.8 * 0.1**2
    np.testing.assert_allclose(rollout.state.coordinates.numpy()[:, 7], expected, atol=1e-4)


@pytest.mark.parametrize(
    ("field", "value", "key", "words"),
    [
        ("axes", [], "axes", "a slide joint takes 1 axes, got 0"),
        ("limits", [(0.0, 1.0)] * 2, "limits", "a slide joint takes 1 limits or none, got 2"),
        ("type", "slid", "type", "did you mean 'slide'?"),
    ],
)
def test_what_is_wrong_with_a_slide_is_said(field: str, value: object, key: str, words: str):
    scene = arm()
    setattr(scene.character.joints["rail"], field, value)
    with pytest.raises(SceneError, match=re.escape(words)) as caught:
        Rollout(scene, 1, "cpu")
    assert caught.value.key == f"character.joints.rail.{key}"


def test_a_slide_starts_from_a_coordinate_and_a_hinge_from_an_orientation():
    scene = arm()
    scene.initial_state.joints["rail"] = JointState((0.1, 0.0, 0.0, 0.99))
    with pytest.raises(SceneError, match="a slide joint starts from `coordinate` and `speed`"):
        Rollout(scene, 1, "cpu")
    scene.initial_state.joints["rail"] = JointState()
    scene.initial_state.joints["shoulder"] = JointState(coordinate=0.1)
    with pytest.raises(SceneError, match="a hinge joint starts from `orientation` and `angular_velocity`"):
        Rollout(scene, 1, "cpu")


def test_the_original_programs_files_have_no_slides(tmp_path):
    with pytest.raises(SceneError, match="this format has no slide joint"):
        save(arm(), tmp_path / "arm.rbs")


def test_a_spring_along_a_slide_carries_its_load_from_its_rest():
    scene = on_rail()
    scene.actuation["rail"] = Actuation("passive", stiffness=2000.0, damping=150.0, rest=(0.0, 0.03, 0.0))
    scene.duration = 2.0
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    np.testing.assert_allclose(rollout.state.coordinates.numpy()[0, 7], 0.03 - 5.0 * 9.8 / 2000.0, atol=1e-4)


def test_single_stages_take_coordinates_of_slides():
    scene = arm()
    stages, upright = Stages(scene, 2, "cpu"), np.array([0.0, 0.0, 0.0, 1.0])
    stages.set_state(
        np.zeros(3), upright, np.zeros(3), np.zeros(3), np.tile(upright, (4, 1)), np.zeros((4, 3)),
        joint_coordinate=[[0.1, 0.0, 0.0, 0.0], [0.3, 0.0, 0.2, 0.0]], joint_speed=[2.0, 0.0, 0.0, 0.0],
    )  # fmt: skip
    pose, rail = stages.forward_kinematics(), np.array([0.6, 0.2, -0.7]) / np.linalg.norm([0.6, 0.2, -0.7])
    np.testing.assert_allclose(pose["position"][1, 1] - pose["position"][0, 1], 0.2 * rail, atol=1e-6)
    np.testing.assert_allclose(pose["velocity"][:, 1:], np.tile(2.0 * rail, (2, 4, 1)), atol=1e-6)
