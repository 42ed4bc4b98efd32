"""Inverse dynamics on the device against float64 on the host, and what joints transmit against Newton's law."""

import numpy as np
import pytest

from small_leg import small_leg
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.formats import load
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.scene import Body, Character, Displacement, Joint, Scene
from warpmuscle.studies.inverse_dynamics import body_accelerations, body_points, inverse_dynamics

FRAMES = 5
STEP = 1.0e-5  # s, over which poses change for their rates


class Moving:
    """A model at random coordinates, which change at random rates."""

    def __init__(self, body: BodyModel, seed: int = 7) -> None:
        random, shape = np.random.default_rng(seed), (FRAMES, len(body.map.names))
        self.body = body
        self.values, self.rates, self.bends = (size * random.uniform(-1.0, 1.0, shape) for size in (0.4, 2.0, 20.0))
        self.values += body.map.default

    def states(self, step: float = 0.0) -> States:
        values = self.values + step * self.rates
        return self.body.map.states(values, self.rates, self.bends)

    def velocity(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of a body's joint and angular velocity of the body (n, 3), by differences."""
        before, after = (body_points(self.body.scene, self.states(step).coordinates)[name] for step in (-STEP, STEP))
        turned = multiply(after[1], conjugate(before[1]))
        return (after[0] - before[0]) / (2.0 * STEP), turned[:, :3] / turned[:, 3:] / STEP


@pytest.fixture(scope="module")
def leg(tmp_path_factory) -> Moving:
    return Moving(BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu"))


def knee_and_patella() -> Scene:
    """A leg whose patella, between other joints, follows the knee."""
    bend = Displacement((1.0, 0.2, 0.0), slope=1.0)
    glide = Displacement((0.0, 1.0, 0.0), polynomial=[0.01, -0.03, 0.02])
    place = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)
    masses = {"pelvis": 9.0, "thigh": 7.0, "patella": 0.3, "shank": 3.0, "foot": 1.0}
    bodies = {name: Body(m, (0.02 * m, 0.03 * m, 0.01 * m)) for name, m in masses.items()}
    joints = {
        "hip": Joint("ball", "pelvis", "thigh", *place),
        "patella": Joint("coupled", "thigh", "patella", *place, rotations=[bend], translations=[glide], follows="knee"),
        "knee": Joint("coupled", "thigh", "shank", *place, rotations=[bend], translations=[glide]),
        "ankle": Joint("hinge", "shank", "foot", *place, [(1.0, 0.0, 0.0)]),
    }
    return Scene("leg", Character("pelvis", bodies, joints))


def no_loads() -> BodyLoads:
    return BodyLoads([], *(np.zeros((FRAMES, 0, 3)) for _ in range(3)))


@pytest.mark.parametrize("name", ["walk56_person", "gait2392", "reflex_planar", "throw23", "small_leg"])
def test_forces_are_those_of_the_host(name, leg):
    moving = leg if name == "small_leg" else Moving(BodyModel(load(name), "cpu"))
    body, states = moving.body, moving.states()
    found = body.dynamics(states, no_loads())
    wanted = inverse_dynamics(body.scene, states.coordinates, states.speeds, states.rates)
    assert found.effort + found.followed == pytest.approx(wanted, abs=2e-5 * np.abs(wanted).max())


def test_what_a_follower_takes_counts_where_its_driver_does():
    moving = Moving(BodyModel(knee_and_patella(), "cpu"))
    body, states = moving.body, moving.states()
    found = body.dynamics(states, no_loads())
    wanted = inverse_dynamics(body.scene, states.coordinates, states.speeds, states.rates)
    assert found.effort + found.followed == pytest.approx(wanted, abs=2e-5 * np.abs(wanted).max())
    knee = body.topology.speeds_of(body.topology.body_of_joint("patella"))  # which moves it
    assert np.abs(found.followed[:, knee]).max() > 0.0
    assert not np.delete(found.followed, knee, axis=1).any()


@pytest.mark.parametrize("first", ["femur_r", "tibia_r", "calcn_r"])
def test_a_joint_carries_all_beyond_it(leg, first):
    body, states = leg.body, leg.states()
    found = body.dynamics(states, no_loads())
    number = body.topology.bodies.index(first)
    beyond = [number]
    for k in range(number + 1, len(body.topology.bodies)):
        if body.topology.parents[k] in beyond:
            beyond.append(k)
    accelerations = body_accelerations(body.scene, states.coordinates, states.speeds, states.rates)
    points = body_points(body.scene, states.coordinates)
    force = np.zeros((FRAMES, 3))
    for k in beyond:
        name = body.topology.bodies[k]
        part, joint = body.scene.character.bodies[name], body.scene.character.joints[body.topology.joints[k - 1]]
        c = rotate(points[name][1], -np.array([joint.position_in_child]))
        linear, alpha = accelerations[name]
        w = leg.velocity(name)[1]
        force += part.mass * (
            linear + np.cross(alpha, c) + np.cross(w, np.cross(w, c)) + [0.0, body.scene.gravity, 0.0]
        )
    assert found.force[:, number] == pytest.approx(force, abs=1e-4 * np.abs(force).max())


@pytest.mark.parametrize("name", ["pelvis", "tibia_r", "calcn_r"])
def test_a_load_does_the_work_of_its_force_at_its_point(leg, name):
    body, states = leg.body, leg.states()
    force, point, moment = np.random.default_rng(2).normal(size=(3, FRAMES, 1, 3))
    loads = BodyLoads([body.topology.bodies.index(name)], 100.0 * force, 0.1 * point, 10.0 * moment)
    without, loaded = (body.dynamics(states, one).effort for one in (no_loads(), loads))
    power = np.sum((without - loaded) * states.speeds, axis=1)
    place = body_points(body.scene, states.coordinates)[name][0]
    velocity, w = leg.velocity(name)
    at = velocity + np.cross(w, loads.point[:, 0] - place)
    wanted = np.sum(loads.force[:, 0] * at + loads.moment[:, 0] * w, axis=1)
    assert power == pytest.approx(wanted, abs=1e-3 * np.abs(wanted).max())
