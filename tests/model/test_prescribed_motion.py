"""Prescribed motion: kinematic coordinates follow their curves, the others move as masses and forces demand."""

import numpy as np
import pytest
from msgspec.structs import replace

from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.core.pose import conjugate, from_rotation_vector, multiply
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.model.build import motion_of
from warpmuscle.model.prescribed_motion import Curves, given_curves, kinematic, moved, speed_numbers
from warpmuscle.scene import Actuation, Body, Character, Failure, Ground, Joint, Motion, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
RATE = 2000.0  # steps a second
TIME = np.linspace(0.0, 0.2, 9)
AXES = {"hinge": [X], "universal": [Z, (1.0, 0.2, 0.0)], "ball": [X, Y], "fixed": []}
COUNT = {"hinge": 1, "universal": 2, "ball": 3, "fixed": 0}
RECORDED = {"record": [0], "record_rate": RATE}


def wave(count: int, seed: int = 0, amplitude: float = 0.6) -> list[list[float]]:
    """Smooth values (count, times) of different frequencies and phases."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(8.0, 16.0, (count, 1)) * TIME + rng.uniform(0.0, 6.0, (count, 1))
    return (amplitude * np.sin(phase)).tolist()


def chain(*drives: tuple[str, object], root: str = "fixed", **changes) -> Scene:
    """Bodies that hang one on the other, each on a joint of a type with what drives it; kinematic ones wave."""
    bodies = {f"body{i}": Body(1.5, (0.02, 0.005, 0.03)) for i in range(len(drives) + 1)}
    joints, actuation, motion = {}, {}, {}
    for i, (kind, drive) in enumerate(drives):
        name = f"joint{i}"
        joints[name] = Joint(kind, f"body{i}", f"body{i + 1}", (0.01, -0.2, 0.02), (0.0, 0.2, 0.01), AXES[kind])
        if kind == "fixed":
            continue
        actuation[name] = Actuation(drive)
        words = [drive] * COUNT[kind] if isinstance(drive, str) else drive
        own = wave(words.count("kinematic"), seed=i)
        if kind == "ball" and own:
            motion[name] = Motion(TIME.tolist(), rotation=[tuple(v) for v in np.transpose(own).tolist()])
        elif own:
            motion[name] = Motion(TIME.tolist(), value=own if len(own) > 1 else own[0])
    if root in ("free", "planar"):
        motion["root"] = root_motion()
    character = Character("body0", bodies, joints, root.removesuffix(" unprescribed"))
    scene = Scene("chain", character, failure=Failure(0.0, 0.0), ground=Ground(stiffness=0.0))
    scene.actuation, scene.motion, scene.duration, scene.time_step = actuation, motion, float(TIME[-1]), 1.0 / RATE
    return replace(scene, **changes)


def root_motion() -> Motion:
    position, rotation = (np.transpose(wave(3, seed=seed, amplitude=0.3)).tolist() for seed in (11, 12))
    return Motion(TIME.tolist(), position=[tuple(v) for v in position], rotation=[tuple(v) for v in rotation])


def run(scene: Scene) -> tuple[Rollout, np.ndarray, np.ndarray]:
    """A simulation, and its coordinates and speeds at every step."""
    rollout = Rollout(scene, 1, "cpu", **RECORDED)
    rollout.run()
    q, v = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))
    return rollout, q, v


def test_a_pose_of_one_knot_and_a_planar_root_without_rotation_are_held():
    scene = chain(("hinge", "kinematic"), ("hinge", "none"), root="planar")
    positions = [(0.0, 1.0 + 0.1 * k, 0.2 * k) for k in range(len(TIME))]
    scene.motion = {"root": Motion(TIME.tolist(), position=positions), "joint0": Motion([0.0], [0.4])}
    scene.initial_state.root_orientation = (np.sin(0.15), 0.0, 0.0, np.cos(0.15))
    rollout = Rollout(scene, 1, "cpu")
    curves, moving = motion_of(rollout.scene, rollout.structure), rollout.structure.kinematic
    assert len(moving.names) == 4
    for k, time in enumerate(TIME):
        value, rate, _ = curves.rates(float(time))
        np.testing.assert_allclose(value[0], [1.0 + 0.1 * k, 0.2 * k, 0.3, 0.4], atol=1e-6)
        np.testing.assert_allclose(rate[0, 2:], 0.0, atol=1e-9)


ALL = [("hinge", "kinematic"), ("universal", "kinematic"), ("ball", "kinematic")]


@pytest.mark.parametrize("root", ["fixed", "free", "planar"])
def test_kinematic_coordinates_pass_through_their_knots(root: str):
    scene = chain(*ALL, root=root)
    _, q, _ = run(scene)
    motion, at = scene.motion, q[::50]
    first = {"fixed": 7, "free": 7, "planar": 3}[root]
    joints, knots = at[:, first:], slice(0, len(at))
    np.testing.assert_allclose(joints[:, 0], motion["joint0"].value[knots], atol=1e-6)
    np.testing.assert_allclose(joints[:, 1:3], np.transpose(motion["joint1"].value)[knots], atol=1e-6)
    ball = from_rotation_vector(motion["joint2"].rotation)[knots]
    np.testing.assert_allclose(np.abs(np.sum(joints[:, 3:7] * ball, axis=1)), 1.0, atol=1e-6)
    if root == "free":
        np.testing.assert_allclose(at[:, :3], motion["root"].position[knots], atol=1e-6)
        turned = from_rotation_vector(motion["root"].rotation)[knots]
        np.testing.assert_allclose(np.abs(np.sum(at[:, 3:7] * turned, axis=1)), 1.0, atol=1e-6)
    if root == "planar":
        np.testing.assert_allclose(at[:, :2], np.array(motion["root"].position)[knots, 1:], atol=1e-6)


def test_speeds_and_accelerations_are_the_derivatives_of_the_coordinates():
    rollout, q, v = run(chain(*ALL, root="free"))

    def rates(values: np.ndarray) -> np.ndarray:
        return np.gradient(values, 1.0 / RATE, axis=0)[1:-1]

    plain = [(0, 0), (1, 1), (2, 2), (7, 6), (8, 7), (9, 8)]  # of coordinates and speeds
    for coordinate, speed in plain:
        np.testing.assert_allclose(v[1:-1, speed], rates(q[:, coordinate]), atol=5e-3)
    for first, speed, world in ((3, 3, True), (10, 9, False)):
        turn = q[:, first : first + 4]
        rate, inverse = rates(turn), conjugate(turn[1:-1])
        angular = 2.0 * (multiply(rate, inverse) if world else multiply(inverse, rate))[:, :3]
        np.testing.assert_allclose(v[1:-1, speed : speed + 3], angular, atol=5e-3)
    gained = rollout.state.accelerations.numpy()[0]
    np.testing.assert_allclose(gained, (3.0 * v[-1] - 4.0 * v[-2] + v[-3]) * RATE / 2.0, rtol=0.05, atol=1.0)


# Dynamics of the others.

FREE = {
    "hinge beyond prescribed joints": (*ALL, ("hinge", "none")),
    "ball before prescribed joints": (("ball", "none"), *ALL),
    "between": (("hinge", "kinematic"), ("universal", "none"), ("ball", "kinematic"), ("hinge", "none")),
    "first axis of a universal joint": (("ball", "kinematic"), ("universal", ["kinematic", "none"]), ("hinge", "none")),
    "second axis of a universal joint": (("ball", "none"), ("universal", ["none", "kinematic"]), ("hinge", "none")),
    "fixed joints": (("hinge", "kinematic"), ("fixed", ""), ("hinge", "none")),
}


def prescribed_speeds(rollout: Rollout) -> np.ndarray:
    """Which speeds are prescribed."""
    start = [name.rpartition(".")[0] + "." if ".q" in name else name for name in rollout.motion_names]
    return np.array([any(name.startswith(part) for part in start) for name in rollout.speed_names])


@pytest.mark.parametrize("root", ["fixed", "free", "planar", "free unprescribed"])
@pytest.mark.parametrize("case", FREE)
def test_others_accelerate_as_the_mass_matrix_demands(case: str, root: str):
    """M a + h = 0 in the rows of the others, with a prescribed elsewhere; h from the dynamics without prescription."""
    rollout = Rollout(chain(*FREE[case], root=root), 1, "cpu")
    rollout.run(0.1)
    time, q, v = rollout.time, rollout.state.coordinates.numpy().copy(), rollout.state.speeds.numpy().copy()
    rollout.advance(rollout.steps_done + 1)
    got = rollout.state.accelerations.numpy()[0].astype(float)  # of prescribed coordinates those of the next step

    stages = Stages(replace(rollout.scene, actuation={}, motion={}), 1, "cpu")
    stages.state.coordinates.assign(q)
    stages.state.speeds.assign(v)
    free, matrix = stages.forward_dynamics()["speed_rate"][0].astype(float), stages.mass_matrix()[0].astype(float)
    kinematic = rollout.structure.kinematic
    at, numbers = moved(kinematic, motion_of(rollout.scene, rollout.structure), time), speed_numbers(kinematic)
    np.testing.assert_allclose(v[0, numbers], at.speeds[0], atol=1e-3)
    others = np.setdiff1d(np.arange(len(free)), numbers)
    expected = np.zeros(len(free))
    expected[numbers] = at.accelerations[0]
    right = matrix @ free - matrix @ expected
    expected[others] = np.linalg.solve(matrix[np.ix_(others, others)], right[others])
    assert len(others) > 0
    np.testing.assert_allclose(got[others], expected[others], atol=3e-4 * np.abs(expected).max())


def test_prescribed_motion_does_the_work_that_the_others_gain():
    """A hanging body whose joint is shaken from the root: forces in single precision, over a whole second."""
    long = np.linspace(0.0, 1.0, 9)
    shaken = Motion(long.tolist(), position=[(0.0, 0.0, 0.1 * float(np.sin(9.0 * t))) for t in long])
    scene = replace(chain(("hinge", "none"), root="planar"), motion={"root": shaken}, duration=1.0)
    rollout, q, _ = run(scene)
    curves = motion_of(rollout.scene, rollout.structure)
    moving = np.array([curves.rates(k / RATE)[2][0, 1] for k in range(len(q))])  # forwards
    mass, inertia, arm = 1.5, 0.02, (0.2, 0.01)
    angle, rate = float(q[0, 3]), 0.0
    # The pendulum's own equation in float64, by leapfrog in quarters of a step.
    for k in range(len(q) - 1):
        for _ in range(4):
            up = np.array(
                [np.cos(angle) * arm[0] - np.sin(angle) * arm[1], np.sin(angle) * arm[0] + np.cos(angle) * arm[1]]
            )
            torque = -mass * 9.8 * up[1] + mass * moving[k] * up[0]
            rate += torque / (inertia + mass * (arm[0] ** 2 + arm[1] ** 2)) / (4.0 * RATE)
            angle += rate / (4.0 * RATE)
    assert abs(angle - q[-1, 3]) < 0.01 * np.ptp(q[:, 3])


# What is asked for.


def test_a_joint_without_motion_holds_still_and_one_that_is_not_kinematic_ignores_its_own():
    scene = chain(("hinge", "kinematic"), ("hinge", "none"))
    held = replace(scene, motion={})
    _, q, v = run(held)
    assert (np.ptp(q[:, 7]), np.abs(v[:, 0]).max()) == (0.0, 0.0)
    aside = replace(held, motion={"joint1": Motion([0.0, 1.0], [0.5, 0.7])})
    assert np.array_equal(run(aside)[1], q)


def test_a_kinematic_pose_of_one_knot_is_held():
    scene = chain(("hinge", "kinematic"), ("hinge", "none"))
    scene.motion = {"joint0": Motion([0.0], [0.4])}
    np.testing.assert_allclose(run(scene)[1][:, 7], 0.4, atol=1e-7)


def test_a_free_knot_does_what_the_number_does():
    scene = chain(("hinge", "kinematic"), ("hinge", "none"))
    value = scene.motion["joint0"].value
    scene.motion["joint0"].value = [*value[:3], Free(value[3], -1.0, 1.0), *value[4:]]
    batch = Rollout(scene, 2, "cpu", record=[0, 1], record_rate=RATE)
    batch.set_parameters([[0.2], [value[3]]])
    batch.run()
    recorded = batch.recorded("coordinates")
    scene.motion["joint0"].value = value
    np.testing.assert_array_equal(recorded[1], run(scene)[1].astype(np.float32))
    assert np.abs(recorded[0] - recorded[1]).max() > 0.01


def test_scene_with_motion_is_read_back_as_written():
    scene = chain(*ALL, root="free")
    assert loads(dumps(scene)) == scene


@pytest.mark.parametrize(
    ("name", "motion", "key", "message"),
    [
        ("hip", Motion([0.0], [0.1]), "motion.hip", "no joint is called 'hip'"),
        ("root", Motion([0.0], position=[X]), "motion.root", "a fixed root does not move"),
        ("joint0", Motion([], []), "motion.joint0.time", "at least one knot"),
        ("joint0", Motion([0.0, 0.0], [0.1, 0.2]), "motion.joint0.time.1", "must increase"),
        ("joint0", Motion([0.0, 0.1], [0.1, 0.2]), "motion.joint0.time", "reaches from 0 to 0.1 s"),
        ("joint0", Motion([0.0], [0.1, 0.2]), "motion.joint0.value", "2 values for 1 times"),
        ("joint0", Motion([0.0], rotation=[X]), "motion.joint0.rotation", "takes `value` only"),
        ("joint1", Motion([0.0], [0.1]), "motion.joint1.value", "2 angles take 2 lists, got 1"),
        ("joint1", Motion([0.0], [[0.1], 0.2]), "motion.joint1.value", "either numbers, or one list"),
        ("joint1", Motion([0.0], [[0.1], [0.2, 0.3]]), "motion.joint1.value.1", "2 values for 1 times"),
        ("joint2", Motion([0.0], [0.1]), "motion.joint2.value", "takes `rotation` only"),
        ("joint2", Motion([0.0], rotation=[X, Y]), "motion.joint2.rotation", "2 values for 1 times"),
    ],
)
def test_motions_that_make_no_sense_are_refused(name: str, motion: Motion, key: str, message: str):
    scene = chain(*ALL)
    scene.motion[name] = motion
    with pytest.raises(SceneError, match=message) as caught:
        check_scene(scene)
    assert caught.value.key == key


def test_a_ball_joint_is_kinematic_as_a_whole():
    scene = chain(("ball", ["kinematic", "none", "none"]), motion={})
    with pytest.raises(SceneError, match="as a whole"):
        check_scene(scene)


def given(time: object, values: object, of: object = None, instances: int = 2, end: float = 0.2) -> Curves:
    """Curves of a hinge and a ball joint through given knots."""
    scene = chain(("hinge", "kinematic"), ("ball", "kinematic"))
    names = topology(scene.character)
    moving = kinematic(scene, names, {"joint0": ["kinematic"], "joint1": ["kinematic"] * 3})
    assert len(moving.names) == 5
    return given_curves(moving, time, values, of, instances, end)


def knots(motions: int) -> np.ndarray:
    """Values (motions, 5, 3) of an angle and a quaternion."""
    values = np.random.default_rng(1).normal(size=(motions, 5, 3))
    values[:, 1:] /= np.linalg.norm(values[:, 1:], axis=1, keepdims=True)
    return values


def test_given_motions_go_through_their_knots_and_instances_follow_the_one_they_name():
    time, values = [0.0, 0.1, 0.2], knots(3)
    curves = given(time, values, of=[2, 0])
    np.testing.assert_array_equal(curves.row, [2, 0])
    assert given(time, knots(1)).row is None
    assert given(time, knots(2)).row is None
    for k, moment in enumerate(time):
        piece = np.searchsorted(curves.start, moment, side="right") - 1
        powers = (moment - curves.start[piece]) ** np.arange(6)
        np.testing.assert_allclose(curves.coefficients[:, piece, 0] @ powers, values[:, 0, k], atol=1e-9)


def test_between_knots_orientations_are_of_unit_length_and_speeds_are_theirs():
    """The angular velocity of a quaternion p of any length is that of p / |p|: 2 (p^-1 p') less its part along p."""
    scene = chain(("hinge", "kinematic"), ("ball", "kinematic"))
    moving = kinematic(scene, topology(scene.character), {"joint0": ["kinematic"], "joint1": ["kinematic"] * 3})
    curves, time, step = given([0.0, 0.1, 0.2], knots(2)), 0.04, 1e-5
    before, now, after = (moved(moving, curves, time + k * step) for k in (-1, 0, 1))
    assert np.abs(np.linalg.norm(curves.rates(time)[0][:, 1:], axis=1) - 1.0).min() > 1e-3
    np.testing.assert_allclose(np.linalg.norm(now.coordinates[:, 1:], axis=1), 1.0, atol=1e-12)
    rate = (after.coordinates[:, 1:] - before.coordinates[:, 1:]) / (2.0 * step)
    angular = 2.0 * multiply(conjugate(now.coordinates[:, 1:]), rate)[:, :3]
    np.testing.assert_allclose(now.speeds[:, 1:], angular, rtol=1e-5, atol=1e-5)
    gained = (after.speeds - before.speeds) / (2.0 * step)
    np.testing.assert_allclose(now.accelerations, gained, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": [0.0, 0.1]}, r"takes times \(K,\) and values \(1 or 2, 5, K\)"),
        ({"time": []}, r"takes times \(K,\)"),
        ({"values": knots(3)}, r"takes times \(K,\) and values \(1 or 2, 5, K\)"),
        ({"time": [0.0, np.nan, 0.2]}, "a number of the motion is not finite"),
        ({"values": np.full((1, 5, 3), np.inf)}, "a number of the motion is not finite"),
        ({"time": [0.0, 0.0, 0.2]}, "times of the motion must increase"),
        ({"time": [0.0, 0.1, 0.15]}, r"the motion reaches from 0 to 0\.15 s, the simulation from 0 to 0\.2 s"),
        ({"time": [0.01, 0.1, 0.2]}, r"the motion reaches from 0\.01 to 0\.2 s"),
        ({"values": np.zeros((1, 5, 3))}, "a quaternion of 'joint1' in the motion has no length"),
        ({"of": [0]}, "`of` takes the number of a motion, 0 to 0, for each of 2 instances"),
        ({"of": [0, 1]}, "`of` takes the number of a motion"),
        ({"of": [0, -1]}, "`of` takes the number of a motion"),
        ({"of": [0, 0.5]}, "`of` takes the number of a motion"),
    ],
)
def test_given_motions_that_cannot_be_followed_are_refused(change: dict, message: str):
    plain = {"time": [0.0, 0.1, 0.2], "values": knots(1)}
    assert given(**plain)
    with pytest.raises(RolloutError, match=message):
        given(**(plain | change))
