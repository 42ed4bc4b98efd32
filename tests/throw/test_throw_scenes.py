"""The throwing arm: its equations in float64, steps of 1 ms with strong muscles on a light hand, and the whole body."""

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.interpolate import make_interp_spline

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.scene import Motion, Scene
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.moment_arms import moment_arms

JOINTS = ("shoulder", "elbow", "wrist")
SIGN = np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, -1.0]])  # angles to the trunk of joint angles
KNOTS = np.linspace(0.0, 1.5, 16)


class PlanarArm:
    """Three links below a shoulder that moves as prescribed, and six muscles on pulleys (Cruz Ruiz 2015, eq. 3 to 11).

    Angles are from hanging down, positive forwards; places are forwards and up, m.
    """

    def __init__(self, scene: Scene, excitation: np.ndarray) -> None:
        plain = substitute(scene, start_values(scene))
        character, motion = plain.character, plain.motion["root"]
        bodies = [character.bodies[character.joints[name].child] for name in JOINTS]
        self.mass = np.array([body.mass for body in bodies])
        self.inertia = np.array([body.inertia[0] for body in bodies])
        to_com = -np.array([character.joints[name].position_in_child for name in JOINTS])
        self.along, self.across = -to_com[:, 1], to_com[:, 2]
        below = [character.joints[name].position_in_parent for name in JOINTS[1:]]
        self.length = self.along[:2] - np.array(below)[:, 1]
        place = np.array(motion.position)[:, [2, 1]]
        self.pitch = make_interp_spline(motion.time, -np.array(motion.rotation)[:, 0], k=5)
        self.root = make_interp_spline(motion.time, place, k=5)
        self.above = character.joints["shoulder"].position_in_parent[1]
        self.damping = np.array([plain.actuation[name].damping for name in JOINTS])
        self.muscles = list(character.muscles.values())
        self.own = [JOINTS.index(muscle.pulleys[0].joint) for muscle in self.muscles]
        self.times = plain.muscle_model.neural_time, plain.muscle_model.rise_time
        self.excitation = excitation

    def shoulder(self, t: float) -> np.ndarray:
        """Acceleration of the shoulder."""
        p, v, a = (float(self.pitch(t, nu=order)) for order in range(3))
        up, across = np.array([-np.sin(p), np.cos(p)]), np.array([-np.cos(p), -np.sin(p)])
        return self.root(t, nu=2) + self.above * (across * a - up * v * v)

    def torque(self, q: np.ndarray, w: np.ndarray, activation: np.ndarray) -> np.ndarray:
        total = -self.damping * w
        for muscle, joint, a in zip(self.muscles, self.own, activation, strict=True):
            (pulley,) = muscle.pulleys
            length = muscle.rest_length - pulley.moment_arm * (q[joint] - pulley.rest_angle) - muscle.l_slack
            x, v = length / muscle.l_opt, -pulley.moment_arm * w[joint] / (10.0 * muscle.l_opt)
            speed = (1.0 + v) / (1.0 - 4.0 * v) if v <= 0.0 else (1.0 + 35.0 * v) / (1.0 + 25.0 * v)
            passive = np.expm1(5.0 * (x - 1.0) / 0.6) / np.expm1(5.0) if x > 1.0 else 0.0
            force = muscle.f_max * (a * np.exp(-((x - 1.0) ** 2) / 0.45) * speed + passive)
            total[joint] += force * pulley.moment_arm
        return total

    def acceleration(self, t: float, q: np.ndarray, w: np.ndarray, activation: np.ndarray) -> np.ndarray:
        pitch, pitch_rate, pitch_bend = (float(self.pitch(t, nu=order)) for order in range(3))
        theta, omega = pitch + SIGN @ q, pitch_rate + SIGN @ w
        down = np.stack([np.sin(theta), -np.cos(theta)], axis=1)
        front = np.stack([np.cos(theta), np.sin(theta)], axis=1)
        jacobian, drift = np.zeros((3, 2, 3)), np.tile(self.shoulder(t), (3, 1))
        for i in range(3):
            for k in range(i):
                jacobian[i, :, k] += self.length[k] * front[k]
                drift[i] -= self.length[k] * down[k] * omega[k] ** 2
            jacobian[i, :, i] += self.along[i] * front[i] - self.across[i] * down[i]
            drift[i] -= (self.along[i] * down[i] + self.across[i] * front[i]) * omega[i] ** 2
        matrix = np.einsum("n,nik,nij->kj", self.mass, jacobian, jacobian) + np.diag(self.inertia)
        bias = np.einsum("n,nik,ni->k", self.mass, jacobian, drift + np.array([0.0, 9.81])) + matrix @ np.full(
            3, pitch_bend
        )
        return np.linalg.solve(SIGN.T @ matrix @ SIGN, self.torque(q, w, activation) - SIGN.T @ bias)

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        q, w, a, e = y[:3], y[3:6], y[6:12], y[12:]
        u = np.array([np.interp(t, KNOTS, values) for values in self.excitation])
        neural, rise = self.times
        return np.concatenate([w, self.acceleration(t, q, w, a), (e - a) / rise, (u - e) / neural])

    def run(self, start: np.ndarray, duration: float, step: float) -> np.ndarray:
        """States (100 a second) by Runge and Kutta's method of fourth order."""
        y, history = start, [start]
        for k in range(round(duration / step)):
            t = k * step
            a = self.rate(t, y)
            b = self.rate(t + 0.5 * step, y + 0.5 * step * a)
            c = self.rate(t + 0.5 * step, y + 0.5 * step * b)
            d = self.rate(t + step, y + step * c)
            y = y + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            history.append(y)
        return np.array(history)[:: round(0.01 / step)]


