"""Accelerations against MuJoCo, conserved quantities in free flight, pendulums, and joint limits."""

import copy

import numpy as np
import pytest
from probes import evaluate, matrix

from biped import biped, multiply, rotate
from random_states import States, random_states
from warpmuscle.core.pose import about, conjugate
from warpmuscle.formats import load
from warpmuscle.kernels.body.limits import ball_angles, ball_rate_axes
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Joint, JointState, Scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

pytestmark = pytest.mark.optimized  # bodies fly and swing for seconds
X, Y, Z, ORIGIN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
G = 9.8


def without_limits(character: Character) -> Character:
    for joint in character.joints.values():
        joint.limits = []
    return character


def with_root(kind: str) -> Character:
    character = biped()
    character.root_joint = kind
    return character


def with_fixed_joints() -> Character:
    character = biped()
    for name in ("pelvis_torso", "lElbow", "rAnkle", "rToeJoint"):
        character.joints[name].type, character.joints[name].axes = "fixed", []
    return character


CHARACTERS = {
    "biped": biped,
    "bigbird": lambda: without_limits(load("bigbird_walk").character),
    "planar root": lambda: with_root("planar"),
    "fixed root": lambda: with_root("fixed"),
    "fixed joints": with_fixed_joints,
}


def free(character: Character, **more) -> Scene:
    """The character without controller, ground or failure."""
    failure = Failure(com_height=0.0, heading=0.0, max_com_speed=1000.0)
    return Scene("free", character, ground=Ground(stiffness=0.0), failure=failure, **more)


def stages_at(scene: Scene, states: States) -> Stages:
    stages = Stages(scene, len(states), "cpu")
    stages.set_state(*(getattr(states, name) for name in States.__dataclass_fields__))
    return stages


def assert_close(got: np.ndarray, expected: np.ndarray, tolerance: float = 1e-5) -> None:
    """Compare (n, ...) arrays relative to the largest number of each of the n."""
    largest = np.abs(expected).reshape(len(expected), -1).max(axis=1)
    assert (np.abs(got - expected).reshape(len(expected), -1).max(axis=1) / largest).max() < tolerance


@pytest.mark.parametrize("name", CHARACTERS)
def test_accelerations_are_those_of_mujoco(name: str, mujoco_oracle):
    scene = free(CHARACTERS[name]())
    states = random_states(scene.character, 100, seed=1)
    torque = np.random.default_rng(2).normal(size=states.joint_angular_velocity.shape) * 50.0
    expected = mujoco_oracle.accelerations(scene, states, torque)
    got = stages_at(scene, states).forward_dynamics(torque)
    assert_close(got["angular_acceleration"], expected.angular)
    assert_close(got["acceleration"], expected.linear)


@pytest.mark.parametrize("name", CHARACTERS)
def test_poses_and_velocities_are_those_of_mujoco(name: str, mujoco_oracle):
    scene = free(CHARACTERS[name]())
    states = random_states(scene.character, 20, seed=3)
    got = stages_at(scene, states).forward_kinematics()
    position, orientation, velocity, angular_velocity = mujoco_oracle.body_states(scene, states)
    np.testing.assert_allclose(got["position"], position, atol=3e-6)
    np.testing.assert_allclose(np.abs(np.sum(got["orientation"] * orientation, axis=-1)), 1.0, atol=1e-6)
    np.testing.assert_allclose(got["velocity"], velocity, atol=5e-5)
    np.testing.assert_allclose(got["angular_velocity"], angular_velocity, atol=3e-5)


# Momentum and energy.


def bodies_of(stages: Stages) -> tuple[np.ndarray, np.ndarray]:
    """Masses (B,) and principal moments of inertia (B, 3)."""
    bodies = [stages.scene.character.bodies[name] for name in stages.names.bodies]
    return np.array([body.mass for body in bodies]), np.array([body.inertia for body in bodies])


