"""Room for the state: an array for everything that changes, and delay lines as long as the longest delay."""

import pytest

from muscle_arm import leg
from warpmuscle.formats import load
from warpmuscle.kernels import structs
from warpmuscle.model.state import state_struct
from warpmuscle.model.structure import structure_of
from warpmuscle.scene.number import Free

N = 5


@pytest.mark.parametrize(
    ("delay", "capacity"), [(0.0, 2), (0.0005, 4), (0.001, 4), (0.0015, 8), (0.01, 32), (Free(0.001, 0.0, 0.01), 32)]
)
def test_delay_lines_are_a_power_of_two_beyond_the_longest_delay(delay: float, capacity: int):
    scene = leg(time_step=0.0005)
    scene.character.muscles["hip"].delay = delay
    structure = structure_of(scene)
    assert state_struct(scene, structure, N, "cpu").muscles.excitation_ring.shape == (N, capacity, 3)


def test_every_instance_has_room_for_coordinates_speeds_and_sums():
    scene = leg()
    scene.objective.torque = 1.0
    state = state_struct(scene, structure_of(scene), N, "cpu")
    for name in ("step", "status", "start_height", "start_heading", "push"):
        assert getattr(state, name).shape == (N,), name
    assert (state.coordinates.shape, state.speeds.shape) == ((N, 7 + 4 + 1), (N, 3 + 1))
    assert (state.accelerations.shape, state.torque_integral.shape) == ((N, 4), (N, 3))
    assert (state.foot_force.shape, state.push_steps.shape) == ((N, 2), (N, 2))
    assert state.foot_cycle.shape == (0, 2)
    assert [getattr(state.simbicon, name) for name in structs.SimbiconState.vars] == [None] * 5
    assert (state.muscles.activation.shape, state.muscles.sensed.shape) == ((N, 3), (0, 3))


def test_cycles_of_feet_and_held_targets_have_room_where_they_are_needed():
    scene = load("fwalk")
    scene.objective.norms, scene.control_rate = 1.0, 500.0
    state = state_struct(scene, structure_of(scene), N, "cpu")
    bodies = len(scene.character.bodies)
    assert (state.foot_cycle.shape, state.simbicon.target.shape) == ((N, 2), (N, bodies))
    assert (state.simbicon.target_plan.shape, state.body_terms.shape[0]) == ((N, bodies), N)
    assert [getattr(state.simbicon, name).shape for name in ("phase", "stance", "machine_state")] == [(N,)] * 3
