"""Joints coupled to one coordinate against OpenSim 4.6: pose, mass matrix and accelerations; and what acts on them.

The numbers are from `opensim` 4.6 (PyPI): a thigh on a PinJoint about z at (0.1, 0.9, 0) of the ground, a shank on a
CustomJoint, gravity 9.80665 m/s^2. `knee` has the functions of knee_r in gait10dof18musc.osim (opensim-models @20a888b,
CC BY 3.0); `general` has three rotations and three translations along oblique axes.
"""

import re

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.formats import load, mjcf, save
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    Displacement,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    Scene,
    ViaPoint,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
KNEE_X = (
    [-2.0944, -1.74533, -1.39626, -1.0472, -0.698132, -0.349066, -0.174533, 0.197344, 0.337395, 0.490178, 1.52146,
     2.0944],
    [-0.0032, 0.00179, 0.00411, 0.0041, 0.00212, -0.001, -0.0031, -0.005227, -0.005435, -0.005574, -0.005435, -0.00525],
)  # fmt: skip
KNEE_Y = (
    [-2.0944, -1.22173, -0.523599, -0.349066, -0.174533, 0.159149, 2.0944],
    [-0.4226, -0.4082, -0.399, -0.3976, -0.3966, -0.395264, -0.396],
)


def spline(axis, knots) -> Displacement:
    return Displacement(axis, x=list(knots[0]), y=list(knots[1]))


def knee() -> Joint:
    turns, moves = [Displacement(Z, slope=1.0)], [spline(X, KNEE_X), spline(Y, KNEE_Y)]
    return Joint("coupled", "thigh", "shank", ORIGIN, ORIGIN, rotations=turns, translations=moves)


def general() -> Joint:
    turns = [
        Displacement((0.0, 0.6, 0.8), 0.1, 1.2),
        spline((0.8, 0.0, 0.6), ([-2.0, -1.0, 0.0, 1.0, 2.0], [-0.3, 0.1, 0.2, -0.1, 0.4])),
        Displacement((0.6, 0.8, 0.0), 0.3),
    ]
    moves = [
        spline((0.8, 0.6, 0.0), ([-2.0, -1.0, 0.5, 2.0], [0.02, -0.01, 0.03, 0.0])),
        Displacement((0.0, 0.8, -0.6), -0.4, 0.03),
        spline((0.6, 0.0, -0.8), ([-1.5, 0.0, 1.5], [0.0, 0.02, -0.03])),
    ]
    places = (0.01, -0.02, 0.005), (0.0, 0.03, -0.01)
    return Joint("coupled", "thigh", "shank", *places, rotations=turns, translations=moves)


JOINTS = {"knee": knee, "general": general}
THIGH_COM, SHANK_COM = np.array([0.0, -0.17, 0.0]), np.array([0.01, -0.1867, 0.02])
STATES = [
    ((0.4, -0.9), (1.5, -2.0)),
    ((-0.3, -2.0), (-3.0, 4.0)),
    ((0.7, 0.15), (2.0, 5.0)),
    ((0.2, -2.3), (0.5, -6.0)),
]
# By state: accelerations rad/s^2, upper half of the mass matrix kg m^2, shank's centre of mass m, its quaternion wxyz.
OPENSIM = {
    "knee": [
        ([-18.1561748, 57.0735307], [1.56103175, 0.346379048, 0.162169978], [0.179519285, 0.361157407, 0.02],
         [0.968912422, 0.0, 0.0, -0.247403959]),
        ([12.7288335, 38.1879626], [1.03603204, 0.085374995, 0.153880372], [-0.171832889, 0.615084642, 0.02],
         [0.408487441, -0.0, -0.0, -0.91276394]),
        ([-12.8004471, -1.37899244], [1.70540526, 0.442827643, 0.177903328], [0.497607581, 0.478664265, 0.02],
         [0.911038733, 0.0, 0.0, 0.412320782]),
        ([-8.29279526, 35.9227751], [0.901349794, 0.0123425369, 0.15022043], [0.0115180939, 0.566962673, 0.02],
         [0.497571048, -0.0, -0.0, -0.867423226]),
    ],
    "general": [
        ([-20.4417049, 45.2662645], [1.59766517, 0.488050421, 0.238345929], [0.224204032, 0.358484722, 0.187936448],
         [0.957674565, 0.194225076, -0.185249133, -0.104013493]),
        ([19.2787454, 32.3388088], [0.839557227, -0.13772414, 0.523936696], [-0.100034868, 0.633579676, 0.128792659],
         [0.268857768, 0.0555734202, -0.496423347, -0.823523501]),
        ([-7.19186827, -27.8923248], [1.52291694, 0.357482751, 0.134666028], [0.521816769, 0.568575994, 0.178446211],
         [0.843230391, 0.0535222855, 0.254686894, 0.470353547]),
        ([-9.91510175, 15.0628582], [0.664063881, -0.250767657, 0.589945796], [0.123782857, 0.647517282, 0.132844638],
         [0.259821792, 0.201148149, -0.473363533, -0.817287602]),
    ],
}  # fmt: skip


