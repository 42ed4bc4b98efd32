"""Of which moment what a frame holds of its muscles is: against float64 integrations on the same excitations.

Each quantity is compared with the true one at the moment that `Quantity.at` names, and with those half a step and a
step aside, which must fit much worse. The true fibre is integrated in steps of a fortieth, along the recorded path.
"""

import numpy as np
import pytest
from hill import Reference
from probes import evaluate
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from muscle_arm import arm, constant
from warpmuscle.core.array_types import Floats
from warpmuscle.kernels.curve import curves
from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Actuation, Excitation, JointState, MuscleModel
from warpmuscle.simulation.rollout import Rollout

STEP = 0.002  # s
BEAT = Excitation([0.0, 0.03, 0.06], [0.05, 0.9, 0.05], period=0.06)
L_OPT, L_SLACK, V_MAX, DAMPING, RISE = 0.15, 0.1, 10.0, 0.1, 0.01
ASIDE = (-1.0, -0.5, 0.0, 0.5, 1.0)  # steps
BESIDE = "by the activation recorded beside it"
LENGTH = f"start of the step; with a compliant tendon: {BESIDE}"
SPEED = (
    f"middle of the step before, by moment arms of the start; with a compliant tendon: over the step before, {BESIDE}"
)


def swung(tendon: str = "rigid", excitation: Excitation = BEAT, **model: object) -> Recording:
    """Every step of an arm that swings against a muscle."""
    scene = arm(
        flexor={"excitation": excitation, "f_max": 60.0},
        muscle_model=MuscleModel(tendon=tendon, damping=DAMPING, **model),  # type: ignore[arg-type]
    )
    del scene.character.muscles["extensor"]
    scene.initial_state.joints = {"elbow": JointState((np.sin(0.3), 0.0, 0.0, np.cos(0.3)))}
    scene.time_step, scene.duration = STEP, 0.5
    scene.actuation = {"elbow": Actuation("assisted")}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / STEP)
    rollout.run()
    return rollout.recording()


def best(recorded: Floats, time: Floats, true, slope: int = 0) -> float:  # type: ignore[no-untyped-def]
    """By how many steps the moment is aside that fits; the others must be at least five times as far off."""
    inner = slice(20, -2)
    errors = [float(np.mean(np.abs(recorded[inner] - true(time[inner] + s * STEP, slope)))) for s in ASIDE]
    first, second = np.sort(errors)[:2]
    assert second > 5.0 * first, errors
    return ASIDE[int(np.argmin(errors))]


def told(name: str) -> str:
    """The moment that a quantity's label names."""
    return QUANTITIES[name].at


def angles(motion: Recording) -> Floats:
    """Of the elbow, rad."""
    return np.asarray(2.0 * np.arctan2(motion.joint_orientation[:, 0, 0], motion.joint_orientation[:, 0, 3]))


def path_of(angle: Floats) -> tuple[Floats, Floats]:
    """Length, m, and its slope, m/rad, from (0, 0.2, 0.04) over (0, 0.12, 0.04) to 0.1 m below the elbow."""
    y, z = -0.1, 0.04
    below, ahead = np.cos(angle) * y - np.sin(angle) * z, np.sin(angle) * y + np.cos(angle) * z
    last = np.hypot(below - 0.12, ahead - 0.04)
    return 0.08 + last, (-ahead * (below - 0.12) + below * (ahead - 0.04)) / last


def test_the_path_is_that_of_the_start_of_the_step():
    motion = swung()
    angle = angles(motion)
    assert angle[0] == pytest.approx(0.6, abs=1e-6)
    np.testing.assert_allclose(motion.muscle_path_length[:, 0], path_of(angle)[0], atol=1e-6)
    assert told("muscle_path_length") == "start of the step"


def test_a_rigid_fibre_has_the_length_of_the_start():
    motion = swung()
    fibre = CubicSpline(motion.time, motion.muscle_path_length[:, 0] - L_SLACK)
    assert best(motion.muscle_fibre_length[:, 0], motion.time, fibre) == 0.0
    assert told("muscle_fibre_length") == LENGTH


def test_a_rigid_fibre_has_the_speed_of_the_joints_in_the_middle_of_the_step_before_by_moment_arms_of_the_start():
    motion = swung()
    angle = angles(motion)
    turn = CubicSpline(motion.time, angle)
    errors = {}
    for speed in (-1.0, -0.5, 0.0, 0.5):
        for arm_at in (-1.0, -0.5, 0.0, 0.5):
            slope = path_of(turn(motion.time + arm_at * STEP))[1]
            true = slope * turn(motion.time + speed * STEP, 1)
            errors[speed, arm_at] = np.abs(motion.muscle_fibre_velocity[:, 0] - true)[20:-2].mean()
    assert min(errors, key=lambda key: errors[key]) == (-0.5, 0.0)
    assert sorted(errors.values())[1] > 5.0 * errors[-0.5, 0.0], errors
    assert told("muscle_fibre_velocity") == SPEED


