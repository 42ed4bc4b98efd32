"""What a programme is given of muscles and torques, and what muscles are told of its answer."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.muscle_structs import Muscles
from warpmuscle.kernels.object_structs import ObjectExtension
from warpmuscle.kernels.program.controller import BODY_FLOATS, REPORTED, BodyTask, JointTask, ProgramParameters
from warpmuscle.kernels.program.gather import gather_forces, gather_tasks, tell_muscles
from warpmuscle.kernels.program.stepping import STEP_FLOATS
from warpmuscle.kernels.program.structs import Columns, Frames, Layout, Programs, ProgramWork
from warpmuscle.kernels.structs import Contacts, Model, MuscleState, Skeleton, State

EVERY, STEP = 10, 0.001  # steps between decisions, and s
RISE = np.array([[0.01, 0.02, 0.015], [0.03, 0.012, 0.025]])  # s, by instance and muscle
FALL = np.array([[0.05, 0.04, 0.06], [0.03, 0.07, 0.045]])
NOW = np.array([[0.2, 0.5, 0.4], [0.3, 0.6, 0.5]])  # activations
AIM = np.array([[0.3, 0.45, 0.42], [0.38, 0.55, 0.56]])


@pytest.mark.parametrize("rows", [1, 2], ids=["one row for all", "a row each"])
def test_excitations_bring_activations_to_their_aim_until_the_next_decision(rows: int):
    """a(t) = e + (a - e) exp(-t/T), solved for e."""
    muscles = filled(Muscles, count=3, row={"rise_time": RISE[:rows], "fall_time": FALL[:rows]})
    model = filled(Model, time_step=STEP, muscles=muscles)
    state = filled(State, muscles=filled(MuscleState, activation=np.float32(NOW)))
    layout = filled(Layout, every=EVERY, torque=np.zeros((0, 2), np.int32))
    programs = filled(Programs, wanted=np.zeros((2, 1), np.float32), weight=np.zeros((2, 1), np.float32))
    chosen, iterations = (wp.array(values, dtype=int, device="cpu") for values in ([0, 1], [4, 5]))
    control, acceleration = (wp.array(np.float32(v), device="cpu") for v in (AIM, np.zeros((2, 1))))
    memory = wp.zeros((2, 1, REPORTED + 3), dtype=float, device="cpu")
    given = [chosen, model, state, layout, programs, control, acceleration, iterations]
    wp.launch(tell_muscles, 2, given, [memory], device="cpu")
    own = [0, rows - 1]
    rest = np.exp(-EVERY * STEP / np.where(AIM > NOW, RISE[own], FALL[own]))
    wanted = (AIM - NOW * rest) / (1.0 - rest)
    assert np.all((wanted > 0.0) & (wanted < 1.0))
    np.testing.assert_allclose(memory.numpy()[:, 0, REPORTED:], wanted, rtol=1e-4)
    np.testing.assert_array_equal(memory.numpy()[:, 0, 1], [4.0, 5.0])


def test_what_is_told_of_an_answer_is_its_error_weighed_and_how_hard_points_push():
    """sqrt(e^T W e), e = wanted - found, and the sum of what is neither a muscle nor a torque."""
    wanted, found = np.array([[1.0, -2.0], [0.5, 3.0]]), np.array([[0.7, -1.2], [2.0, 2.5]])
    weight = np.array([[4.0, 0.5, 0.5, 2.0], [1.0, -0.25, -0.25, 3.0]])
    control = np.array([[0.3, 0.45, 0.42, 9.0, 4.0, 2.5], [0.38, 0.55, 0.56, -7.0, 1.5, 3.0]])
    muscles = filled(Muscles, count=3, row={"rise_time": RISE, "fall_time": FALL})
    state = filled(State, muscles=filled(MuscleState, activation=np.float32(NOW)))
    programs = filled(Programs, wanted=np.float32(wanted), weight=np.float32(weight))
    chosen, iterations = (wp.array(values, dtype=int, device="cpu") for values in ([0, 1], [4, 5]))
    given = [chosen, filled(Model, time_step=STEP, muscles=muscles), state]
    given += [filled(Layout, every=EVERY, torque=np.int32([[0, 0]])), programs]
    given += [wp.array(np.float32(values), device="cpu") for values in (control, found)]
    memory = wp.zeros((2, 1, REPORTED + 4), dtype=float, device="cpu")
    wp.launch(tell_muscles, 2, [*given, iterations], [memory], device="cpu")
    error = wanted - found
    unmet = np.sqrt(np.einsum("is,isq,iq->i", error, weight.reshape(2, 2, 2), error))
    np.testing.assert_allclose(memory.numpy()[:, 0, 0], unmet, rtol=1e-5)
    np.testing.assert_allclose(memory.numpy()[:, 0, 2], [6.5, 4.5], rtol=1e-6)
    np.testing.assert_array_equal(memory.numpy()[:, 0, REPORTED + 3], [9.0, -7.0])


def test_muscles_and_torques_cost_and_give_what_their_numbers_say():
    """Two muscles across one coordinate and two torques, of which the last has no bound to speak of."""
    effort, torque_effort, bounds, arms, active, passive = (
        0.5,
        0.25,
        [30.0, 0.0],
        [0.04, -0.03],
        [800.0, 500.0],
        [40.0, 9.0],
    )
    muscles = filled(Muscles, count=2, row={"rise_time": RISE[:1, :2], "fall_time": FALL[:1, :2]})
    skeleton = filled(Skeleton, total_mass=np.float32([[70.0]]))
    contacts = filled(Contacts, normal=np.float32([[[0.0, 1.0, 0.0]]]))
    model = filled(Model, time_step=STEP, body_count=1, gravity=np.float32([[9.8]]))
    model.muscles, model.skeleton, model.contacts = muscles, skeleton, contacts
    state = filled(State, muscles=filled(MuscleState, activation=np.float32(NOW[:1, :2])))
    layout = filled(
        Layout, every=EVERY, lever=np.int32([0, 1]), torque=np.int32([[0, 0], [1, 1]]),
        point=np.zeros((0, 2), np.int32), support=np.zeros((0, 3), np.int32),
    )  # fmt: skip
    columns = filled(Columns, first=np.int32([0, 1, 2, 3, 4]), row=np.int32([0, 0, 0, 1]))
    empty = {name: np.zeros((1, 4), np.float32) for name in ("entry", "gain", "low", "high")}
    programs = filled(Programs, bias=np.zeros((1, 2), np.float32), **empty)
    parameters = structs_to_device(
        ProgramParameters, {"effort": np.float32([[effort]]), "torque_effort": np.float32([[torque_effort]])}, "cpu"
    )
    by_joint = structs_to_device(JointTask, {"torque": np.float32([bounds])}, "cpu")
    rows = [wp.array(np.float32([v]), dtype=float, device="cpu") for v in (arms, active, passive, [5.0, -2.0], [0.0])]
    chosen, row = wp.array([0], dtype=int, device="cpu"), wp.zeros((1, 2, 2), dtype=float, device="cpu")
    given = [chosen, model, state, Frames(), layout, parameters, by_joint, ObjectExtension(), columns, *rows, row]
    wp.launch(gather_forces, 1, given, [programs], device="cpu")
    time, now = EVERY * STEP, NOW[0, :2]
    np.testing.assert_allclose(programs.bias.numpy()[0], [5.0 - np.dot(arms, passive), -2.0], rtol=1e-6)
    np.testing.assert_allclose(programs.entry.numpy()[0], [*np.multiply(arms, active), 1.0, 1.0], rtol=1e-6)
    np.testing.assert_allclose(programs.gain.numpy()[0, :3], [1.0 / effort] * 2 + [30.0**2 / torque_effort], rtol=1e-6)
    assert 0.0 < programs.gain.numpy()[0, 3] < 1e-3
    low, high = now * np.exp(-time / FALL[0, :2]), 1.0 - (1.0 - now) * np.exp(-time / RISE[0, :2])
    np.testing.assert_allclose(programs.low.numpy()[0], [*low, -30.0, 0.0], rtol=1e-5)
    np.testing.assert_allclose(programs.high.numpy()[0], [*high, 30.0, 0.0], rtol=1e-5)


def test_nothing_is_wanted_of_who_has_no_task():
    """Also where an earlier decision has left numbers: W is that of speeds without a task, and accelerations are 0."""
    bodies, steps = 0, BODY_FLOATS
    memory = np.zeros((1, 1, steps + STEP_FLOATS), np.float32)
    memory[0, 0, bodies] = 1.0  # the start is known
    nothing = {"point": np.zeros((0, 2), np.int32), "support": np.zeros((0, 3), np.int32)}
    layout = filled(Layout, bodies=bodies, steps=steps, center=steps, **nothing)
    frames = filled(Frames, orientation=np.float32([[[0, 0, 0, 1]]]), angular_velocity=np.zeros((1, 1, 3), np.float32))
    programs = filled(Programs, weight=np.full((1, 4), 7.0, np.float32), wanted=np.full((1, 2), 7.0, np.float32))
    work = filled(ProgramWork, factor=np.zeros((1, 3)), vector=np.zeros((1, 4, 2)))
    tasks = [
        structs_to_device(kind, {name: np.zeros((1, 1), np.float32)}, "cpu")
        for kind, name in ((ProgramParameters, "effort"), (JointTask, "weight"), (BodyTask, "weight"))
    ]
    chosen, pull = wp.array([0], dtype=int, device="cpu"), wp.array(np.full((1, 2), 7.0), dtype=float, device="cpu")
    row, bound = wp.zeros((1, 2, 2), dtype=float, device="cpu"), wp.zeros((1, 0), dtype=float, device="cpu")
    given = [
        chosen,
        filled(Model, body_count=1),
        State(),
        frames,
        layout,
        *tasks,
        ObjectExtension(),
        wp.array(memory, dtype=float, device="cpu"),
    ]
    wp.launch(gather_tasks, 1, [*given, programs, work, pull, row], [bound], device="cpu")
    weight = programs.weight.numpy().reshape(2, 2)
    assert weight[0, 1] == weight[1, 0] == 0.0
    assert 0.0 < weight[0, 0] == weight[1, 1] < 1e-3
    np.testing.assert_array_equal(programs.wanted.numpy(), 0.0)
