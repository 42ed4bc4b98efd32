"""A term of a scene's own sees what torques the controller wants of joints, by the joints' names."""

import msgspec
import pytest
import warp  # noqa: F401  what is tested launches kernels

from importing import module_of
from warpmuscle import Rollout
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load

MODULE = """import warp as wp
from warpmuscle.kernels.structs import Model, Scratch, State

@wp.struct
class Desired:
    rKnee: wp.vec3
    lHip: wp.vec3

@wp.func
def hip_and_knee(instance: int, model: Model, state: State, work: Scratch, desired: Desired) -> float:
    return wp.length_sq(desired.lHip) - 3.0 * desired.rKnee[0]

@wp.struct
class Unknown:
    lHipp: wp.vec3

@wp.func
def unknown(instance: int, model: Model, state: State, work: Scratch, desired: Unknown) -> float:
    return desired.lHipp[0]

@wp.struct
class Number:
    lHip: float

@wp.func
def number(instance: int, model: Model, state: State, work: Scratch, desired: Number) -> float:
    return desired.lHip

@wp.func
def twice(instance: int, model: Model, state: State, work: Scratch, desired: Unknown, more: Unknown) -> float:
    return 0.0
"""
NAME = "terms_of_desired"
module = module_of(NAME, MODULE)


def test_a_term_sums_what_recordings_say_that_the_controller_wanted():
    scene = msgspec.structs.replace(load("walk56"), duration=0.1)
    scene.objective = msgspec.structs.replace(scene.objective, custom={f"{NAME}:hip_and_knee": 1.0})
    rollout = Rollout(scene, 2, "cpu", record=[1], record_rate=1.0 / scene.time_step, trust=True, threads=1)
    rollout.run()
    motion = rollout.recording(1)
    hip, knee = (motion.joint_names.index(name) for name in ("lHip", "rKnee"))

    def summed(torque) -> float:
        torque = torque.astype(float)
        return scene.time_step * ((torque[:, hip] ** 2).sum() - 3.0 * torque[:, knee, 0].sum())

    assert len(motion.time) == rollout.steps
    expected = summed(motion.joint_torque_desired)
    assert rollout.terms()[f"{NAME}:hip_and_knee"] == pytest.approx([expected, expected], rel=1e-5)
    assert summed(motion.joint_torque) != pytest.approx(expected, rel=0.05)  # what muscles made of it


@pytest.mark.parametrize(
    ("term", "said"),
    [
        ("unknown", r"no joint is called 'lHipp' for Unknown; did you mean 'lHip'\?"),
        ("number", r"Number\.lHip must be wp\.vec3, a torque; it is float"),
        ("twice", r"a term takes .*, but .* takes \(int, Model, State, Scratch, Unknown, Unknown\)"),
    ],
)
def test_what_is_no_joint_or_no_torque_is_said_in_one_line(term: str, said: str):
    scene = load("walk56")
    scene.objective = msgspec.structs.replace(scene.objective, custom={f"{NAME}:{term}": 1.0})
    with pytest.raises(SceneError, match=said) as caught:
        Rollout(scene, 1, "cpu", trust=True)
    assert caught.value.key == f"objective.custom.{NAME}:{term}"