def without_limits(name: str) -> Scene:
    """A scene whose joints have no limits, which these excitations would drive it against."""
    scene = load(name)
    for joint in scene.character.joints.values():
        joint.limits = []
    return scene


def excitation() -> np.ndarray:
    """Smooth excitations (muscles, knots)."""
    phase = np.random.default_rng(2).uniform(0.0, 6.0, (6, 1))
    return 0.3 + 0.25 * np.sin(4.0 * KNOTS + phase)


def test_arm_moves_as_its_equations_in_float64_say():
    scene, duration = without_limits("throw"), 0.5
    rollout = Rollout(scene, 1, "cpu", record=[0], quantities=["coordinates", "speeds"])
    given = excitation()
    rollout.set_excitations(KNOTS, given[None])
    rollout.set_initial(activation=given[None, :, 0])
    rollout.run(duration)
    q, w = (rollout.recorded(name)[0, :, 3:].astype(float) for name in ("coordinates", "speeds"))
    start = np.concatenate([q[0], w[0], given[:, 0], given[:, 0]])
    expected = PlanarArm(scene, given).run(start, duration, 0.0005)
    moved = np.ptp(expected[:, :3], axis=0)
    assert moved.min() > 0.2
    assert np.abs(q - expected[:-1, :3]).max() < 0.002
    assert np.abs(w - expected[:-1, 3:6]).max() < 0.04


def strongest_wrist(**model) -> Scene:
    """The arm with all strength that a fit may give to the wrist's muscles, in steps of 1 ms."""
    scene = load("throw")
    scene.muscle_model = replace(scene.muscle_model, **model)
    return scene


def wrist(scene: Scene) -> np.ndarray:
    """Angles of the wrist when its muscles are excited at the same time, then one alone."""
    names = [parameter.name for parameter in free_parameters(scene)]
    values = start_values(scene)
    for i, parameter in enumerate(free_parameters(scene)):
        if "m5" in names[i] or "m6" in names[i]:
            greatest = max(parameter.min, parameter.max, key=abs)
            values[i] = greatest if names[i].endswith(("f_max", "moment_arm")) else parameter.value
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1000.0, quantities=["coordinates"])
    rollout.set_parameters(values)
    shares = np.full((1, 6, 4), 0.1)
    shares[0, 4:] = [[1.0, 1.0, 1.0, 0.2], [1.0, 1.0, 0.2, 1.0]]
    rollout.set_excitations([0.0, 0.1, 0.2, 0.3], shares)
    rollout.run(0.4)
    assert rollout.status()[0] == Status.RUNNING
    return rollout.recorded("coordinates")[0, :, -1].astype(float)