def leg(name: str = "knee", q: float = -0.9, u: float = -2.0) -> Scene:
    """The leg of the numbers, on a base that does not move."""
    joint = JOINTS[name]()
    place, in_child = np.array(joint.position_in_parent), np.array(joint.position_in_child)
    joint.position_in_parent, joint.position_in_child = tuple(place - THIGH_COM), tuple(in_child - SHANK_COM)
    bodies = {
        "base": Body(1.0, (1.0, 1.0, 1.0)),
        "thigh": Body(9.3014, (0.1339, 0.0351, 0.1412)),
        "shank": Body(3.7075, (0.0504, 0.0051, 0.0511)),
    }
    hip = Joint("hinge", "base", "thigh", (0.1, 0.9, 0.0), tuple(-THIGH_COM), [Z])
    half = 0.2
    start = InitialState(
        joints={
            "hip": JointState((0.0, 0.0, np.sin(half), np.cos(half)), (0.0, 0.0, 1.5)),
            "knee": JointState(coordinate=q, speed=u),
        }
    )
    return Scene(
        "leg", Character("base", bodies, {"hip": hip, "knee": joint}, "fixed"), initial_state=start,
        ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0), gravity=9.80665, duration=0.5,
        actuation={"hip": Actuation("torque"), "knee": Actuation("torque")},
    )  # fmt: skip


def stages_of(name: str) -> Stages:
    """The leg in all states of the numbers."""
    stages = Stages(leg(name), len(STATES), "cpu")
    coordinates, speeds = stages.state.coordinates.numpy(), stages.state.speeds.numpy()
    for k, (q, u) in enumerate(STATES):
        coordinates[k, 7:], speeds[k] = q, u
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(speeds)
    return stages


@pytest.mark.parametrize("name", sorted(JOINTS))
def test_pose_inertia_and_accelerations_are_those_of_opensim(name: str):
    stages = stages_of(name)
    acceleration, inertia, com, quaternion = (np.array(part) for part in zip(*OPENSIM[name], strict=True))
    pose = stages.forward_kinematics()
    np.testing.assert_allclose(pose["position"][:, 2], com, atol=2e-7)
    alike = np.abs(np.sum(pose["orientation"][:, 2] * quaternion[:, [1, 2, 3, 0]], axis=1))
    np.testing.assert_allclose(alike, 1.0, atol=1e-6)
    np.testing.assert_allclose(stages.mass_matrix()[:, [0, 0, 1], [0, 1, 1]], inertia, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(stages.forward_dynamics()["speed_rate"], acceleration, rtol=5e-5, atol=5e-4)


@pytest.mark.parametrize("name", sorted(JOINTS))
def test_inverse_dynamics_of_opensims_motion_needs_no_force(name: str):
    q = np.array([[*ORIGIN, 0.0, 0.0, 0.0, 1.0, *state[0]] for state in STATES])
    u, a = np.array([state[1] for state in STATES]), np.array([numbers[0] for numbers in OPENSIM[name]])
    np.testing.assert_allclose(inverse_dynamics(leg(name), q, u, a), 0.0, atol=5e-7)


@pytest.mark.parametrize("name", sorted(JOINTS))
def test_energy_stays_in_free_motion(name: str):
    scene = leg(name)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    q, v = (rollout.recorded(key)[0].astype(float) for key in ("coordinates", "speeds"))
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    heights = stages.forward_kinematics()["position"][:, 1:, 1].astype(float) @ [9.3014, 3.7075]
    kinetic = 0.5 * np.einsum("ni,nij,nj->n", v, stages.mass_matrix().astype(float), v)
    energy = kinetic + 9.80665 * heights
    assert np.ptp(kinetic) > 1.5
    assert np.ptp(energy) < 2e-3 * np.ptp(kinetic)


def test_muscles_across_it_pull_by_virtual_work():
    scene = leg("general")
    path = [
        ViaPoint("base", (0.2, 0.9, 0.1)),
        ViaPoint("thigh", (0.05, -0.1, 0.0)),
        ViaPoint("shank", (0.04, 0.05, 0.1)),
    ]
    scene.character.muscles = {"puller": Muscle(path=path, f_max=100.0, l_opt=0.3, l_slack=0.2)}
    scene.actuation = {}
    count, step = 41, 2e-3
    q = -1.0 + step * np.arange(count)
    stages = Stages(scene, count, "cpu")
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, 8] = q
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(np.tile([0.0, 3.0], (count, 1)).astype(np.float32))
    paths = stages.muscle_paths()
    slope = np.gradient(paths.length[:, 0].astype(float), q)[1:-1]
    joint, place = scene.character.joints["knee"], stages.forward_kinematics()["orientation"].astype(float)
    axis = rotate(place[:, 2], joint_type(joint).frame(joint)[0])
    arm = np.sum(paths.moment_arm[:, paths.joint.index(1)] * axis, axis=1)[1:-1]
    np.testing.assert_allclose(arm, slope, atol=2e-4)
    np.testing.assert_allclose(paths.speed[1:-1, 0], 3.0 * slope, atol=6e-4)
    assert np.abs(slope).max() > 0.01


