"""Armature and damping of joints: rotors about pendulums, Lagrange's equations of followers, and energy that decays."""

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Actuation, Body, Character, Displacement, Failure, Ground, Joint, Scene
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics, joint_space

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
ARM = (0.0, 0.3, 0.0)
MASS, INERTIA = 2.0, 0.01


def pendulum(kind: str = "hinge", **resistance: float) -> Scene:
    """A body below the ground's origin, on one joint about x, without gravity unless it is given."""
    rotations = [Displacement(X, polynomial=[0.0, 1.0])] if kind == "coupled" else []
    axes = {"hinge": [X], "slide": [X]}.get(kind, [])
    joint = Joint(kind, "ground", "bob", (0.0, 0.0, 0.0), ARM, axes=axes, rotations=rotations, **resistance)
    bodies = {"ground": Body(0.0, (0.0,) * 3), "bob": Body(MASS, (INERTIA,) * 3)}
    return scene_of(Character("ground", bodies, {"joint": joint}, "fixed"))


def scene_of(character: Character) -> Scene:
    scene = Scene("resisting", character, ground=Ground(stiffness=0.0), gravity=0.0, time_step=1e-3, duration=1.0)
    scene.actuation = {name: Actuation("passive") for name, joint in character.joints.items() if not joint.follows}
    scene.failure = Failure(com_height=0.0, heading=0.0)
    check_scene(scene)
    return scene


def follower(armature: float, damping: float) -> Scene:
    """A hinge, and a flap on its body that turns and shifts as functions of its angle."""
    turn = Displacement(Z, polynomial=[0.1, 0.5, -0.4, 0.2, 0.1])
    flap = Joint("coupled", "bob", "flap", (0.0, -0.2, 0.0), (0.1, 0.0, 0.0), rotations=[turn], follows="joint",
                 armature=armature, damping=damping)  # fmt: skip
    scene = pendulum(armature=0.03, damping=0.2)
    scene.character.bodies["flap"] = Body(0.5, (0.002, 0.003, 0.004))
    scene.character.joints["flap"] = flap
    check_scene(scene)
    return scene


@pytest.mark.parametrize(("kind", "inertia"), [("hinge", 0.19), ("coupled", 0.19), ("slide", 2.0), ("ball", 0.19)])
def test_armature_adds_to_the_inertia_of_a_coordinate_and_damping_pulls_back(kind: str, inertia: float):
    stages = Stages(pendulum(kind, armature=0.5, damping=3.0), 1, "cpu")
    speeds = np.zeros_like(stages.state.speeds.numpy())
    speeds[0, 0] = 0.7
    stages.state.speeds.assign(speeds)
    got = stages.forward_dynamics()["speed_rate"][0, 0]
    implicit = stages.scene.time_step * 3.0
    assert got == pytest.approx(-3.0 * 0.7 / (inertia + 0.5 + implicit), rel=1e-4)
    assert stages.mass_matrix()[0, 0, 0] == pytest.approx(inertia + 0.5, rel=1e-5)
    mass = joint_space(stages.scene, stages.state.coordinates.numpy()).mass_matrix[0, 0, 0]
    assert mass == pytest.approx(inertia + 0.5, rel=1e-6)


def test_a_follower_adds_its_own_through_its_slope():
    """Lagrange's equation of f(q): a f'^2 q'' + a f' f'' q'^2 + d f'^2 q' more than without."""
    a, d, q, v = 0.4, 0.6, 0.8, 1.7
    slope = 0.5 - 0.8 * q + 0.6 * q**2 + 0.4 * q**3
    bend = -0.8 + 1.2 * q + 1.2 * q**2
    bare, full = (Stages(follower(*own), 1, "cpu") for own in ((0.0, 0.0), (a, d)))
    rates, masses = [], []
    for stages in (bare, full):
        stages.state.coordinates.assign(np.array([[0, 0, 0, 0, 0, 0, 1, q]], np.float32))
        stages.state.speeds.assign(np.array([[v]], np.float32))
        rates.append(float(stages.forward_dynamics()["speed_rate"][0, 0]))
        masses.append(float(stages.mass_matrix()[0, 0, 0]))
    step = bare.scene.time_step
    before = (masses[0] + step * 0.2) * rates[0]
    after = (masses[0] + a * slope**2 + step * (0.2 + d * slope**2)) * rates[1]
    assert after - before == pytest.approx(-a * slope * bend * v**2 - d * slope**2 * v, rel=2e-3)
    assert masses[1] - masses[0] == pytest.approx(a * slope**2, rel=1e-3)


def test_inverse_dynamics_asks_for_the_force_that_rotors_take():
    a, q, v, rate = 0.4, 0.8, 1.7, -2.3
    slope = 0.5 - 0.8 * q + 0.6 * q**2 + 0.4 * q**3
    bend = -0.8 + 1.2 * q + 1.2 * q**2
    motion = np.array([[0, 0, 0, 0, 0, 0, 1, q]], float), np.array([[v]]), np.array([[rate]])
    bare, full = (inverse_dynamics(follower(own, 0.0), *motion)[0, 0] for own in (0.0, a))
    assert full - bare == pytest.approx(a * slope * (slope * rate + bend * v**2), rel=1e-6)


def test_a_damped_joint_slows_down_exponentially():
    scene = pendulum(armature=0.11, damping=0.6)
    scene.initial_state.joints = {}
    rollout = Rollout(scene, 1, "cpu")
    rollout.state.speeds.assign(np.array([[2.0]], np.float32))
    rollout.run(0.5)
    speed = float(rollout.state.speeds.numpy()[0, 0])
    assert speed == pytest.approx(2.0 * np.exp(-0.6 / 0.3 * 0.5), rel=5e-3)


@pytest.mark.parametrize("field", ["armature", "damping"])
def test_what_no_joint_has_is_refused(field: str):
    with pytest.raises(SceneError, match=f"joints.joint.{field}"):
        pendulum(**{field: -1.0})
    with pytest.raises(SceneError, match=f"a fixed joint takes no {field}"):
        pendulum("fixed", **{field: 1.0})