def momentum(stages: Stages) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum (n, 3), and angular momentum (n, 3) about the centre of mass, from the motion of the bodies."""
    (mass, inertia), now = bodies_of(stages), stages.forward_kinematics()
    position, velocity, angular = (now[name].astype(float) for name in ("position", "velocity", "angular_velocity"))
    r = matrix(now["orientation"].astype(float))
    spin = np.einsum("nbij,bj,nbkj,nbk->nbi", r, inertia, r, angular)
    centre = np.einsum("b,nbi->ni", mass, position) / mass.sum()
    linear = mass[:, None] * velocity
    return linear.sum(axis=1), (np.cross(position - centre[:, None], linear) + spin).sum(axis=1)


def energy(stages: Stages) -> np.ndarray:
    """Kinetic and potential energy (n,) from the motion of the bodies."""
    (mass, inertia), now = bodies_of(stages), stages.forward_kinematics()
    angular = rotate(conjugate(now["orientation"]), now["angular_velocity"].astype(float))
    kinetic = 0.5 * (mass * np.sum(now["velocity"] ** 2, axis=-1) + np.sum(inertia * angular**2, axis=-1))
    return (kinetic + mass * stages.scene.gravity * now["position"][..., 1]).sum(axis=1)


@pytest.mark.parametrize("gravity", [0.0, G])
@pytest.mark.parametrize("speed", [0.3, 1.0])
def test_free_flight_keeps_momentum_and_energy(gravity: float, speed: float):
    scene, time = free(biped(), gravity=gravity), 2.0
    stages = stages_at(scene, random_states(scene.character, 8, seed=5, speed=speed))
    (linear, angular), whole = momentum(stages), energy(stages)
    stages.run(time)
    linear[:, 1] -= 70.4 * gravity * time
    now = momentum(stages)
    np.testing.assert_allclose(now[0], linear, atol=1e-4 * np.linalg.norm(linear, axis=1).max())
    np.testing.assert_allclose(now[1], angular, atol=1e-4 * np.linalg.norm(angular, axis=1).max())
    np.testing.assert_allclose(energy(stages), whole, atol=0.005 * np.abs(whole).max())


@pytest.mark.parametrize("name", ["biped", "bigbird", "planar root", "fixed root", "fixed joints"])
def test_mass_matrix_gives_the_kinetic_energy(name: str):
    scene = free(CHARACTERS[name](), gravity=0.0)
    stages = stages_at(scene, random_states(scene.character, 50, seed=6))
    inertia, speed = stages.mass_matrix().astype(float), stages.state.speeds.numpy().astype(float)
    np.testing.assert_allclose(0.5 * np.einsum("ni,nij,nj->n", speed, inertia, speed), energy(stages), rtol=3e-6)
    assert np.array_equal(inertia, inertia.swapaxes(1, 2))
    assert np.linalg.eigvalsh(inertia).min() > 0.0


def test_mass_matrix_times_acceleration_is_the_generalized_force():
    """Of joint torques only: nothing on the root, minus the torque along the child's axes on balls, on hinges its part
    along the axis."""
    scene, count = free(biped()), 20
    stages = stages_at(scene, random_states(scene.character, count, seed=7))
    torque = np.random.default_rng(8).normal(size=(count, 14, 3)) * 50.0
    change = stages.forward_dynamics(torque)["speed_rate"] - stages.forward_dynamics()["speed_rate"]
    force = np.einsum("nij,nj->ni", stages.mass_matrix().astype(float), change.astype(float))
    np.testing.assert_allclose(force[:, :6], 0.0, atol=0.05)
    child = rotate(conjugate(stages.forward_kinematics()["orientation"][:, 1:]), -torque)
    for i, name in enumerate(stages.names.joints):
        joint, first = scene.character.joints[name], stages.names.speed_start[i + 1]
        if joint.type == "ball":
            np.testing.assert_allclose(force[:, first : first + 3], child[:, i], atol=0.05)
        else:
            np.testing.assert_allclose(force[:, first], child[:, i] @ np.array(joint.axes[0]), atol=0.05)


# Pendulums.

MASS, LENGTH, INERTIA = 2.0, 0.5, (0.08, 0.05, 0.03)


def pendulum(joint_type: str, axes: list, **more) -> Character:
    """A body that hangs from a fixed one, its centre of mass LENGTH below the joint."""
    hinge = Joint(joint_type, "stand", "bob", ORIGIN, (0.0, LENGTH, 0.0), axes, **more)
    bodies = {"stand": Body(1.0, (1.0, 1.0, 1.0)), "bob": Body(MASS, INERTIA)}
    return Character("stand", bodies, {"joint": hinge}, root_joint="fixed")


def elliptic(modulus: float) -> float:
    """Complete elliptic integral of the first kind, by the arithmetic-geometric mean."""
    a, b = 1.0, np.sqrt(1.0 - modulus**2)
    for _ in range(8):
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return np.pi / (2.0 * a)


@pytest.mark.parametrize("amplitude", [0.02, 1.0, 2.5])
def test_pendulum_has_its_period_at_small_and_large_angles(amplitude: float):
    orientation = tuple(about(X, amplitude))
    start = InitialState(joints={"joint": JointState(orientation)})
    scene = free(pendulum("hinge", [X]), initial_state=start, duration=6.0)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    recording = rollout.recording()
    angle = 2.0 * np.arcsin(recording.joint_orientation[:, 0, 0])
    k = np.flatnonzero(np.diff(np.sign(angle)))
    crossings = recording.time[k] - angle[k] * 0.0005 / (angle[k + 1] - angle[k])
    expected = 4.0 * np.sqrt((INERTIA[0] + MASS * LENGTH**2) / (MASS * G * LENGTH)) * elliptic(np.sin(amplitude / 2))
    assert len(crossings) > 2
    np.testing.assert_allclose(2.0 * np.diff(crossings).mean(), expected, rtol=5e-4)


@pytest.mark.parametrize(("joint_type", "axes"), [("universal", [X, Z]), ("ball", [X, Y])])
def test_swinging_pendulum_keeps_its_energy(joint_type: str, axes: list):
    scene = free(pendulum(joint_type, axes))
    stages = stages_at(scene, random_states(scene.character, 10, seed=9, speed=2.0))
    start = energy(stages)
    stages.run(2.0)
    np.testing.assert_allclose(energy(stages), start, atol=1e-3 * MASS * G * LENGTH)


def test_spinning_body_turns_about_its_axes_as_euler_says():
    """Torque-free rotation of a ball-jointed body whose joint is its centre of mass, against I w' = I w x w."""
    character = pendulum("ball", [X, Y])
    character.joints["joint"].position_in_child = ORIGIN
    states = random_states(character, 50, seed=10)
    rate = stages_at(free(character), states).forward_dynamics()["speed_rate"]
    w = rotate(conjugate(states.joint_orientation[:, 0]), states.joint_angular_velocity[:, 0])
    assert_close(rate, np.cross(np.array(INERTIA) * w, w) / INERTIA)