def test_its_coordinate_is_read_back_from_a_recording_and_limits_hold_it():
    scene = leg("general")
    scene.character.joints["knee"].limits = [(-1.0, -0.8)]
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    q = joint_angles(rollout.recording(0), scene.character, "knee")[:, 0]
    assert -1.0 < q.min() < -0.9
    assert -0.8 < q.max() < -0.79
    end = Rollout(scene, 1, "cpu", record=[0])
    end.run()
    np.testing.assert_allclose(q, end.recorded("coordinates")[0][:, 8], atol=1e-5)


def test_a_prescribed_coordinate_carries_the_shank_along():
    scene = leg("general")
    time = np.linspace(0.0, 0.5, 9)
    scene.actuation["knee"] = Actuation("kinematic")
    scene.motion = {"knee": Motion(time.tolist(), value=(-0.9 + 0.5 * np.sin(6.0 * time)).tolist())}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0, quantities=["coordinates", "speeds"])
    rollout.run()
    q, v = (rollout.recorded(key)[0].astype(float) for key in ("coordinates", "speeds"))
    at = np.arange(100, 400, 50)
    a = (v[at + 5] - v[at - 5]) / 0.01
    needed = inverse_dynamics(scene, q[at], v[at], a)
    assert np.abs(needed[:, 0]).max() < 0.01 * np.abs(needed[:, 1]).max()  # the hip is free


def test_free_parameters_move_its_knots():
    scene = leg()
    free = scene.character.joints["knee"].translations[1]
    free.y[3] = Free(-0.3976, -0.42, -0.38)
    stages = Stages(scene, 2, "cpu")
    stages.set_parameters(np.array([[-0.3976], [-0.39]]))
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, 8] = -0.349066
    stages.state.coordinates.assign(coordinates)
    pose = stages.forward_kinematics()
    moved = rotate(conjugate(pose["orientation"][0, 1]), pose["position"][1, 2] - pose["position"][0, 2])
    np.testing.assert_allclose(moved, [0.0, 0.0076, 0.0], atol=1e-6)


def test_a_scene_file_says_it_and_comes_back_the_same(tmp_path):
    scene = leg("general")
    save(scene, tmp_path / "leg.toml")
    again = load(tmp_path / "leg.toml")
    assert again.character.joints["knee"] == scene.character.joints["knee"]


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        (lambda j: j.translations.clear() or j.rotations.clear(), "", "depends on no coordinate"),
        (lambda j: j.rotations.extend(j.rotations * 3), ".rotations", "takes 3 rotations at most, got 4"),
        (lambda j: j.translations[0].y.pop(), ".translations.0.y", "11 values for 12 knots"),
        (lambda j: j.translations[0].x.reverse(), ".translations.0.x.1", "knots must increase"),
        (lambda j: setattr(j.translations[0], "slope", 1.0), ".translations.0.slope", "give either knots"),
        (lambda j: setattr(j, "axes", [X]), ".axes", "a coupled joint takes 0 axes, got 1"),
    ],
)
def test_what_is_wrong_with_it_is_said(change, key: str, words: str):
    scene = leg()
    change(scene.character.joints["knee"])
    with pytest.raises(SceneError, match=re.escape(words)) as caught:
        Rollout(scene, 1, "cpu")
    assert caught.value.key == f"character.joints.knee{key}"


def test_other_joints_take_no_functions_and_mujoco_no_splines():
    scene = leg()
    with pytest.raises(SceneError, match="MuJoCo's polynomials of the fourth degree miss this function by"):
        mjcf.dumps(scene)
    scene.character.joints["hip"].rotations = [Displacement(Z, slope=1.0)]
    with pytest.raises(SceneError, match="a hinge joint takes no rotations"):
        Rollout(scene, 1, "cpu")


def test_a_wrong_key_of_a_function_is_found_in_the_file(tmp_path):
    file = tmp_path / "leg.toml"
    save(leg(), file)
    file.write_text(file.read_text().replace("slope = 1", "slop = 1"))
    with pytest.raises(SceneError, match=r"leg.toml:\d+: character.joints.knee.rotations.0.slop: unknown key"):
        load(file)


def test_pose_and_motion_subspace_of_the_host_are_those_of_the_device():
    stages, joint = stages_of("general"), leg("general").character.joints["knee"]
    q, u = (np.array([state[k][1:] for state in STATES]) for k in (0, 1))
    pose = stages.forward_kinematics()
    motion = joint_type(joint).motion(joint, q, u)
    relative = multiply(conjugate(pose["orientation"][:, 1]), pose["orientation"][:, 2])
    np.testing.assert_allclose(np.abs(np.sum(relative * motion.orientation, axis=1)), 1.0, atol=1e-6)
    spin = pose["angular_velocity"][:, 2] - pose["angular_velocity"][:, 1]
    np.testing.assert_allclose(rotate(conjugate(pose["orientation"][:, 1]), spin), motion.turning[0] * u, atol=5e-6)
