"""Steps of the controller by quadratic programmes against a linear pendulum in float64."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from probes import filled
from scipy.spatial.transform import Rotation

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.program.controller import ProgramParameters, quadratic_program
from warpmuscle.kernels.program.stepping import (
    DEEPER,
    STEP_FLOATS,
    StepPlan,
    foothold,
    has_landed,
    hill,
    pendulum_wanted,
    plan_step,
    pressure_of_step,
    smooth_way,
    sole_middle,
    swing_path,
)
from warpmuscle.kernels.program.structs import Frames, Layout
from warpmuscle.kernels.structs import Contacts, Feet, Model, Skeleton, State
from warpmuscle.scene import Controller
from warpmuscle.simulation.rollout import Rollout

RATE, TIME, SPEED, WIDTH, DOUBLE = 3.2, 0.5, 0.7, 0.12, 0.2  # 1/s, s, m/s, m
STANDS = np.array([0.3, 0.02, 1.5])  # m


@wp.kernel(enable_backward=False)
def planned(
    p: ProgramParameters, stands: wp.vec3, out: float, rate: float, xi: wp.array[wp.vec3], phase: wp.array[float],
    speed: float, feet: wp.array[wp.vec3], pressure: wp.array[wp.vec3],
):  # fmt: skip
    i = wp.tid()
    feet[i] = foothold(p, stands, out, rate, xi[i], phase[i], speed)
    pressure[i] = pressure_of_step(p, stands, out, rate, xi[i], phase[i], speed)


@wp.kernel(enable_backward=False)
def paths(p: ProgramParameters, memory: wp.array2d[float], found: wp.array2d[wp.vec3], shapes: wp.array2d[wp.vec3]):
    i = wp.tid()
    plan = StepPlan()
    swing_path(p, plan, memory[i])
    found[i, 0] = plan.place
    found[i, 1] = plan.velocity
    found[i, 2] = plan.acceleration
    shapes[i, 0] = smooth_way(memory[i, 0])
    shapes[i, 1] = hill(memory[i, 0])


@wp.kernel(enable_backward=False)
def middles(foot: wp.array[int], layout: Layout, model: Model, frames: Frames, found: wp.array[wp.vec3]):
    i = wp.tid()
    found[i] = sole_middle(0, foot[i], layout, model, frames)


def parameters(**changes: float) -> ProgramParameters:
    p = ProgramParameters()
    given = {"step_time": TIME, "double_support": DOUBLE, "step_width": WIDTH, "step_height": 0.06, "sway": 1.0}
    for name, value in (given | changes).items():
        setattr(p, name, value)
    return p


def plans(xi: np.ndarray, phase: np.ndarray, out: float, **changes: float) -> tuple[np.ndarray, np.ndarray]:
    """Footholds and pressures (n, 3)."""
    arrays = [wp.zeros(len(phase), dtype=wp.vec3, device="cpu") for _ in range(2)]
    given = wp.array(xi.astype(np.float32), dtype=wp.vec3, device="cpu"), wp.array(phase, dtype=float, device="cpu")
    inputs = [parameters(**changes), wp.vec3(*STANDS), out, RATE, *given, SPEED]
    wp.launch(planned, len(phase), inputs, arrays, device="cpu")
    return arrays[0].numpy(), arrays[1].numpy()


def steady(phase: np.ndarray, out: float) -> np.ndarray:
    """xi (n, 3) of a walk that repeats itself, whose foot carries from the middle of double support on."""
    grown = np.exp(RATE * TIME)
    begin = np.array([out * WIDTH / (1.0 + grown), 0.9, SPEED * TIME / (grown - 1.0)])
    return STANDS + begin * np.exp(RATE * (phase - 0.5 * DOUBLE) * TIME)[:, None] * [1, 0, 1] + [0, 0.9, 0]


@pytest.mark.parametrize("out", [1.0, -1.0])
def test_a_steady_walk_puts_its_feet_a_step_ahead_and_a_width_aside(out):
    phase = np.linspace(0.0, 1.0, 9)
    feet, pressure = plans(steady(phase, out), phase, out)
    wanted = STANDS + np.array([out * WIDTH, -float(DEEPER), SPEED * TIME])
    assert feet == pytest.approx(np.tile(wanted, (9, 1)), abs=1e-5)
    assert pressure == pytest.approx(np.tile(STANDS, (9, 1)), abs=1e-5)  # nothing is off


def test_a_foot_goes_where_the_body_falls_and_pressure_ahead_of_it():
    phase = np.full(2, 0.6)
    usual, push = steady(phase, 1.0), np.array([[0.01, 0.0, 0.02], [0.0, 0.0, 0.0]])
    feet, pressure = plans(usual + push, phase, 1.0)
    grown = np.exp(RATE * (0.4 + 0.5 * DOUBLE) * TIME)
    assert feet[0] - feet[1] == pytest.approx(grown * push[0], abs=1e-5)
    assert pressure[0] - pressure[1] == pytest.approx(2.0 * push[0], abs=1e-5)  # 1 + sway


def test_a_foot_swings_from_where_it_stood_to_its_place():
    phase = np.linspace(0.0, 1.2, 241)
    memory = np.zeros((len(phase), STEP_FLOATS), np.float32)
    memory[:, 0], memory[:, 3:6], memory[:, 6:9] = phase, [0.1, 0.02, 1.0], [0.14, 0.0, 1.6]
    found, shapes = (wp.zeros((len(phase), k), dtype=wp.vec3, device="cpu") for k in (3, 2))
    given = wp.array(memory, dtype=float, device="cpu")
    wp.launch(paths, len(phase), [parameters(), given], [found, shapes], device="cpu")
    place, velocity, acceleration = found.numpy().astype(float).transpose(1, 0, 2)
    first, last = np.searchsorted(phase, [DOUBLE, 1.0])
    assert place[: first + 1] == pytest.approx(np.tile(memory[0, 3:6], (first + 1, 1)), abs=1e-6)
    assert place[last:] == pytest.approx(np.tile(memory[0, 6:9], (len(phase) - last, 1)), abs=1e-6)
    assert place[:, 1].max() == pytest.approx(0.06 + 0.01, abs=1e-3)
    step, inside = (phase[1] - phase[0]) * TIME, slice(first + 2, last - 2)
    for rate, of in ((velocity, place), (acceleration, velocity)):
        slope = np.gradient(of, step, axis=0)
        assert rate[inside] == pytest.approx(slope[inside], abs=3e-3 * np.abs(rate).max())


@pytest.mark.parametrize("out", [-1.0, 1.0])
def test_footholds_are_within_reach_and_to_the_own_side(out: float):
    """0.6 m at most in each direction, 8 cm at least to the side of the foot that stands."""
    far = STANDS + np.array([[3.0, 0.0, 3.0], [-3.0, 0.0, -3.0]])
    feet = plans(far, np.array([0.4, 0.4]), out)[0] - STANDS
    assert np.sort(out * feet[:, 0]) == pytest.approx([0.08, 0.6], abs=1e-6)
    assert np.sort(feet[:, 2]) == pytest.approx([-0.6, 0.6], abs=1e-6)


def test_the_middle_of_a_sole_is_that_of_its_points():
    """Four points of one foot, one of another, none of a third, on a slope."""
    rng = np.random.default_rng(5)
    place, radius, normal = rng.normal(size=(6, 3)), rng.uniform(0.01, 0.05, 6), np.array([0.0, 0.8, 0.6])
    turns, origins = Rotation.random(3, random_state=2), rng.normal(size=(3, 3))
    contacts = filled(Contacts, point={"place": place[None], "radius": radius[None]}, normal=np.float32([[normal]]))
    model = Model()
    model.contacts = contacts
    frames = filled(Frames, position=np.float32([origins]), orientation=np.float32([turns.as_quat()]))
    owners = np.array([[1, 0], [2, 1], [3, 0], [0, 0], [5, 0]], dtype=np.int32)  # point 4 is of none
    layout, found = filled(Layout, point=owners), wp.zeros(3, dtype=wp.vec3, device="cpu")
    wp.launch(middles, 3, [wp.array([0, 1, 2], dtype=int, device="cpu"), layout, model, frames], [found], device="cpu")
    for foot, its in enumerate(([1, 3, 0, 5], [2], [])):
        touching = [turns[foot].apply(place[k]) - radius[k] * normal for k in its]
        expected = origins[foot] + (np.mean(touching, axis=0) if its else 0.0)
        assert found.numpy()[foot] == pytest.approx(expected, abs=1e-6)


@wp.kernel(enable_backward=False)
def landings(p: ProgramParameters, model: Model, state: State, phase: wp.array[float], found: wp.array2d[int]):
    i, side = wp.tid()
    found[i, side] = wp.where(has_landed(0, side, p, model, state, phase[i]), 1, 0)


def test_a_foot_has_landed_when_it_bears_or_has_had_its_time():
    """A twentieth of the weight, from three quarters of its way; the left foot bears less."""
    model = filled(Model, gravity=np.float32([[9.8]]))
    model.skeleton = filled(Skeleton, total_mass=np.float32([[70.0]]))
    weight = 70.0 * 9.8
    state = filled(State, foot_force=np.float32([[[0.0, 0.045 * weight, 0.0], [0.0, 0.055 * weight, 0.0]]]))
    phase = wp.array(
        [DOUBLE + share * (1.0 - DOUBLE) for share in (0.74, 0.76)] + [1.29, 1.31], dtype=float, device="cpu"
    )
    found = wp.zeros((4, 2), dtype=int, device="cpu")
    wp.launch(landings, (4, 2), [parameters(), model, state, phase], [found], device="cpu")
    assert found.numpy().tolist() == [[0, 0], [0, 1], [0, 1], [1, 1]]


def test_by_default_pressure_lets_errors_go_as_fast_as_they_would_grow():
    """xi' = w (xi - p): what xi is off from a steady step changes by -w of itself."""
    phase, off = np.full(2, 0.6), np.array([[0.01, 0.0, 0.02], [0.0, 0.0, 0.0]])
    xi = steady(phase, 1.0) + off
    pressure = plans(xi, phase, 1.0, sway=dict(quadratic_program.defaults)["sway"])[1]
    rate = RATE * (xi - pressure)
    assert (rate[0] - rate[1])[[0, 2]] == pytest.approx(-RATE * off[0, [0, 2]], abs=1e-5)