@pytest.mark.parametrize("gravity", [0.0, G])
def test_two_links_follow_the_equations_of_the_double_pendulum(gravity: float):
    """Lagrange's equations in the links' angles to the vertical: centrifugal forces carry w^2 sin(difference)."""
    upper, lower, to_elbow, to_lower = Body(1.5, (0.06, 0.02, 0.05)), Body(0.8, (0.03, 0.01, 0.02)), 0.3, 0.2
    joints = {
        "shoulder": Joint("hinge", "stand", "upper", ORIGIN, (0.0, 0.25, 0.0), [X]),
        "elbow": Joint("hinge", "upper", "lower", (0.0, 0.25 - to_elbow, 0.0), (0.0, to_lower, 0.0), [X]),
    }
    bodies = {"stand": Body(1.0, (1.0, 1.0, 1.0)), "upper": upper, "lower": lower}
    scene = free(Character("stand", bodies, joints, root_joint="fixed"), gravity=gravity)
    angle = np.random.default_rng(11).uniform(-np.pi, np.pi, (40, 2))
    rate = np.random.default_rng(12).uniform(-8.0, 8.0, (40, 2))
    states = random_states(scene.character, 40, seed=13)
    for joint, (turn, speed) in enumerate([(angle[:, 0], rate[:, 0]), (np.diff(angle)[:, 0], np.diff(rate)[:, 0])]):
        states.joint_orientation[:, joint] = [about(X, one) for one in turn]
        states.joint_angular_velocity[:, joint] = speed[:, None] * X
    got = np.cumsum(stages_at(scene, states).forward_dynamics()["speed_rate"], axis=1)
    lever, apart = lower.mass * to_elbow * to_lower, angle[:, 0] - angle[:, 1]
    matrices = np.empty((40, 2, 2))
    matrices[:, 0, 0] = 0.06 + upper.mass * 0.25**2 + lower.mass * to_elbow**2
    matrices[:, 1, 1] = 0.03 + lower.mass * to_lower**2
    matrices[:, 0, 1] = matrices[:, 1, 0] = lever * np.cos(apart)
    weight = gravity * np.sin(angle) * [upper.mass * 0.25 + lower.mass * to_elbow, lower.mass * to_lower]
    centrifugal = lever * np.sin(apart)[:, None] * np.column_stack([-(rate[:, 1] ** 2), rate[:, 0] ** 2])
    assert_close(got, np.linalg.solve(matrices, (centrifugal - weight)[..., None])[..., 0], 2e-5)


