"""Joints that follow others against the tree without followers, reduced in float64 by M = J^T M J; and their energy."""

from typing import Any

import numpy as np
import pytest
import warp as wp

from reduced_tree import check_energy_stays, expected, lengths, put, recorded
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about, normalized, rotate
from warpmuscle.formats import load, mjcf, save
from warpmuscle.kernels.body.follower import backward_pass_of_clusters, reduce_any_cluster
from warpmuscle.kernels.stages import work_of
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    CylinderSurface,
    Displacement,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    PointMotion,
    Scene,
    SphereSurface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import Topology, coordinate_names, topology
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

clusters = backward_pass_of_clusters(reduce_any_cluster)
X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
TURNS = [
    Displacement((0.2, 0.9, -0.3), x=[-2.0, -1.0, 0.0, 1.0, 2.0], y=[-0.3, 0.1, 0.2, -0.1, 0.4]),
    Displacement((1.0, 0.3, 0.0), 0.1, 0.8),
]
MOVES = [Displacement(Y, polynomial=[0.01, -0.03, 0.02, 0.0, 0.01]), Displacement(Z, slope=0.04)]


def follower(parent: str, child: str, follows: str, scale: float = 1.0) -> Joint:
    """A joint that turns and moves as wildly as a knee may."""
    turns = [*TURNS, Displacement((0.0, 0.1, 1.0), slope=0.5 * scale)]
    place = (0.02, -0.1 * scale, 0.03), (0.01, 0.05, -0.02)
    return Joint("coupled", parent, child, *place, rotations=turns, translations=MOVES, follows=follows)


def walker(root_joint: str = "free") -> Scene:
    """A knee with followers beside it, on it, and on each of those; a spine whose vertebrae follow a hinge."""
    names = ("pelvis", "thigh", "shank", "patella", "tendon", "fibula", "toe", "l5", "l4", "l3", "head")
    masses = zip(names, np.random.default_rng(1).uniform(0.5, 2.0, len(names)), strict=True)
    bodies = {name: Body(m, (0.02 * m, 0.03 * m, 0.01 * m)) for name, m in masses}
    place = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)
    joints = {
        "patella": follower("thigh", "patella", "knee"),
        "hip": Joint("ball", "pelvis", "thigh", *place),
        "knee": Joint("coupled", "thigh", "shank", *place, rotations=TURNS, translations=MOVES),
        "quadriceps": follower("patella", "tendon", "knee", 0.7),
        "fibula": follower("shank", "fibula", "knee", -1.3),
        "toe": follower("fibula", "toe", "knee", 0.4),
        "l4": follower("l5", "l4", "l5", 0.8),
        "l5": Joint("hinge", "pelvis", "l5", (0.0, 0.1, 0.0), (0.0, -0.1, 0.02), [(0.9, 0.1, 0.2)]),
        "l3": follower("l4", "l3", "l5", 1.2),
        "neck": Joint("universal", "l3", "head", (0.0, 0.1, 0.0), (0.0, -0.1, 0.02), [X, Y]),
    }
    return Scene("walker", Character("pelvis", bodies, joints, root_joint), ground=Ground(stiffness=0.0))


def states(scene: Scene, count: int = 6, hip: bool = True) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    names = topology(scene.character)
    q = rng.uniform(-1.0, 1.0, (count, names.coordinates))
    q[:, 3:7] = normalized(q[:, 3:7])
    if hip:
        ball = names.coordinates_of(names.body_of_joint("hip"))
        q[:, ball] = normalized(q[:, ball] + [0.0, 0.0, 0.0, 2.0])
    return q, rng.normal(size=(count, names.speeds)) * 2.0


def test_mass_matrix_and_accelerations_are_those_of_the_reduced_tree():
    scene = walker()
    q, v = states(scene)
    mass, bias = expected(scene, q, v)
    stages = put(scene, q, v)
    np.testing.assert_allclose(stages.mass_matrix(), mass, atol=2e-6 * np.abs(mass).max())
    rates = stages.forward_dynamics()["speed_rate"]
    accelerations = np.linalg.solve(mass, -bias[..., None])[..., 0]
    np.testing.assert_allclose(rates, accelerations, atol=2e-4 * np.abs(accelerations).max())
    np.testing.assert_allclose(np.einsum("nij,nj->ni", mass, rates), -bias, atol=2e-4 * np.abs(bias).max())


