"""What impaired muscles do in a simulation: against closed forms, and against muscles whose numbers are typed."""

import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.scene import Actuation, Excitation, Impairment, InitialState, MuscleModel, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

STEP, DURATION, DELAY = 0.001, 0.2, 0.02
FLEXOR = {
    "f_max": 400.0,
    "l_opt": 0.15,
    "l_slack": 0.1,
    "delay": DELAY,
    "excitation": Excitation([0.01, 0.011], [0.0, 1.0]),
}


def held_arm(impairment: Impairment | None, **flexor: float) -> Scene:
    """An arm whose joint does not move."""
    scene = arm(
        flexor=FLEXOR | flexor, duration=DURATION, time_step=STEP,
        initial_state=InitialState((0.0, 1.0, 0.0)), muscle_model=MuscleModel(tendon="compliant", damping=0.1),
    )  # fmt: skip
    scene.actuation = {"elbow": Actuation("muscle", stiffness=4000.0, damping=20.0)}
    scene.impairments = {} if impairment is None else {"one": impairment}
    check_scene(scene)
    return scene


def recorded(scene: Scene, values: list[list[float]], quantity: str) -> np.ndarray:
    rollout = Rollout(scene, len(values), "cpu", record=range(len(values)), record_rate=1.0 / STEP)
    if values[0]:
        rollout.set_parameters(np.array(values))
    rollout.run()
    return rollout.recorded(quantity)[:, :, 0].astype(float)


def test_a_muscle_of_half_the_strength_gives_the_same_forces_as_one_of_half_f_max():
    factors = recorded(held_arm(Impairment(["flexor"], f_max=Free(1.0, 0.1, 1.0))), [[1.0], [0.5]], "muscle_force")
    typed = recorded(held_arm(None, f_max=Free(400.0, 40.0, 400.0)), [[400.0], [200.0]], "muscle_force")
    assert np.array_equal(factors, typed)
    assert factors[1, -1] == pytest.approx(0.5 * factors[0, -1], rel=0.02)  # nearly isometric, so proportional to f_max
    assert factors[0, -1] > 100.0


def test_slower_nerves_delay_the_first_activation_by_the_factor():
    scene = held_arm(Impairment(["flexor"], delay=Free(1.0, 1.0, 3.0)))
    activation = recorded(scene, [[1.0], [2.0], [3.0]], "muscle_activation")
    begins = [int(np.argmax(one > 0.5)) for one in activation]
    assert np.diff(begins) == pytest.approx([DELAY / STEP] * 2, abs=1)