@wp.kernel(enable_backward=False)
def begin(
    p: ProgramParameters, layout: Layout, model: Model, state: State, frames: Frames, memory: wp.array2d[float],
    found: wp.array2d[float],
):  # fmt: skip
    i = wp.tid()
    plan = plan_step(i, p, layout, model, state, frames, memory[i])
    found[i, 0] = plan.rate
    found[i, 1] = plan.height
    found[i, 2] = plan.pressure[0]


def test_before_its_first_step_each_body_brings_its_weight_over_its_own_left_foot():
    """Of two instances whose feet stand elsewhere: the pendulum is as high as the centre of mass over their middle."""
    feet = np.array([[[9, 9, 9], [0.1, 0.02, 0.0], [-0.1, 0.04, 0.0]], [[7, 7, 7], [0.3, 0.3, 1.0], [0.1, 0.1, 1.0]]])
    center = np.array([[[0.02, 0.93, 0.0], [0.0, 0.0, 0.0]], [[0.2, 1.3, 1.0], [0.0, 0.0, 0.0]]])
    still = np.tile(np.float32([0, 0, 0, 1]), (2, 3, 1))
    frames = filled(Frames, position=np.float32(feet), orientation=still, center=np.float32(center))
    model = filled(Model, gravity=np.float32([[9.8]]), feet=filled(Feet, left=1, right=2))
    place = {"place": np.zeros((1, 2, 3)), "radius": np.zeros((1, 2))}
    model.contacts = filled(Contacts, point=place, normal=np.float32([[[0, 1, 0]]]))
    layout = filled(Layout, point=np.int32([[0, 1], [1, 2]]))
    memory, found = (wp.zeros((2, k), dtype=float, device="cpu") for k in (STEP_FLOATS, 3))
    wp.launch(begin, 2, [parameters(), layout, model, State(), frames, memory], [found], device="cpu")
    middle, half = feet[:, 1:].mean(axis=1), 0.1  # m, half the distance between the feet
    height, xi = center[:, 0, 1] - middle[:, 1], center[:, 0, 0]
    pressure = np.clip(xi + (xi - middle[:, 0] - 0.9 * half), feet[:, 2, 0], feet[:, 1, 0])
    expected = np.stack([np.sqrt(9.8 / height), center[:, 0, 1], pressure], axis=1)
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5, atol=1e-6)