@wp.kernel(enable_backward=False)
def of_one_lane(lane: int, lanes: int, model: Model, workspace: wp.array2d[float]):
    work = work_of(0, model, workspace)
    clusters(0, lane, lanes, model, work)


def test_a_lane_for_which_a_level_has_no_body_reduces_none():
    """Three bodies in a row, of which each lane but the first has none: two followers would be near."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("base", "arm", "hand", "charm")}
    place = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)
    joints = {
        "elbow": Joint("hinge", "base", "arm", *place, [X]), "wrist": follower("arm", "hand", "elbow"),
        "link": follower("hand", "charm", "elbow"),
    }  # fmt: skip
    scene = Scene("chain", Character("base", bodies, joints), ground=Ground(stiffness=0.0))
    stages = put(scene, *states(scene, 1, False))
    stages.forward_dynamics()
    before = stages.workspace.numpy().copy()
    wp.launch(of_one_lane, 1, [1, 2, stages.model, stages.workspace], device="cpu")
    np.testing.assert_array_equal(stages.workspace.numpy(), before)
    wp.launch(of_one_lane, 1, [0, 2, stages.model, stages.workspace], device="cpu")
    assert np.any(stages.workspace.numpy() != before)


def test_inverse_dynamics_knows_them():
    scene = walker()
    q, v = states(scene)
    a = np.random.default_rng(2).normal(size=v.shape)
    mass, bias = expected(scene, q, v)
    needed = np.einsum("nij,nj->ni", mass, a) + bias
    np.testing.assert_allclose(inverse_dynamics(scene, q, v, a), needed, rtol=1e-11, atol=1e-11)


def with_muscles(scene: Scene) -> Scene:
    """Muscles that end on, run past and cross what follows, one of them over a point that counts in places."""
    routes = {
        "vastus": [("thigh", (0.05, -0.1, 0.02)), ("patella", (0.02, 0.03, 0.01)), ("shank", (0.03, -0.05, 0.0))],
        "rectus": [("pelvis", (0.05, -0.1, 0.02)), ("tendon", (0.02, 0.03, 0.01))],
        "toes": [("thigh", (-0.05, -0.1, 0.02)), ("toe", (0.02, 0.03, 0.01))],
        "short": [("fibula", (-0.05, -0.1, 0.02)), ("toe", (0.02, 0.03, 0.01))],
        "erector": [("pelvis", (0.0, 0.0, -0.06)), ("l4", (0.01, 0.02, -0.05)), ("head", (0.0, 0.1, -0.05))],
    }
    for name, route in routes.items():
        path = [ViaPoint(body, position) for body, position in route]
        scene.character.muscles[name] = Muscle(path=path, f_max=800.0, l_opt=0.1, l_slack=0.1)
    return scene


def test_muscles_pull_on_the_joint_that_their_bodies_follow():
    scene = with_muscles(walker())
    q, v = states(scene)
    stages = put(scene, q, v)
    found, names = stages.muscle_paths(), stages.names
    np.testing.assert_allclose(found.length, lengths(scene, q), atol=3e-7)
    for joint, own in (("knee", "knee"), ("l5", "l5")):
        body, step = names.body_of_joint(own), 1e-6
        column = names.coordinates_of(body).start
        unit = step * np.eye(q.shape[1])[column]
        slope = (lengths(scene, q + unit) - lengths(scene, q - unit)) / (2.0 * step)
        axis = np.asarray(rotate(stages.forward_kinematics()["orientation"][:, body], joint_axis(scene, joint)))
        crossed = {m: c for c, (m, j) in enumerate(zip(found.muscle, found.joint, strict=True)) if j == body - 1}
        assert {names_of(scene)[m] for m in crossed} == CROSSED[joint]
        for muscle in range(slope.shape[1]):
            arm = np.sum(found.moment_arm[:, crossed[muscle]] * axis, axis=1) if muscle in crossed else 0.0
            np.testing.assert_allclose(arm, slope[:, muscle], atol=2e-6)
    still = numbers_alone(names, v)
    ahead, behind = (lengths(scene, moved(q, still, names, sign * 1e-6)) for sign in (1.0, -1.0))
    np.testing.assert_allclose(put(scene, q, still).muscle_paths().speed, (ahead - behind) / 2e-6, atol=5e-6)


def test_a_path_that_wraps_and_moves_on_followers_has_the_moment_arm_of_its_length():
    scene = walker()
    scene.character.surfaces = {
        "condyle": CylinderSurface("shank", (0.0, 0.15, 0.0), 0.06, 0.5, (0.0, np.pi / 2.0, 0.0)),
        "disc": SphereSurface("l3", (0.0, 0.0, -0.03), 0.05),
    }
    moving = ViaPoint("patella", (0.0, 0.02, 0.04), motion=[PointMotion(Z, slope=0.02, joint="knee")])
    routes = {
        "vastus": ([ViaPoint("thigh", (0.0, 0.1, 0.08)), moving, ViaPoint("toe", (0.0, -0.05, 0.07))], "condyle"),
        "back": ([ViaPoint("pelvis", (0.0, 0.0, -0.05)), ViaPoint("head", (0.0, 0.1, -0.04))], "disc"),
    }
    for name, (path, surface) in routes.items():
        scene.character.muscles[name] = Muscle(path=path, wraps=[Wrap(surface)], f_max=8.0, l_opt=0.1, l_slack=0.1)
    q, v = states(scene, 12)
    stages, step = put(scene, q, v), 2e-3
    found, names = stages.muscle_paths(), stages.names
    for joint, muscle in (("knee", 0), ("l5", 1)):
        body = names.body_of_joint(joint)
        unit = step * np.eye(q.shape[1])[names.coordinates_of(body).start]
        ahead, behind = (put(scene, q + sign * unit, v).muscle_paths().length[:, muscle] for sign in (1.0, -1.0))
        axis = np.asarray(rotate(stages.forward_kinematics()["orientation"][:, body], joint_axis(scene, joint)))
        (crossing,) = [
            c for c, at in enumerate(zip(found.muscle, found.joint, strict=True)) if at == (muscle, body - 1)
        ]
        arm = np.sum(found.moment_arm[:, crossing] * axis, axis=1)
        assert np.ptp(arm) > 0.01
        np.testing.assert_allclose(arm, (ahead - behind) / (2.0 * step), atol=3e-4)


CROSSED = {"knee": {"vastus", "rectus", "toes", "short"}, "l5": {"erector"}}


def names_of(scene: Scene) -> list[str]:
    return list(scene.character.muscles)


def joint_axis(scene: Scene, name: str) -> np.ndarray:
    joint = scene.character.joints[name]
    return joint_type(joint).frame(joint)[0][0]


def numbers_alone(names: Topology, v: np.ndarray) -> np.ndarray:
    """Speeds of knee, spine and neck alone, whose coordinates are numbers."""
    still = np.zeros_like(v)
    for joint in ("knee", "l5", "neck"):
        own = names.speeds_of(names.body_of_joint(joint))
        still[:, own] = v[:, own]
    return still


def moved(q: np.ndarray, v: np.ndarray, names: Topology, time: float) -> np.ndarray:
    there = q.copy()
    for joint in ("knee", "l5", "neck"):
        body = names.body_of_joint(joint)
        there[:, names.coordinates_of(body)] += time * v[:, names.speeds_of(body)]
    return there


def swinging(**more: Any) -> Scene:
    """A thigh on a hinge in the air, the knee and all that follows it."""
    scene = walker("fixed")
    character = scene.character
    kept = {"hip", "knee", "patella", "quadriceps", "fibula", "toe"}
    character.joints = {name: joint for name, joint in character.joints.items() if name in kept}
    character.bodies = {name: body for name, body in character.bodies.items() if name[0] != "l" and name != "head"}
    character.joints["hip"].type, character.joints["hip"].axes = "hinge", [X]
    scene.initial_state = InitialState(joints={"hip": JointState(orientation=tuple(about(X, 0.7).tolist()))})
    scene.initial_state.joints["knee"] = JointState(coordinate=-0.5, speed=3.0)
    scene.failure, scene.duration = Failure(com_height=0.0, heading=0.0), 1.0
    scene.actuation = {"hip": Actuation("torque"), "knee": Actuation(more.pop("knee", "torque"))}
    scene.motion = more
    return scene


def test_a_swinging_leg_with_a_patella_keeps_its_energy():
    check_energy_stays(swinging())


def test_a_prescribed_knee_moves_its_followers_and_the_free_hip_answers():
    time = np.linspace(0.0, 1.0, 21)
    scene = swinging(knee="kinematic")
    scene.motion = {"knee": Motion(time=time.tolist(), value=(-0.5 + 0.6 * np.sin(5.0 * time)).tolist())}
    q, v = recorded(scene)
    at = np.arange(200, 1800, 100)
    a = (v[at + 4] - v[at - 4]) / 0.004
    needed = inverse_dynamics(scene, q[at], v[at], a)
    assert np.abs(needed[:, 1]).max() > 1.0
    np.testing.assert_allclose(needed[:, 0], 0.0, atol=5e-3)


def test_a_scene_file_names_and_recordings_know_followers(tmp_path):
    scene = with_muscles(walker())
    scene.failure.com_height = 0.0
    save(scene, tmp_path / "walker.toml")
    again = load(tmp_path / "walker.toml")
    assert again.character.joints["patella"] == scene.character.joints["patella"]
    coordinates, _ = coordinate_names(topology(scene.character), scene.character)
    assert coordinates[7:] == ("hip.qx", "hip.qy", "hip.qz", "hip.qw", "l5", "knee", "neck.0", "neck.1")
    with pytest.raises(SceneError, match="MuJoCo takes a coupled joint of which one turn or shift is"):
        mjcf.dumps(scene)


def spine(kind: str, followed: bool, **more: Any) -> Scene:
    """Vertebrae on springs and limits; the lowest is a hinge, or the coupled joint that is the same."""
    scene = walker("fixed")
    character = scene.character
    kept = {"l5", "l4", "l3", "neck"}
    character.joints = {name: joint for name, joint in character.joints.items() if name in kept}
    character.bodies = {name: character.bodies[name] for name in ("pelvis", "l5", "l4", "l3", "head")}
    lowest = character.joints["l5"]
    lowest.limits = [(-0.1, 0.4)]
    if kind == "coupled":
        lowest.type, lowest.rotations, lowest.axes = "coupled", [Displacement(lowest.axes[0], slope=1.0)], []
    if not followed:
        for name in ("l4", "l3"):
            character.joints[name].type, character.joints[name].follows = "fixed", ""
            character.joints[name].rotations, character.joints[name].translations = [], []
    state = JointState(coordinate=0.3, speed=2.0)
    if kind == "hinge":
        axis = np.array(lowest.axes[0]) / np.linalg.norm(lowest.axes[0])
        state = JointState(tuple(about(axis, 0.3).tolist()), tuple((2.0 * axis).tolist()))
    scene.initial_state = InitialState(joints={"l5": state})
    scene.failure, scene.duration = Failure(com_height=0.0, heading=0.0), 0.5
    scene.actuation = {"l5": Actuation("passive", stiffness=30.0, damping=0.5), "neck": Actuation("torque")}
    for field, value in more.items():
        setattr(scene, field, value)
    return scene


@pytest.mark.long
def test_a_hinge_that_is_followed_is_the_coupled_joint_that_turns_as_it_does():
    hinge, coupled = (recorded(spine(kind, True)) for kind in ("hinge", "coupled"))
    for one, other in zip(hinge, coupled, strict=True):
        assert np.ptp(one[:, -3]) > 0.2
        np.testing.assert_allclose(one, other, atol=2e-3)


@pytest.mark.long
def test_a_hinge_that_nothing_heavy_follows_swings_as_one_that_is_not_followed():
    plain, scene = spine("hinge", False), spine("hinge", False)
    scene.character.bodies["charm"] = Body(1.0e-7, (1.0e-10, 1.0e-10, 1.0e-10))
    scene.character.joints["charm"] = follower("pelvis", "charm", "l5")
    for one, other in zip(recorded(plain), recorded(scene), strict=True):
        np.testing.assert_allclose(one, other, atol=2e-3)


@pytest.mark.long
def test_a_prescribed_hinge_moves_its_followers():
    time = np.linspace(0.0, 0.5, 11)
    motion = {"l5": Motion(time=time.tolist(), value=(0.3 * np.sin(6.0 * time)).tolist())}
    drives = {"l5": Actuation("kinematic"), "neck": Actuation("torque")}
    scene = spine("hinge", True, motion=motion, actuation=drives)
    scene.initial_state = InitialState()
    q, v = recorded(scene)
    at = np.arange(100, 900, 100)
    a = (v[at + 4] - v[at - 4]) / 0.004
    needed = inverse_dynamics(scene, q[at], v[at], a)
    assert np.abs(needed[:, 0]).max() > 1.0
    np.testing.assert_allclose(needed[:, 1:], 0.0, atol=5e-3)
