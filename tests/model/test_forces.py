"""Passive devices and forces on bodies, shipped ones and those of a module of one's own, against double precision."""

from pathlib import Path

import numpy as np
import pytest
import warp as wp

from importing import module_of
from muscle_arm import ABOUT_JOINT, MASS, REACH, arm, constant
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.kernels.force import devices
from warpmuscle.model.unused_parameters import unused_parameters
from warpmuscle.scene import Actuation, Body, Character, Failure, Force, InitialState, JointState, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout

NAME = "their_forces"
MODULE = '''
import warp as wp
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.structs import ModelRef, StateRef, ScratchRef


@wp.struct
class Clutch:
    stiffness: float  # N m/rad


@wp.func
def clutched(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, clutch: Clutch,
    memory: wp.array[float],
) -> wp.vec3:
    """A spring that takes hold at the greatest angle so far, and lets the joint come back to it only."""
    angle = state.coordinates[instance, model.skeleton.plan[body].coordinate_start]
    memory[0] = wp.max(memory[0], angle)
    return wp.vec3(clutch.stiffness * (memory[0] - angle), 0.0, 0.0)


ratchet = ForceKind(effort=clutched, parameters=Clutch, state=1)


@wp.func
def lift(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> Wrench:
    w = Wrench()
    w.force = wp.vec3(0.0, 3.0, 0.0)
    w.moment = wp.vec3(0.0, 0.5, 0.0)
    return w


both = ForceKind(effort=clutched, wrench=lift)
'''
STEP, STEPS, GRAVITY = 0.0005, 1000, 9.8
NO_LIMIT = dict.fromkeys(devices.CoordinateLimit.vars, 0.0)
ANKLE = {"rest_angle": 0.3, "stiffness_above": 40.0, "stiffness_below": 0.0, "damping": 0.0}


def ratchet(stiffness: float) -> Force:
    return Force(f"{NAME}:ratchet", joint="elbow", parameters={"stiffness": stiffness})


# None of which does anything: scenes that have them all share a kernel.
IDLE = {
    "spring": Force("bilinear_spring", joint="elbow", parameters=dict.fromkeys(ANKLE, 0.0)),
    "hold": ratchet(0.0),
    "air": Force("air_drag", body="tip", parameters={"drag_area": 0.0, "density": 1.2}),
}
module = module_of(NAME, MODULE)


def pendulum(forces: dict[str, Force], **changes: object) -> Scene:
    """A body that swings on a hinge without friction, with a push at the start."""
    scene = arm(
        actuation={"elbow": Actuation("torque")}, forces=forces, duration=STEPS * STEP,
        initial_state=InitialState((0.0, 1.0, 0.0)), **changes,
    )  # fmt: skip
    scene.initial_state.joints = {"elbow": JointState(angular_velocity=(6.0, 0.0, 0.0))}
    return scene


def exoskeleton(**parameters: object) -> Scene:
    return pendulum(IDLE | {"spring": Force("bilinear_spring", joint="elbow", parameters=ANKLE | parameters)})


def swing(torque) -> tuple[np.ndarray, np.ndarray]:
    """Angles and speeds of the pendulum at every step, by leapfrog in double precision, under a torque (q, v)."""
    q, speed, middle = 0.0, 6.0, 6.0
    angles, speeds = np.empty(STEPS), np.empty(STEPS)
    for step in range(STEPS):
        angles[step], speeds[step] = q, speed
        a = (torque(q, speed) - MASS * GRAVITY * REACH * np.sin(q)) / ABOUT_JOINT
        middle += (STEP if step else 0.5 * STEP) * a
        q, speed = q + STEP * middle, middle + 0.5 * STEP * a
    return angles, speeds


