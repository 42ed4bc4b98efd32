"""Which muscles are simulated, their delays in steps, and the power of what they do."""

import msgspec
import numpy as np
import pytest

from muscle_arm import arm, leg
from random_states import random_states
from warpmuscle.formats import load
from warpmuscle.model.muscles import delay_steps, driven
from warpmuscle.scene import Actuation, MuscleModel, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages


def acting(scene: Scene) -> tuple[str, ...]:
    return driven(scene, topology(scene.character)).muscles


@pytest.mark.parametrize(
    ("name", "count"), [("walk56", 56), ("walk50_but_back", 50), ("walk44_but_hips", 44), ("legs28", 28), ("fwalk", 0)]
)
def test_muscles_that_act_on_no_joint_that_they_drive_are_left_out(name: str, count: int):
    scene = load(name)
    muscles = acting(scene)
    assert len(muscles) == count
    assert Stages(scene, 1, "cpu").state.muscles.force.shape == (1, max(count, 1))
    assert list(muscles) == [muscle for muscle in scene.character.muscles if muscle in muscles]


@pytest.mark.parametrize(
    ("hip", "knee", "muscles"),
    [
        ("muscle", "muscle", ("both", "hip", "knee")),
        ("torque", "muscle", ("both", "knee")),
        ("muscle", "none", ("both", "hip")),
        (["torque", "assisted", "none"], "passive", ("both", "hip")),
        ("torque", "passive", ()),
    ],
)
def test_muscle_over_two_joints_is_kept_if_it_drives_one_of_them(hip, knee, muscles: tuple[str, ...]):
    assert acting(leg(actuation={"hip": Actuation(hip), "knee": Actuation(knee)})) == muscles


def test_joint_that_is_not_named_is_driven_by_its_muscles_or_else_by_torque():
    scene = leg()
    del scene.character.muscles["hip"], scene.character.muscles["both"]
    found = driven(scene, topology(scene.character))
    assert found.drives == {"hip": ["torque"] * 3, "knee": ["muscle"]}
    assert found.torques_help
    assert not driven(leg(), topology(leg().character)).torques_help


@pytest.mark.parametrize(
    ("delay", "legacy", "time_step", "steps"),
    [
        (0.001, True, 0.0005, 1),
        (0.005, True, 0.0005, 9),
        (0.02, True, 0.0005, 39),
        (0.0, True, 0.0005, 0),
        (0.0004, True, 0.0005, 0),
        (0.005, True, 0.001, 4),  # the nearest to 4.5 ms
        (0.0, False, 0.0005, 0),
        (0.005, False, 0.0005, 10),
        (0.02, False, 0.002, 10),
    ],
)
def test_delay_in_steps(delay: float, legacy: bool, time_step: float, steps: int):
    """The original program hears the oldest of N values, N - 1 of its steps late."""
    scene = arm(flexor={"delay": delay}, muscle_model=MuscleModel(legacy=legacy), time_step=time_step)
    assert delay_steps(scene, ("flexor", "extensor")).tolist() == [[steps, 0]]


@pytest.mark.parametrize("given", ["walk56", "arm"])
def test_muscles_put_as_much_power_into_the_joints_as_their_shortening_takes(given: str):
    """sum(torque . relative angular velocity) = -sum(force * lengthening speed); ball, universal and hinge joints."""
    scene, n = load("walk56") if given == "walk56" else arm("universal"), 200
    scene = msgspec.structs.replace(scene, muscle_model=MuscleModel())
    stages, states = Stages(scene, n, "cpu"), random_states(scene.character, n, seed=4)
    stages.set_state(*(getattr(states, name) for name in type(states).__dataclass_fields__))
    stages.state.muscles.activation.fill_(0.8)
    wanted = np.random.default_rng(5).normal(0.0, 50.0, (n, len(stages.names.joints), 3))
    paths = stages.muscle_paths()
    torque, quantities = stages.muscle_torques(wanted)
    angular = stages.forward_kinematics()["angular_velocity"].astype(float)
    relative = angular[:, list(stages.names.parents[1:])] - angular[:, 1:]
    parts = torque * relative
    taken = quantities["muscle_force"].astype(float) * paths.speed
    gross = np.abs(parts).sum(axis=(1, 2)) + np.abs(taken).sum(axis=1)
    assert gross.min() > 1.0
    assert np.max(np.abs(parts.sum(axis=(1, 2)) + taken.sum(axis=1)) / gross) < 1e-4
    np.testing.assert_array_equal(quantities["muscle_path_length"], paths.length)
