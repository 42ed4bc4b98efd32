"""A controller in a module of one's own, with free parameters and a state of its own, in the fused step."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from importing import module_of
from muscle_arm import ABOUT_JOINT, MASS, REACH, arm
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.model.unused_parameters import unused_parameters
from warpmuscle.scene import Actuation, Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout

NAME = "their_controllers"
MODULE = '''
import warp as wp
from warpmuscle.kernels.control.control import CustomController
from warpmuscle.kernels.structs import ModelRef, StateRef, ScratchRef

ANGLE = wp.constant(7)  # behind the place of the fixed root


@wp.struct
class Gains:
    target: float  # rad
    kp: float  # N m/rad
    kd: float  # N m s/rad
    ki: float  # N m/(rad s)


@wp.func
def integrate(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, gains: Gains, memory: wp.array[float]):
    """Integral of the error."""
    memory[0] = memory[0] + model.time_step * (gains.target - state.coordinates[instance, ANGLE])


@wp.func
def effort(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, gains: Gains, memory: wp.array[float]
) -> wp.vec3:
    error = gains.target - state.coordinates[instance, ANGLE]
    return wp.vec3(gains.kp * error - gains.kd * state.speeds[instance, 0] + gains.ki * memory[0], 0.0, 0.0)


pid = CustomController(effort=effort, update=integrate, parameters=Gains, state=1)


@wp.struct
class Rhythm:
    frequency: float  # Hz


@wp.func
def tick(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, rhythm: Rhythm, memory: wp.array[float]):
    """Phase of an oscillator, and its greatest felt force."""
    memory[0] = memory[0] + model.time_step * rhythm.frequency
    memory[1] = wp.max(memory[1], state.muscles.sensed[instance, 0][2])


@wp.func
def beat(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float]
) -> float:
    if muscle == 1:
        return -1.0
    return 0.5 + 0.5 * wp.sin(2.0 * wp.PI * memory[0])


oscillator = CustomController(excitation=beat, update=tick, parameters=Rhythm, state=2)
nothing = CustomController(parameters=Rhythm)
greedy = CustomController(excitation=beat, parameters=Rhythm, state=-1)
packed = CustomController(effort=effort, parameters=wp.vec3)
swapped = CustomController(update=effort, parameters=Gains, state=1)


def plain(instance: int) -> float:
    return 0.0


undecorated = CustomController(effort=plain)
'''
STEPS, STEP, GRAVITY = 1000, 0.0005, 9.8
GAINS = {"target": 0.5, "kp": 60.0, "kd": 5.0, "ki": 200.0}
module = module_of(NAME, MODULE)


def with_pid(**gains: object) -> Scene:
    """An arm that hangs on a motor."""
    return arm(
        actuation={"elbow": Actuation("torque")}, custom_controller=f"{NAME}:pid",
        custom_controller_parameters=GAINS | gains, duration=STEPS * STEP,
    )  # fmt: skip


def simulated(kp: float = GAINS["kp"], ki: float = GAINS["ki"]) -> tuple[np.ndarray, float]:
    """Angle after every step, and the integral of the error, by leapfrog in double precision."""
    q = middle = speed = integral = 0.0
    angles = np.empty(STEPS)
    for step in range(STEPS):
        error = GAINS["target"] - q
        integral += STEP * error
        torque = kp * error - GAINS["kd"] * speed + ki * integral
        a = (torque - MASS * GRAVITY * REACH * np.sin(q)) / ABOUT_JOINT
        middle += (STEP if step else 0.5 * STEP) * a
        q, speed = q + STEP * middle, middle + 0.5 * STEP * a
        angles[step] = q
    return angles, integral


def run(scene: Scene, instances: int = 1, values: object = None, **how: object) -> Rollout:
    rollout = Rollout(scene, instances, "cpu", trust=True, **how)
    if values is not None:
        rollout.set_parameters(values)
    rollout.run()
    return rollout


def test_a_controller_with_state_and_parameters_moves_a_joint_as_in_double_precision():
    rollout = Rollout(with_pid(), 1, "cpu", record=[0], record_rate=1.0 / STEP, trust=True)
    rollout.run()
    angles, integral = simulated()
    np.testing.assert_allclose(rollout.recorded("coordinates")[0, 1:, 7], angles[:-1], atol=2e-5)
    assert rollout.controller_state[0, 0] == pytest.approx(integral, rel=1e-4)


def test_its_free_parameters_differ_between_instances_and_each_is_the_same_to_the_bit_alone_or_in_a_batch():
    scene = with_pid(kp=Free(60.0, 20.0, 100.0), ki=Free(200.0, 0.0, 300.0))
    assert [p.name for p in Rollout(scene, 1, "cpu", trust=True).parameters] == [
        "custom_controller_parameters.kp", "custom_controller_parameters.ki"
    ]  # fmt: skip
    values = [[30.0, 100.0], [60.0, 200.0], [90.0, 0.0]]
    together = run(scene, 3, values, threads=2)
    for instance, (kp, ki) in enumerate(values):
        alone = run(scene, 1, [[kp, ki]])
        for name in ("coordinates", "speeds"):
            np.testing.assert_array_equal(
                getattr(together.state, name).numpy()[instance], getattr(alone.state, name).numpy()[0]
            )
        assert together.controller_state[instance] == alone.controller_state[0]
        assert together.state.coordinates.numpy()[instance, 7] == pytest.approx(simulated(kp, ki)[0][-1], abs=5e-5)


def test_its_state_goes_on_over_launches_and_starts_anew_with_its_instance():
    whole, parts = run(with_pid(), 2), Rollout(with_pid(), 2, "cpu", trust=True)
    for count in (1, 99, 400):
        parts.step(count)
    kept = parts.snapshot()
    middle = parts.controller_state.copy()
    parts.step(500)
    np.testing.assert_array_equal(parts.controller_state, whole.controller_state)
    np.testing.assert_array_equal(parts.state.speeds.numpy(), whole.state.speeds.numpy())
    parts.restore(kept)
    np.testing.assert_array_equal(parts.controller_state, middle)
    parts.reset(np.array([True, False]))
    np.testing.assert_array_equal(parts.controller_state, [[0.0], middle[1]])
    parts.step(500)
    np.testing.assert_array_equal(parts.controller_state, [middle[0], whole.controller_state[1]])
    parts.reset()
    np.testing.assert_array_equal(parts.controller_state, np.zeros((2, 1)))


def test_it_excites_muscles_that_it_wants_and_feels_them():
    scene = arm(duration=0.3, custom_controller=f"{NAME}:oscillator", custom_controller_parameters={"frequency": 5.0})
    rollout = run(scene, record=[0], record_rate=1.0 / STEP)
    excitation = rollout.recording().muscle_excitation
    phase = 5.0 * STEP * np.arange(1, len(excitation) + 1)
    np.testing.assert_allclose(excitation[:, 0], 0.5 + 0.5 * np.sin(2.0 * np.pi * phase), atol=2e-4)
    np.testing.assert_array_equal(excitation[:, 1], 0.0)  # which torques ask nothing of
    felt = rollout.recording().muscle_force[:-1, 0].max() / 400.0
    assert rollout.controller_state[0] == pytest.approx([1.5, felt], rel=1e-3)


def test_torques_from_outside_take_the_place_of_its_own():
    own, other = (
        Rollout(with_pid(), 1, "cpu", trust=True),
        Rollout(arm(actuation={"elbow": Actuation("torque")}), 1, "cpu"),
    )
    for rollout in (own, other):
        rollout.step(200, torques=[[1.5]])
    np.testing.assert_array_equal(own.state.speeds.numpy(), other.state.speeds.numpy())


def test_its_parameters_count_as_used():
    assert unused_parameters(with_pid(ki=Free(200.0, 0.0, 300.0))) == []


def test_a_scene_with_it_is_written_and_read_again(tmp_path: Path):
    scene = with_pid(ki=Free(200.0, 0.0, 300.0))
    toml.write(scene, tmp_path / "own.toml")
    assert msgspec.to_builtins(toml.read(tmp_path / "own.toml")) == msgspec.to_builtins(scene)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"custom_controller_parameters": GAINS | {"targt": 1.0}},
            "parameters.targt: no parameter is called 'targt'; did you",
        ),
        ({"custom_controller_parameters": {"kp": 1.0}}, "there is no value of 'target', 'kd', 'ki'"),
        (
            {"custom_controller": ""},
            "custom_controller_parameters: there is no custom_controller to take these parameters",
        ),
        ({"custom_controller": f"{NAME}:nothing"}, "has no function: give it one of effort, excitation, update"),
        ({"custom_controller": f"{NAME}:greedy"}, "is not a number of floats, but -1"),
        ({"custom_controller": f"{NAME}:packed"}, "are not a @wp.struct of floats"),
        (
            {"custom_controller": f"{NAME}:swapped"},
            r"takes \(int, Model, State, Scratch \[, Gains\] \[, wp.array\[float\]\]\)",
        ),
        ({"custom_controller": f"{NAME}:undecorated"}, "plain' is not a Warp function: put @wp.func before it"),
    ],
    ids=str,
)
def test_what_cannot_be_used_is_said_in_one_line(changes: dict, message: str):
    scene = with_pid()
    for field, value in changes.items():
        setattr(scene, field, value)
    with pytest.raises(SceneError, match=message) as caught:
        Rollout(scene, 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)