@pytest.mark.long
def test_strong_muscles_on_a_light_hand_are_stable_in_steps_of_a_millisecond():
    fine = replace(strongest_wrist(), time_step=0.000125)
    expected = wrist(fine)
    implicit, explicit = wrist(strongest_wrist()), wrist(strongest_wrist(implicit_damping=False))
    jumps = [np.abs(np.diff(angle, 2)).max() for angle in (expected, implicit, explicit)]
    assert np.abs(implicit - expected).max() < 0.002
    assert jumps[1] < 1.2 * jumps[0]
    assert jumps[2] > 5.0 * jumps[0]  # what the damping is for


def test_arm_through_points_has_moment_arms_of_the_right_sign_that_vary():
    scene = load("throw_via")
    for joint, low, high in (("shoulder", 15, 150), ("elbow", 10, 110), ("wrist", -35, 40)):
        arms = moment_arms(scene, joint, 0, np.radians(np.linspace(low, high, 8))).arm
        assert np.all(arms[:, 0] > 0.005)
        assert np.all(arms[:, 1] < -0.0005)
        assert np.all(np.ptp(arms, axis=0) > 0.005)


@pytest.mark.parametrize("name", ["throw", "throw_via"])
def test_planar_arms_run_to_the_end(name: str, request: pytest.FixtureRequest):
    if name == "throw_via":  # which no other test runs
        request.getfixturevalue("unoptimized_test")
    rollout = Rollout(load(name), 1, "cpu")
    rollout.set_excitations([0.0], np.full((1, 6, 1), 0.2))
    rollout.run()
    assert rollout.status()[0] == Status.COMPLETED


# The whole body.


def test_whole_body_has_21_segments_and_32_degrees_of_freedom_of_which_muscles_drive_three():
    rollout = Rollout(load("throw_body"))
    assert len(rollout.names.bodies) == 21
    assert rollout.names.speeds - 6 == 32  # but for those of the root
    free = set(rollout.coordinate_names) - set(rollout.motion_names)
    assert free == {"shoulder", "elbow.1", "wrist.1"}
    mass = sum(body.mass for body in rollout.scene.character.bodies.values())
    assert mass == pytest.approx(90.7, rel=0.005)


@pytest.mark.long
def test_arm_of_the_whole_body_moves_like_the_planar_one():
    """Under the same excitations; their shoulders move alike, their trunks differ."""
    angles = []
    for name, places in (("throw", ("shoulder", "elbow", "wrist")), ("throw_body", ("shoulder", "elbow.1", "wrist.1"))):
        rollout = Rollout(without_limits(name), 1, "cpu", record=[0], quantities=["coordinates"])
        rollout.set_excitations(KNOTS, excitation()[None])
        rollout.run(0.5)
        columns = [rollout.coordinate_names.index(place) for place in places]
        angles.append(rollout.recorded("coordinates")[0][:, columns])
    assert np.ptp(angles[0], axis=0).min() > 0.2
    np.testing.assert_allclose(angles[1], angles[0], atol=0.05)


def test_throw_moves_the_joints_as_its_table_says_when_they_are_kinematic():
    scene = load("throw")
    scene.actuation = {name: replace(own, drive="kinematic") for name, own in scene.actuation.items()}
    rollout = Rollout(scene, 1, "cpu", record=[0], quantities=["coordinates"])
    rollout.run()
    angles = np.degrees(rollout.recorded("coordinates")[0, ::10, 3:])
    for joint, column in zip(JOINTS, angles.T, strict=True):
        motion: Motion = scene.motion[joint]
        np.testing.assert_allclose(column, np.degrees(motion.value)[:-1], atol=1e-3)
    assert (angles[:, 0].min(), angles[:, 1].max()) == pytest.approx((18.1, 103.6), abs=0.1)