def recorded(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Angles and speeds of the pendulum at every step."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / STEP, trust=True)
    rollout.run()
    return rollout.recorded("coordinates")[0, :, 7].astype(float), rollout.recorded("speeds")[0, :, 0].astype(float)


def spring(q: float, v: float, damping: float = 0.0) -> float:
    return -40.0 * (q - 0.3) - damping * v if q > 0.3 else 0.0


def energy(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Of the pendulum and the exoskeleton's spring, J."""
    stretch = np.maximum(q - 0.3, 0.0)
    return 0.5 * ABOUT_JOINT * v**2 - MASS * GRAVITY * REACH * np.cos(q) + 0.5 * 40.0 * stretch**2


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_a_spring_over_part_of_the_range_moves_a_joint_as_in_double_precision(damping: float):
    q, v = recorded(exoskeleton(damping=damping))
    angles, speeds = swing(lambda q, v: spring(q, v, damping))
    assert angles.max() > 0.5 and angles.min() < -0.5  # noqa: PT018, engaged and slack
    np.testing.assert_allclose(q, angles, atol=1e-4)
    np.testing.assert_allclose(v, speeds, atol=1e-3)


def test_it_keeps_energy_and_its_damper_takes_what_it_says():
    q, v = recorded(exoskeleton())
    total = energy(q, v)
    np.testing.assert_allclose(total, total[0], atol=2e-4 * 0.5 * ABOUT_JOINT * 36.0)
    q, v = recorded(exoskeleton(damping=0.5))
    lost = np.cumsum(np.where(q > 0.3, 0.5 * v**2, 0.0)) * STEP
    np.testing.assert_allclose(energy(q, v) + lost, total[0], atol=0.01 * lost[-1] + 1e-3)


def falling(**parameters: object) -> Scene:
    """A ball that is thrown through air."""
    ball = Character("ball", {"ball": Body(0.4, (0.001, 0.001, 0.001))})
    return Scene(
        "ball", ball, initial_state=InitialState((0.0, 100.0, 0.0), root_velocity=(3.0, 10.0, 20.0)),
        failure=Failure(0.0, 0.0, max_com_speed=100.0), duration=1.0,
        forces={"air": Force("air_drag", body="ball", parameters={"drag_area": 0.02, "density": 1.2} | parameters)},
    )  # fmt: skip


def test_drag_slows_a_ball_as_in_double_precision_and_takes_its_energy():
    rollout = Rollout(falling(), 1, "cpu")
    rollout.run()
    place, middle, lost = np.array([0.0, 100.0, 0.0]), np.array([3.0, 10.0, 20.0]), 0.0
    speed = middle.copy()
    for step in range(2000):
        drag = -0.5 * 1.2 * 0.02 * np.linalg.norm(speed) * speed
        lost -= drag @ speed * STEP
        a = drag / 0.4 + [0.0, -GRAVITY, 0.0]
        middle = middle + (STEP if step else 0.5 * STEP) * a
        place, speed = place + STEP * middle, middle + 0.5 * STEP * a
    found, v = (getattr(rollout.state, name).numpy()[0, :3].astype(float) for name in ("coordinates", "speeds"))
    np.testing.assert_allclose(found, place, atol=1e-3)
    np.testing.assert_allclose(v, speed, atol=1e-4)
    before = 0.5 * 0.4 * (3.0**2 + 10.0**2 + 20.0**2) + 0.4 * GRAVITY * 100.0
    assert before - 0.5 * 0.4 * v @ v - 0.4 * GRAVITY * found[1] == pytest.approx(lost, rel=2e-3)


def test_forces_of_a_module_keep_a_state_for_each_and_add_up():
    one, two = {"hold": ratchet(5.0)}, {"hold": ratchet(2.5), "also": ratchet(2.5)}
    greatest, angles, _ = 0.0, *recorded(pendulum(IDLE | one))

    def held(q: float, v: float) -> float:
        nonlocal greatest
        greatest = max(greatest, q)
        return 5.0 * (greatest - q)

    np.testing.assert_allclose(angles, swing(held)[0], atol=1e-4)
    np.testing.assert_allclose(recorded(pendulum(IDLE | two))[0], angles, atol=1e-5)


def test_a_wrench_acts_at_the_centre_of_mass_and_about_it():
    scene = pendulum({"lift": Force(f"{NAME}:lift", body="tip")})
    q, _ = recorded(scene)
    np.testing.assert_allclose(q, swing(lambda q, v: 3.0 * REACH * np.sin(q))[0], atol=1e-4)
    free = falling()
    free.forces = {"lift": Force(f"{NAME}:lift", body="ball")}
    rollout = Rollout(free, 1, "cpu", trust=True)
    rollout.step(200)
    speeds = rollout.state.speeds.numpy()[0]
    assert speeds[1] == pytest.approx(10.0 + 0.1 * (3.0 / 0.4 - GRAVITY), rel=1e-4)
    assert speeds[4] == pytest.approx(0.1 * 0.5 / 0.001, rel=1e-4)


def test_free_parameters_differ_between_instances_to_the_bit_as_alone_and_over_launches():
    scene = pendulum(
        {
            "spring": Force("bilinear_spring", joint="elbow", parameters=ANKLE | {"rest_angle": Free(0.3, 0.0, 1.0)}),
            "hold": Force(f"{NAME}:ratchet", joint="elbow", parameters={"stiffness": Free(5.0, 0.0, 9.0)}),
            "air": Force("air_drag", body="tip", parameters={"drag_area": Free(0.1, 0.0, 1.0), "density": 1.2}),
        }
    )
    assert unused_parameters(scene) == []
    values = np.array([[0.1, 2.0, 0.0], [0.3, 5.0, 0.1], [0.9, 9.0, 1.0]])
    together = Rollout(scene, 3, "cpu", trust=True, threads=2)
    together.set_parameters(values)
    for count in (1, 299, 700):
        together.step(count)
    found = together.state.speeds.numpy()
    assert len(np.unique(found[:, 0])) == 3
    for row, speeds in zip(values, found, strict=True):
        alone = Rollout(scene, 1, "cpu", trust=True)
        alone.set_parameters(row)
        alone.run()
        np.testing.assert_array_equal(alone.state.speeds.numpy()[0], speeds)
        alone.reset()
        alone.run()
        np.testing.assert_array_equal(alone.state.speeds.numpy()[0], speeds)


@pytest.mark.long
def test_an_exoskeleton_adds_to_what_muscles_do_at_its_joint():
    torque = []
    for forces in ({}, {"exo": Force("bilinear_spring", joint="elbow", parameters=ANKLE | {"rest_angle": -1.0})}):
        scene = arm(forces=forces)
        scene.character.muscles["flexor"].excitation = constant(1.0)
        rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
        rollout.step(1)
        torque.append(rollout.recording().joint_torque[0, 0])
    assert np.linalg.norm(torque[0]) > 0.1  # of the muscles alone
    np.testing.assert_allclose(torque[1] - torque[0], [40.0, 0.0, 0.0], atol=1e-4)  # on the parent


def test_every_shipped_force_has_one_function_and_numbers_for_it():
    for name, kind in devices.FORCES.items():
        assert sum(one is not None for one in (kind.effort, kind.wrench, kind.pair)) == 1, name
        assert set(kind.positive) <= set(kind.parameters.vars), name


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (Force("bilinear_sprin", joint="elbow"), "'bilinear_sprin'; did you mean 'bilinear_spring'"),
        (Force("bilinear_spring", joint="elbow"), "parameters: there is no value of 'rest_angle', 'stiffness_above'"),
        (Force("bilinear_spring", body="tip", parameters=ANKLE), "force.body: 'bilinear_spring' acts on a joint"),
        (Force("air_drag", joint="elbow"), "forces.force.joint: 'air_drag' acts on a body: name it"),
        (
            Force("coordinate_limit", joint="elbow", parameters=dict.fromkeys(devices.CoordinateLimit.vars, 0.0)),
            "transition: must be greater",
        ),
        (Force("air_drag"), "name either a joint or a body"),
        (Force("air_drag", body="tap"), "forces.force.body: no body is called 'tap'; did you mean 'tip'"),
        (Force("bilinear_spring", joint="elbo"), "forces.force.joint: no joint is called 'elbo'"),
        (Force(f"{NAME}:both", joint="elbow"), "has both functions"),
        (Force(f"{NAME}:lift", joint="elbow"), "must say that it returns wp.vec3, and says Wrench"),
        (Force(f"{NAME}:left", joint="elbow"), "has no function 'left'; did you mean 'lift'"),
    ],
    ids=lambda given: given.type if isinstance(given, Force) else "",
)
def test_what_cannot_be_used_is_said_in_one_line(force: Force, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        Rollout(pendulum({"force": force}), 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)


def test_code_of_a_force_needs_trust_and_a_scene_with_it_is_written_and_read_again(tmp_path: Path):
    scene = pendulum({"x": Force("unheard:of", joint="elbow", parameters={"k": Free(1.0, 0.0, 2.0)})})
    toml.write(scene, tmp_path / "own.toml")
    again = load(tmp_path / "own.toml")
    assert again.forces == scene.forces
    with pytest.raises(SceneError, match="wants to run code of 'unheard:of'"):
        Rollout(again, 1, "cpu")


# Of OpenSim 4.6's CoordinateLimitForce, as N m at an angle or N at a place, with a speed of 0.7.
SLIDING = {"low": -0.3, "high": 0.2, "stiffness_below": 300.0, "stiffness_above": 200.0, "damping": 5.0,
    "transition": 0.04}  # fmt: skip
BEYOND = {0.1: 0.0, 0.21: -0.5693359374999967, 0.22: -3.75, 0.3: -23.5, -0.31: -0.0517578125, -0.5: 56.5}


@wp.kernel
def limit_efforts(q: wp.array[float], limit: devices.CoordinateLimit, effort: wp.array[float]):
    i = wp.tid()
    effort[i] = devices.coordinate_limit_effort(q[i], 0.7, limit)


def test_a_limit_of_a_coordinate_pushes_as_opensims():
    limit = devices.CoordinateLimit()
    for name, value in SLIDING.items():
        setattr(limit, name, value)
    effort = wp.zeros(len(BEYOND), dtype=float, device="cpu")
    at = wp.array(list(BEYOND), dtype=float, device="cpu")
    wp.launch(limit_efforts, dim=len(BEYOND), inputs=[at, limit], outputs=[effort], device="cpu")
    np.testing.assert_allclose(effort.numpy(), list(BEYOND.values()), atol=2e-5)