@pytest.mark.parametrize(("neural", "aside"), [(False, 1.0), (True, 0.0)])
def test_activation_is_that_of_the_end_of_the_step_but_of_neural_dynamics_that_of_its_start(neural: bool, aside: float):
    """Of a constant excitation from an activation of 0.2 on: a' = (e - a)/10 ms, e' = (u - e)/3 ms or e = u."""
    model = {"activation": "neural", "neural_time": 0.003} if neural else {}
    motion = swung(excitation=constant(0.7), initial_activation=0.2, **model)

    def rates(_: float, state: Floats) -> list[float]:
        return [(state[1] - state[0]) / RISE, (0.7 - state[1]) / 0.003]

    time = np.linspace(0.0, 0.1, 51)
    start = [0.2, 0.2 if neural else 0.7]
    true = solve_ivp(rates, (0.0, 0.11), start, rtol=1e-10, atol=1e-12, dense_output=True).sol
    got = motion.muscle_activation[:50, 0]
    errors = {s: np.abs(got - true(time[:50] + s * STEP)[0]).max() for s in (0.0, 0.5, 1.0)}
    assert errors[aside] < 1e-4, errors
    assert min(error for s, error in errors.items() if s != aside) > 0.02
    assert told("muscle_activation") == "end of the step; of neural activation: start of the step"


def true_fibre(motion: Recording, path_later: float, activation_later: float) -> Floats:
    """Lengths, m, of a fibre on a compliant tendon at the frames, with path and activation of so many s later."""
    time, law = motion.time, Reference(LEE, np.array([1.0]), L_OPT, L_SLACK, 0.0, V_MAX, DAMPING)
    parts, last = 40, time[-1]
    fine = np.linspace(0.0, last, parts * (len(time) - 1) + 1)
    path = CubicSpline(time, motion.muscle_path_length[:, 0])(np.minimum(fine + path_later, last))
    known = CubicSpline(time + STEP, motion.muscle_activation[:, 0])  # of the end of the step, as shown above
    activation = known(np.clip(fine + activation_later, STEP, last + STEP))
    scale = V_MAX * L_OPT

    def speed(k: int, length: float) -> float:
        active = activation[k] * np.interp(length / L_OPT, law.x, law.active)
        pull = np.interp((path[k] - L_SLACK - length) / L_SLACK, law.strain, law.tendon)
        rest = pull - np.interp(length / L_OPT, law.x, law.passive)
        return float(scale * np.interp(rest, active * law.velocity[0][0] + DAMPING * law.v, law.v))

    length, found, h = float(motion.muscle_fibre_length[0, 0]), [], STEP / parts
    for k in range(len(fine) - 1):
        if k % parts == 0:
            found.append(length)
        first = speed(k, length)
        length += 0.5 * h * (first + speed(k + 1, length + h * first))
    return np.array([*found, length])


def test_a_fibre_on_a_compliant_tendon_is_that_of_the_path_at_the_start_by_the_activation_beside_it():
    motion = swung("compliant")
    lengths = {
        (path, activation): true_fibre(motion, path * STEP, activation * STEP)
        for path in (0.0, 1.0)
        for activation in (0.0, 1.0)
    }
    errors = {key: np.abs(one - motion.muscle_fibre_length[:, 0])[20:-2].mean() for key, one in lengths.items()}
    assert errors[0.0, 1.0] < 3e-6
    assert min(error for key, error in errors.items() if key != (0.0, 1.0)) > 4e-5, errors
    fibre = CubicSpline(motion.time, lengths[0.0, 1.0])
    assert best(motion.muscle_fibre_velocity[:, 0], motion.time, fibre, 1) == -0.5
    tendon = motion.muscle_path_length[:, 0] - lengths[0.0, 1.0]
    force = 60.0 * evaluate(curves.tendon_force_strain, LEE, tendon / L_SLACK - 1.0)
    np.testing.assert_allclose(motion.muscle_force[20:-2, 0], force[20:-2], atol=0.5)
    assert told("muscle_fibre_length") == LENGTH
    assert told("muscle_fibre_velocity") == SPEED


def test_force_accelerates_the_joints_at_the_start_of_the_step():
    """Inertia times the second difference of the angle about a frame is -(F dL/dq + m g l sin q) of that frame."""
    motion = swung()
    angle = angles(motion)
    acceleration = np.diff(angle, 2) / STEP**2
    pull, inertia = np.diff(motion.muscle_force[:, 0]), 0.03 + 2.0 * 0.2**2
    wanted = -(inertia * acceleration + 2.0 * 9.8 * 0.2 * np.sin(angle[1:-1])) / path_of(angle[1:-1])[1]
    errors = {}
    for later in (-1.0, -0.5, 0.0, 0.5, 1.0):
        force = np.interp(motion.time[1:-1] + later * STEP, motion.time, motion.muscle_force[:, 0])
        errors[later] = np.abs(force - wanted)[20:-2].mean()
    assert np.ptp(pull) > 1.0
    assert min(errors, key=lambda later: errors[later]) == 0.0
    assert sorted(errors.values())[1] > 5.0 * errors[0.0], errors
    assert told("muscle_force") == f"start of the step, {BESIDE}"
