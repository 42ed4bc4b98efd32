"""Tasks of the controller by quadratic programmes against kinematics, and its accelerations against the simulation."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from probes import filled

from muscle_arm import REACH, leg
from warpmuscle.kernels.program.controller import ProgramParameters
from warpmuscle.kernels.program.structs import Frames
from warpmuscle.kernels.program.tasks import center_wanted
from warpmuscle.scene import Controller, MuscleModel, Scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

POINT = np.array([0.02, -0.3, 0.05])  # m, of the shank
GAINS = {"kp": 0.0, "kd": 0.0}


def told(parameters: dict[str, float], joint: dict[str, float], shank: dict[str, float]) -> Scene:
    """The leg on a root that is free to move."""
    controller = Controller(
        type="quadratic_program", parameters={"rate": 1000.0, "effort": 1e-2, "contact_weight": 0.0, **parameters},
        by_joint={"others": joint}, by_body={"shank": shank, "others": {}},
    )  # fmt: skip
    scene = leg(controller=controller, muscle_model=MuscleModel(tendon="rigid", damping=0.0), time_step=0.001)
    scene.character.root_joint = "free"
    return scene


def moving(rollout: Rollout) -> tuple[np.ndarray, np.ndarray]:
    """Put the leg to a state where everything turns; its coordinates and speeds."""
    q, v = rollout.state.coordinates.numpy().astype(float), rollout.state.speeds.numpy().astype(float)
    random = np.random.default_rng(4)
    for first in (3, 7):
        turn = np.r_[0.4 * random.normal(size=3), 1.0]
        q[:, first : first + 4] = turn / np.linalg.norm(turn)
    q[:, 11] = -0.5
    v[:] = random.normal(size=v.shape)
    rollout.state.coordinates.assign(q.astype(np.float32))
    rollout.state.speeds.assign(v.astype(np.float32))
    return q, v


def decide(rollout: Rollout) -> None:
    """Let the only instance decide."""
    own, objects = rollout._extensions.struct.first, rollout._extensions.objects
    rollout._program.decide(rollout.model, rollout.state, own, objects, *np.zeros((2, 1), np.int32))


def sums(scene: Scene) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """W, the speeds, and the kinematics of the moving leg."""
    rollout, stages = Rollout(scene, 1, "cpu"), Stages(scene, 1, "cpu")
    q, v = moving(rollout)
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    program = rollout._program
    decide(rollout)
    n = v.shape[1]
    weight = program.batch.numbers.weight.numpy()[0].reshape(n, n).astype(float)
    return weight, v[0], stages.forward_kinematics()


CASES = {
    "center of mass": ({"com_weight": 3.0}, {}),
    "point": ({}, {"weight": 3.0, "point_x": POINT[0], "point_y": POINT[1], "point_z": POINT[2]}),
    "orientation": ({}, {"turn_weight": 3.0}),
}


@pytest.mark.parametrize("case", CASES)
def test_weights_are_those_of_velocities(case):
    """q' W q' = weight |velocity|^2, with the velocity that kinematics has."""
    parameters, shank = CASES[case]
    weight, v, found = sums(told(parameters, {}, shank))
    assert np.array_equal(weight, weight.T) or np.abs(weight - weight.T).max() < 1e-5
    turning = found["angular_velocity"][0, 2]
    if case == "center of mass":
        velocity = found["com"][0, 1]
    elif case == "orientation":
        velocity = turning
    else:
        q, com = found["orientation"][0, 2], np.array([0.0, -0.2, 0.0])  # of the shank from its joint
        arm = POINT - com
        rotated = arm + 2.0 * np.cross(q[:3], np.cross(q[:3], arm) + q[3] * arm)
        velocity = found["velocity"][0, 2] + np.cross(turning, rotated)
    assert v @ weight @ v == pytest.approx(3.0 * velocity @ velocity, rel=1e-4)


def test_the_centre_of_mass_is_not_asked_for_what_it_does_by_itself():
    """A shank that turns about a knee at rest is drawn to it by w^2 r, of which the whole body has a third."""
    scene = told({"com_weight": 3.0, "com_kp": 0.0, "com_kd": 0.0}, {}, {})
    rollout, turning = Rollout(scene, 1, "cpu"), 2.0
    speeds = np.zeros(rollout.state.speeds.shape, np.float32)
    speeds[0, -1] = turning
    rollout.state.speeds.assign(speeds)
    program = rollout._program
    decide(rollout)
    pull = program._pull.numpy().reshape(-1)[:3]  # of the root's place, which moves all bodies alike
    np.testing.assert_allclose(pull, [0.0, -3.0 * turning**2 * REACH / 3.0, 0.0], atol=1e-4)


def test_joints_weigh_for_themselves():
    weight = sums(told({}, {"weight": 2.0, **GAINS}, {}))[0]
    assert np.diag(weight)[6:] == pytest.approx(2.0, rel=1e-5)
    assert np.abs(weight - np.diag(np.diag(weight))).max() == 0.0


def test_a_body_accelerates_as_the_programme_says(unoptimized_kernels):
    """Mass matrix, velocity products, gravity, moment arms and forces of muscles are those of the simulation."""
    scene = told({"com_weight": 1.0}, {"weight": 1.0, "kp": 50.0, "kd": 5.0}, {"weight": 0.5, "point_y": -0.3})
    rollout = Rollout(scene, 1, "cpu")
    moving(rollout)
    rollout.step(1)
    program = rollout._program
    assert rollout.state.muscles.activation.numpy()[0] == pytest.approx(program.batch.control.numpy()[0, :3], abs=1e-5)
    got = rollout.state.accelerations.numpy()[0]
    assert np.abs(got).max() > 5.0
    assert program.batch.acceleration.numpy()[0] == pytest.approx(got, abs=0.02 * float(np.abs(got).max()))


@wp.kernel(enable_backward=False)
def centers(p: ProgramParameters, start: wp.vec3, frames: Frames, found: wp.array[wp.vec3]):
    i = wp.tid()
    found[i] = center_wanted(i, p, start, frames)


def test_the_centre_of_mass_is_drawn_to_its_place_and_its_velocity_is_damped():
    center = np.array([[[0.3, 0.92, 1.1], [0.4, -0.3, 0.9]], [[-0.2, 0.97, 0.4], [0.0, 0.2, -0.1]]])
    start, move, p = np.array([0.1, 0.9, 0.8]), np.array([0.02, -0.1, 0.05]), ProgramParameters()
    p.com_x, p.com_y, p.com_z, p.com_kp, p.com_kd = *move, 90.0, 18.0
    found, frames = wp.zeros(2, dtype=wp.vec3, device="cpu"), filled(Frames, center=np.float32(center))
    wp.launch(centers, 2, [p, wp.vec3(*start), frames], [found], device="cpu")
    expected = 90.0 * (start + move - center[:, 0]) - 18.0 * center[:, 1]
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5)