# Joint limits.

STIFFNESS, DAMPING, STEP = 400.0, 3.0, 0.0005
EFFECTIVE = DAMPING + STEP * STIFFNESS  # of the linearly implicit spring-damper


def limited(joint_type: str, axes: list, limits: list) -> Scene:
    """A pendulum without weight whose joint is its centre of mass, with limits and equal moments of inertia."""
    more = {"limits": limits, "limit_stiffness": STIFFNESS, "limit_damping": DAMPING}
    character = pendulum(joint_type, axes, **more)
    character.joints["joint"].position_in_child = ORIGIN
    character.bodies["bob"].inertia = (0.1, 0.1, 0.1)
    return free(character, gravity=0.0, time_step=STEP)


def angular_acceleration(scene: Scene, orientation: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Of the bob, (3,)."""
    zero, one = np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]])
    states = States(zero, one, zero, zero, np.reshape(orientation, (1, 1, 4)), np.reshape(velocity, (1, 1, 3)))
    return stages_at(scene, states).forward_dynamics()["angular_acceleration"][0, 1]


def pushed_back(excess: float, rate: float) -> float:
    """Acceleration by the limit: (-k excess - (d + h k) rate) / (I + h (d + h k))."""
    return (-STIFFNESS * excess - EFFECTIVE * rate) / (0.1 + STEP * EFFECTIVE)


LIMITS = [(-0.5, 0.4), (-0.3, 0.7), (-0.6, 0.2)]
CASES = [("hinge", [X], [X]), ("universal", [X, Z], [X, Z]), ("ball", [X, Y], [X, np.cross(X, Y), Y])]


@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize(
    ("joint_type", "axes", "turning", "which"),
    [(kind, axes, turning[which], which) for kind, axes, turning in CASES for which in range(len(turning))],
)
def test_every_limit_of_every_joint_pushes_back_at_both_ends(joint_type, axes, turning, which, end):
    scene = limited(joint_type, axes, LIMITS[: {"hinge": 1, "universal": 2, "ball": 3}[joint_type]])
    beyond, rate, turning = (-0.1, 0.1)[end], (-0.3, 0.2)[end], np.array(turning)
    got = angular_acceleration(scene, about(turning, LIMITS[which][end] + beyond), rate * turning)
    np.testing.assert_allclose(got, turning * pushed_back(beyond, rate), atol=0.02)


@pytest.mark.parametrize(("joint_type", "axes", "turning"), CASES)
def test_within_its_limits_a_joint_is_free(joint_type, axes, turning):
    scene = limited(joint_type, axes, LIMITS[: len(turning)])
    orientation = np.array([0.0, 0.0, 0.0, 1.0])
    for axis, (_, high) in list(zip(turning, LIMITS, strict=False))[:: -1 if joint_type == "ball" else 1]:
        orientation = multiply(about(np.array(axis), high - 0.05), orientation)  # innermost first
    np.testing.assert_allclose(angular_acceleration(scene, orientation, np.zeros(3)), 0.0, atol=1e-5)


def test_limits_of_a_moving_character_solve_the_implicit_equations_of_all_joints():
    """(M + sum c g g^T) a = M a_free + sum t g, g the derivative of a limited angle by the speeds, over all limits."""
    bounds, count = (1.3, 1.5), 60  # above all angles, so that every limit of these joints acts
    limited_joints = ("lHip", "lKnee", "lAnkle", "torso_head", "rShoulder")
    scene, free_scene = free(biped(), time_step=STEP), free(biped(), time_step=STEP)
    for name in limited_joints:
        joint = scene.character.joints[name]
        joint.limits = [bounds] * {"ball": 3, "universal": 2, "hinge": 1}[joint.type]
        joint.limit_stiffness, joint.limit_damping = 4000.0, 0.0
    states = random_states(scene.character, count, seed=12, speed=0.5)
    stages, none = stages_at(scene, states), stages_at(free_scene, states)
    inertia = none.mass_matrix().astype(float)
    speed = none.state.speeds.numpy().astype(float)
    force = np.einsum("nij,nj->ni", inertia, none.forward_dynamics()["speed_rate"].astype(float))
    largest = np.full(count, -np.inf)
    for name in limited_joints:
        for angle, gradient in limited_angles(stages, states, name):
            rate = np.sum(gradient * speed, axis=1)
            torque = 4000.0 * (bounds[0] - angle) - STEP * 4000.0 * rate
            largest = np.maximum(largest, angle)
            force += torque[:, None] * gradient
            inertia += STEP**2 * 4000.0 * gradient[:, :, None] * gradient[:, None, :]
    expected = np.linalg.solve(inertia, force[..., None])[..., 0]
    usual = largest < 1.25  # else that limit does not act, or would pull
    assert np.count_nonzero(usual) > 10
    assert_close(stages.forward_dynamics()["speed_rate"][usual], expected[usual], 1e-4)


def limited_angles(stages: Stages, states: States, name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Every angle (n,) of a joint with its derivative by the speeds (n, S)."""
    joint, names = stages.scene.character.joints[name], stages.names
    body, place = names.body_of_joint(name), names.joints.index(name)
    first, coordinate = names.speed_start[body], names.coordinate_start[body]
    unit = np.eye(names.speeds)
    if joint.type != "ball":
        angles = stages.state.coordinates.numpy().astype(float)
        return [(angles[:, coordinate + i], np.tile(unit[first + i], (len(states), 1))) for i in range(len(joint.axes))]
    q, swing, twist = states.joint_orientation[:, place], np.array(joint.axes[0]), np.array(joint.axes[1])
    angles = evaluate(ball_angles, q, swing, twist)
    rows = evaluate(ball_rate_axes, swing, rotate(q, twist)) @ matrix(q)  # by speeds about the child's axes
    return [(angles[:, i], rows[:, i] @ unit[first : first + 3]) for i in range(3)]


def test_stiff_limits_are_stable():
    """A falling pendulum stays at a limit that is much stiffer than an explicit step could bear; it trembles by no
    more than twice what gravity moves it in a step."""
    stop = {"limits": [(-1.0, 0.3)], "limit_stiffness": 1e7, "limit_damping": 1e4}
    start = InitialState(joints={"joint": JointState(tuple(about(X, 0.1)), (3.0, 0.0, 0.0))})
    rollout = Rollout(free(pendulum("hinge", [X], **stop), initial_state=start, gravity=-G), 1, "cpu")
    rollout.run(3.0)
    np.testing.assert_allclose(rollout.state.coordinates.numpy()[0, 7], 0.3, atol=1e-4)
    assert abs(rollout.state.speeds.numpy()[0, 0]) < 2.0 * 0.0005 * G / LENGTH


def test_copies_in_a_batch_do_not_influence_each_other():
    scene = free(biped())
    states = random_states(scene.character, 5, seed=11)
    together = stages_at(scene, states).forward_dynamics()["speed_rate"]
    for i in range(5):
        alone = stages_at(copy.deepcopy(scene), states[i : i + 1]).forward_dynamics()["speed_rate"]
        assert np.array_equal(alone[0], together[i])