@wp.kernel(enable_backward=False)
def pendulums(p: ProgramParameters, plan: StepPlan, frames: Frames, found: wp.array[wp.vec3]):
    i = wp.tid()
    found[i] = pendulum_wanted(i, p, plan, frames)


def test_the_centre_of_mass_falls_away_from_the_pressure_and_keeps_its_height():
    """A linear inverted pendulum: c'' = w^2 (c - p) to the sides, a spring and a damper upwards."""
    center = np.array([[[0.3, 0.92, 1.1], [0.4, -0.3, 0.9]], [[-0.2, 0.97, 0.4], [0.0, 0.2, -0.1]]])
    plan, pressure = StepPlan(), np.array([0.25, 0.02, 1.3])
    plan.pressure, plan.rate, plan.height = wp.vec3(*pressure), RATE, 0.95
    found, frames = wp.zeros(2, dtype=wp.vec3, device="cpu"), filled(Frames, center=np.float32(center))
    wp.launch(pendulums, 2, [parameters(com_kp=120.0, com_kd=22.0), plan, frames], [found], device="cpu")
    place, velocity = center[:, 0], center[:, 1]
    expected = RATE**2 * (place - pressure)
    expected[:, 1] = 120.0 * (0.95 - place[:, 1]) - 22.0 * velocity[:, 1]
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5)


def test_a_body_without_feet_does_not_step():
    from muscle_arm import arm

    controller = Controller(type="quadratic_program", parameters={"step_time": 0.5}, by_body={"others": {}})
    with pytest.raises(SceneError, match="needs feet"):
        Rollout(arm(controller=controller), 1, "cpu")


@pytest.mark.long
def test_gait2392_walks_on_its_muscles(optimized_test):
    """20 starts, 0.1 m/s of noise in each direction; a fall or two in forty is known."""
    from dataclasses import replace

    from warpmuscle.simulation.perturbations import none

    rollout = Rollout("gait2392_program_walk", 20, "cpu")
    rollout.disturb(replace(none(20), velocity=0.1 * np.random.default_rng(0).normal(size=(20, 3))))
    rollout.run(10.0)
    assert sum(name in ("running", "completed") for name in rollout.status_names()) >= 19
    assert np.median(rollout.state.coordinates.numpy()[:, 2]) > 5.0
