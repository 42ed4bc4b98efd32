"""The gait cycle that a step follows is the one that the same forces have in a recording."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled

from warpmuscle.gait.foot_contact import HELD, LIFTED, LOADED, contacts
from warpmuscle.kernels.contact.gait_cycle import cycle_after, part_of_cycle, part_of_step, step_part
from warpmuscle.kernels.structs import FootCycle, SimbiconState, State

STEP = 0.0005  # s
WEIGHT = 700.0  # N


@wp.kernel
def follow(loads: wp.array[int], cycles: wp.array[FootCycle], parts: wp.array[float], lengths: wp.array[float]):
    """One foot, step by step."""
    for k in range(loads.shape[0]):
        cycle = cycle_after(cycles[0], loads[k] == 1, k == 0, wp.static(STEP), wp.static(HELD), wp.static(LIFTED))
        cycles[0] = cycle
        parts[k] = part_of_cycle(cycle, -1.0)
        lengths[k] = cycle.length


def followed(loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of the cycle, 0 before the first is whole, and lengths of the last one, after each step."""
    parts, lengths = (wp.zeros(len(loads), dtype=float, device="cpu") for _ in range(2))
    cycles = wp.zeros(1, dtype=FootCycle, device="cpu")
    wp.launch(follow, 1, [wp.array(loads, dtype=int, device="cpu"), cycles, parts, lengths], device="cpu")
    return parts.numpy(), lengths.numpy()


def random_loads(seed: int) -> np.ndarray:
    """Twelve cycles of uneven length, with scuffs in the swing and bounces in the stance."""
    rng = np.random.default_rng(seed)
    loads: list[int] = [rng.integers(2)] * 300
    for _ in range(12):
        stance, swing = rng.integers(800, 1600), rng.integers(600, 900)
        on, off = np.ones(stance, dtype=int), np.zeros(swing, dtype=int)
        bounce, scuff = rng.integers(50, 500), rng.integers(250, 500)
        on[bounce : bounce + rng.integers(1, 150)] = 0
        off[scuff : scuff + rng.integers(1, 30)] = 1
        loads += [*off, *on]
    return np.array(loads, dtype=np.int32)


@pytest.mark.parametrize("seed", range(8))
def test_touch_downs_and_parts_of_the_cycle_are_those_of_the_recorded_forces(seed: int):
    loads = random_loads(seed)
    parts, lengths = followed(loads)
    ends = STEP * (1 + np.arange(len(loads)))  # s, at which the forces of the steps are recorded
    found = contacts(ends, 500.0 * loads, WEIGHT)
    downs = [one.touch_down for one in found if one.touch_down is not None]
    assert len(downs) == 12
    grounded = np.zeros(len(ends), dtype=bool)
    for one in found:
        grounded |= (ends >= (one.touch_down or 0.0)) & (ends <= (one.lift_off or np.inf))
    np.testing.assert_allclose(np.unique(lengths[lengths > 0.0]), np.unique(np.float32(np.diff(downs))), atol=2e-4)
    for before, last, end in zip(downs[:-1], downs[1:], [*downs[2:], np.inf], strict=True):
        here = (ends > last + HELD + STEP) & (ends < end)
        expected = np.minimum((ends[here] - last) / (last - before), 1.0)
        steady = grounded[here]  # in the air a scuff might have been a landing
        np.testing.assert_allclose(parts[here][steady], expected[steady], atol=2e-3)


def test_a_foot_that_is_just_loaded_counts_as_landing_at_once():
    loads = np.repeat([1, 0, 1, 0, 1, 0, 1], [400, 800, 1200, 800, 1200, 800, 20]).astype(np.int32)
    parts, _ = followed(loads)
    assert parts[-21] == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(parts[-20:], np.arange(1, 21) * STEP / 1.0, atol=1e-3)


def test_before_its_second_landing_a_foot_follows_the_phase_and_late_it_waits_at_the_end():
    loads = np.repeat([1, 0, 1, 0], [400, 800, 1200, 800]).astype(np.int32)
    parts, lengths = followed(loads)
    assert lengths.max() == 0.0
    assert parts.max() == 0.0  # what stands in for the part, -1, within its bounds
    parts, _ = followed(np.repeat([0, 1, 0, 1, 0], [400, 1200, 800, 1200, 3000]).astype(np.int32))
    assert parts[-1] == 1.0


@wp.kernel(enable_backward=False)
def parts_before_a_cycle(given: wp.array[float], part: wp.array[float]):
    part[wp.tid()] = part_of_cycle(FootCycle(), given[wp.tid()])


def test_without_a_whole_cycle_the_part_is_the_given_one_within_0_and_1():
    given, part = (
        wp.array([-0.5, 0.0, 0.3, 0.9, 1.4], dtype=float, device="cpu"),
        wp.zeros(5, dtype=float, device="cpu"),
    )
    wp.launch(parts_before_a_cycle, 5, [given], [part], device="cpu")
    np.testing.assert_allclose(part.numpy(), [0.0, 0.0, 0.3, 0.9, 1.0], rtol=1e-6)


def test_a_stance_leg_is_in_the_first_half_of_its_cycle_and_a_swing_leg_in_the_second():
    found = evaluate(part_of_step, [0.0, 0.5, 1.0, 1.3, 0.0, 0.5], [0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(found, [0.0, 0.25, 0.5, 0.5, 0.5, 0.75])


def test_the_rule_is_what_the_documentation_says():
    assert (LOADED, HELD, LIFTED) == (0.03, 0.02, 0.2)


@wp.kernel(enable_backward=False)
def parts_of_steps(state: State, part: wp.array2d[float]):
    i, side = wp.tid()
    part[i, side] = step_part(i, side, state)


def test_a_part_of_a_step_is_that_of_the_phase_and_of_its_start_where_no_controller_has_one():
    phase, stance = np.array([0.4, 1.3], np.float32), np.array([0, 1], np.int32)
    walking = filled(State, simbicon=filled(SimbiconState, phase=phase, stance=stance))
    for state, expected in ((walking, [[0.2, 0.7], [1.0, 0.5]]), (State(), [[0.0, 0.5]] * 2)):
        part = wp.zeros((2, 2), dtype=float, device="cpu")
        wp.launch(parts_of_steps, part.shape, [state, part], device="cpu")
        np.testing.assert_allclose(part.numpy(), expected, atol=1e-6)
