"""A controller by quadratic programmes: its tasks, its decisions, and what becomes of them in a simulation."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.core.status import Status
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation, Controller, MuscleModel, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import unrecorded

RATE = 200.0


def controlled(move: float = 0.4, **changes: Any) -> Scene:
    """The arm that is to bend by an angle, rad, and stay there."""
    parameters = {"rate": RATE, "effort": 1e-3, "contact_weight": 0.0, **changes.pop("parameters", {})}
    joint = {"weight": 1.0, "kp": 100.0, "kd": 20.0, "move": move, **changes.pop("joint", {})}
    body = changes.pop("body", {})
    controller = Controller(
        type="quadratic_program", parameters=parameters, by_joint={"elbow": joint}, by_body={"tip": body, "others": {}}
    )
    model = MuscleModel(tendon="rigid", damping=0.0)
    return arm(controller=controller, muscle_model=model, duration=2.0, time_step=0.001, **changes)


@pytest.fixture(scope="module")
def bent(unoptimized_kernels) -> Rollout:
    """Three arms, each to another angle."""
    scene = controlled(Free(0.4, min=0.0, max=0.8))
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2], record_rate=RATE)
    rollout.set_parameters(np.array([[0.4], [0.2], [0.6]]))
    rollout.run()
    return rollout


def elbow_angle(motion: Recording) -> np.ndarray:
    """Angle of the elbow in every frame, rad."""
    q = motion["joint_orientation"][:, 0]
    return np.asarray(2.0 * np.arctan2(q[:, 0], q[:, 3]))


def test_an_arm_bends_as_far_as_it_is_told_and_stays(bent):
    assert bent.state.coordinates.numpy()[:, -1] == pytest.approx([0.4, 0.2, 0.6], abs=0.01)
    assert np.abs(bent.state.speeds.numpy()).max() < 0.01


def test_it_gets_there_as_the_gains_say(bent):
    """x'' = kp (target - x) - kd x' with kd^2 = 4 kp: 1 - (1 + 10 t) exp(-10 t) of the way."""
    motion = bent.recording(0)
    time, angle = np.asarray(motion.time), elbow_angle(motion)
    wanted = 0.4 * (1.0 - (1.0 + 10.0 * time) * np.exp(-10.0 * time))
    assert np.abs(angle - wanted).max() < 0.02


def test_bits_depend_on_no_number_of_threads(unoptimized_kernels):
    """Also where some begin later, so that they decide in other steps, and where one has ended."""
    found, scene = [], msgspec.structs.replace(controlled(Free(0.4, min=0.0, max=0.8)), duration=0.2)
    for threads in (1, 3):
        rollout = Rollout(scene, 7, "cpu", threads=threads)
        rollout.set_parameters(np.linspace(0.1, 0.7, 7)[:, None])
        rollout.run(0.083)
        rollout.reset(mask=np.arange(7) % 3 == 0)
        rollout.step(150)
        found.append([rollout.status(), rollout.state.coordinates.numpy(), rollout.controller_state])
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)
    assert set(found[0][0].tolist()) == {Status.RUNNING, Status.COMPLETED}


def test_bits_depend_on_no_other_instance(bent):
    alone = Rollout(controlled(Free(0.4, min=0.0, max=0.8)), 1, "cpu")
    alone.set_parameters(np.array([[0.6]]))
    alone.run()
    assert np.array_equal(alone.state.coordinates.numpy()[0], bent.state.coordinates.numpy()[2])


def test_bits_do_not_depend_on_where_a_run_pauses(bent):
    paused = Rollout(controlled(Free(0.4, min=0.0, max=0.8)), 1, "cpu")
    for steps in (1, 2, 4, 93, 400, 1500):
        paused.step(steps)
    assert np.array_equal(paused.state.coordinates.numpy()[0], bent.state.coordinates.numpy()[0])


def test_one_that_starts_again_decides_as_at_first(bent):
    again = Rollout(controlled(Free(0.4, min=0.0, max=0.8)), 2, "cpu")
    again.step(103)
    again.reset(mask=np.array([False, True]))
    again.step(100)
    once = Rollout(controlled(Free(0.4, min=0.0, max=0.8)), 1, "cpu")
    once.step(100)
    assert np.array_equal(again.state.coordinates.numpy()[1], once.state.coordinates.numpy()[0])


def test_activations_come_to_what_was_decided(unoptimized_kernels):
    rollout = Rollout(controlled(), 1, "cpu")
    program = rollout._program
    for _ in range(5):
        rollout.step(program.every)
        assert rollout.state.muscles.activation.numpy()[0] == pytest.approx(
            program.batch.control.numpy()[0, :2], abs=1e-4
        )
    assert program.batch.iterations.numpy()[0] >= 0


def test_a_point_comes_as_near_as_it_can(unoptimized_kernels):
    """Told to go 0.1 m forwards from 0.3 m below the elbow, it ends where the line from there meets its arc."""
    body = {"weight": 1.0, "kp": 100.0, "kd": 20.0, "point_y": -0.3, "move_z": 0.1}
    rollout = Rollout(controlled(joint={"weight": 0.0}, body=body), 1, "cpu")
    rollout.run()
    assert rollout.state.coordinates.numpy()[0, -1] == pytest.approx(-np.arctan2(0.1, 0.3), abs=0.01)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"parameters": {"rate": 5000.0}}, "at 1 Hz to 1000 Hz"),
        ({"parameters": {"rate": Free(100.0, min=50.0, max=200.0)}}, "cannot be a free parameter"),
        ({"parameters": {"pace": 1.0}}, "no parameter is called 'pace'"),
        ({"joint": {"stiffness": 1.0}}, "no parameter is called 'stiffness'"),
        ({"body": {"mass": 1.0}}, "no parameter is called 'mass'"),
    ],
)
def test_what_it_cannot_take_is_said(changes, said):
    with pytest.raises(SceneError, match=said):
        Rollout(controlled(**changes), 1, "cpu")


def test_steps_that_nobody_waits_for_are_refused():
    rollout = Rollout(controlled(), 1, "cpu")
    with pytest.raises(RolloutError, match="decides between steps"):
        rollout.stepper(unrecorded, {})


def test_torques_do_what_muscles_need_not(unoptimized_kernels):
    scene = controlled(joint={"torque": 30.0}, actuation={"elbow": Actuation(drive="torque")})
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.state.coordinates.numpy()[0, -1] == pytest.approx(0.4, abs=0.01)


@pytest.mark.long
def test_92_muscles_stand_where_they_are_pushed():
    """10 N s at the pelvis, in eight directions."""
    turn = np.pi / 4.0 * np.arange(8)
    push = 10.0 * np.stack([np.sin(turn), 0.0 * turn, np.cos(turn)], axis=1)
    rollout = Rollout("gait2392_stand", 8, "cpu")
    rollout.disturb(replace(none(8), push=push, push_start=np.full(8, 0.5)))
    rollout.run(2.5)
    assert set(rollout.status_names()) == {"running"}
    assert np.abs(rollout.state.speeds.numpy()).max() < 0.3
