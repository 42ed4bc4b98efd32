"""Muscles of one segment across one joint, for which a GPU has code of their own."""

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

import warpmuscle.simulation.stages
from muscle_arm import constant, leg
from random_states import random_states
from warpmuscle.formats import load
from warpmuscle.model.muscles import compiled_kind, driven, muscle_kind
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages


def some_reversed() -> Scene:
    """The biped with every third muscle running the other way."""
    scene = load("walk56")
    for muscle in list(scene.character.muscles.values())[::3]:
        muscle.path = muscle.path[::-1]
    return scene


def excited() -> Scene:
    """The biped with a muscle that has an excitation of its own."""
    scene = load("walk56")
    next(iter(scene.character.muscles.values())).excitation = constant(0.3)
    return scene


def wrapped() -> Scene:
    """The biped with a muscle that has a point more, on a body of its own."""
    scene = load("walk56")
    muscle = next(iter(scene.character.muscles.values()))
    muscle.path = [*muscle.path, msgspec.structs.replace(muscle.path[-1], position=(0.0, -0.1, 0.0))]
    return scene


def over_two_joints() -> Scene:
    """The biped with a muscle whose path goes on to a body farther away."""
    scene = load("walk56")
    names = topology(scene.character)
    muscle = next(iter(scene.character.muscles.values()))
    near, far = muscle.path[0].body, muscle.path[-1].body
    others = [b for b in names.bodies if b not in (near, far, names.bodies[names.parents[names.bodies.index(near)]])]
    muscle.path = [muscle.path[0], msgspec.structs.replace(muscle.path[-1], body=others[-1])]
    return scene


@pytest.mark.parametrize(
    ("make", "straight", "timed"),
    [
        (lambda: load("walk56"), True, False),
        (some_reversed, True, False),
        (excited, True, True),
        (wrapped, True, False),
        (over_two_joints, False, False),
        (leg, False, False),
        (lambda: load("wang2012"), False, False),
    ],
    ids=["walk56", "reversed", "excited", "wrapped", "two joints", "leg", "wang2012"],
)
def test_what_all_muscles_have_in_common_is_found_where_lean_code_is_wanted(
    make: Callable[[], Scene], straight: bool, timed: bool
):
    scene = make()
    names = topology(scene.character)
    lean = compiled_kind(scene, names, driven(scene, names), 15, lean=True)
    general = compiled_kind(scene, names, driven(scene, names), 15)
    assert lean is not None
    assert general is not None
    assert (lean.straight, lean.timed) == (straight, timed)
    assert (general.straight, general.timed) == (False, True)


def test_lean_code_lets_muscles_do_the_same(monkeypatch: pytest.MonkeyPatch):
    scene, n = some_reversed(), 50

    def answers(lean: bool) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        stages, states = Stages(scene, n, "cpu"), random_states(scene.character, n, seed=2)
        stages.set_state(*(getattr(states, name) for name in type(states).__dataclass_fields__))
        stages.state.muscles.activation.fill_(0.4)
        kind = muscle_kind(scene.muscle_model, [])._replace(conditions=False)
        if lean:
            kind = kind._replace(straight=True, timed=False, pulls_in_scratch=True, mixed=False)
        monkeypatch.setattr(warpmuscle.simulation.stages, "muscle_kind", lambda *_: kind)
        return stages.muscle_torques(np.random.default_rng(3).normal(0.0, 80.0, (n, len(stages.names.joints), 3)))

    (torque, quantities), (lean_torque, lean_quantities) = answers(False), answers(True)
    assert np.ptp(torque) > 100.0
    assert np.ptp(quantities["muscle_desired_force"]) > 100.0
    np.testing.assert_allclose(lean_torque, torque, rtol=1e-4, atol=2e-3)
    for name, values in quantities.items():
        np.testing.assert_allclose(lean_quantities[name], values, rtol=2e-4, atol=1e-5 * np.ptp(values), err_msg=name)
