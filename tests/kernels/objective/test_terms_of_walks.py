"""Terms of the objective that value a walk, beside what its recording gives in float64."""

import msgspec
import numpy as np
import pytest
from probes import evaluate
from scipy.spatial.transform import Rotation

import kernel_tests
from short_walks import OF_TORQUES
from warpmuscle.formats import load
from warpmuscle.gait.cycles import body_weight, leg_angles
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.joint_moments import leg_moments
from warpmuscle.kernels.contact.gait_cycle import width_from_line
from warpmuscle.kernels.muscle.muscle import LARGEST_PASSIVE
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.scene import Objective
from warpmuscle.scene.norms import NORMS, PERCENT_OF_BIN, RUNNING_FORCE_BAND, running_force
from warpmuscle.scene.people.pinzone_two import SEARCHED_MOMENTS
from warpmuscle.simulation.rollout import Rollout

ONES = dict.fromkeys(TERMS, 1.0) | {"tracking": 0.0}


def walked(name: str, duration: float, weights: dict[str, float], gait: str = "") -> Rollout:
    """The start of a shipped walk, every step of it recorded."""
    scene = msgspec.structs.replace(load(name), duration=duration, objective=Objective(**weights, gait=gait))
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    return rollout


@pytest.fixture(scope="module")
def walk() -> Rollout:
    """Some steps of a walk on torques, with all terms of these."""
    with kernel_tests.optimized():
        return walked("fwalk", 3.0, OF_TORQUES)


def percent_of_cycle(recording, side: int, weight: float) -> np.ndarray:
    """Where a leg is in its gait cycle, to a hundredth of it.

    That is the time since its foot touched down over the length of the cycle that ended then; before the foot has
    landed twice, the phase of the controller.
    """
    step = 0.5 * np.minimum(recording.phase, 1.0)
    part = step + np.where(recording.stance == side, 0.0, 0.5)
    landings = touch_downs(recording, SIDES[side], weight)
    for before, last, end in zip(landings[:-1], landings[1:], [*landings[2:], np.inf], strict=True):
        here = (recording.time >= last) & (recording.time < end)
        part[here] = np.minimum((recording.time[here] - last) / (last - before), 1.0)
    return np.clip((part * 100.0).astype(int), 0, 99) + 0.5


def test_norms_are_squared_half_widths_between_legs_and_human_ones(walk: Rollout):
    recording = walk.recording()
    angles = leg_angles(recording, walk.numeric)
    total = np.zeros(len(recording.time))
    for title, sides in angles.items():
        for number, side in enumerate(SIDES):
            human = NORMS[title].mean(percent_of_cycle(recording, number, body_weight(walk.numeric)))
            total += ((sides[side] - human) / NORMS[title].half_width) ** 2
    expected = total[:-1].mean() * walk.end_time()[0]
    assert expected > 5.0
    np.testing.assert_allclose(walk.terms()["norms"], expected, rtol=0.01)


def test_norm_moments_are_squared_deviations_between_moments_of_legs_and_peoples(walk: Rollout):
    """Beside what the judge of gaits makes of the recorded torques in float64; people's are typed numbers."""
    recording = walk.recording()
    total, most = np.zeros(len(recording.time)), 0.0
    for title, sides in leg_moments(recording, walk.numeric).items():
        deviation = SEARCHED_MOMENTS[title].sd(PERCENT_OF_BIN).mean()
        for number, side in enumerate(SIDES):
            percent = percent_of_cycle(recording, number, body_weight(walk.numeric))
            away = (sides[side] - SEARCHED_MOMENTS[title].mean(percent)) / deviation
            total += np.minimum(away**2, 16.0)
            most = max(most, np.abs(away).max())
    expected = total[:-1].mean() * walk.end_time()[0]
    assert expected > 5.0
    assert most > 4.0
    np.testing.assert_allclose(walk.terms()["norm_moments"], expected, rtol=0.02)


def test_norm_force_is_the_same_of_vertical_forces_in_body_weights(walk: Rollout):
    norm = NORMS["Vertical ground force"]
    check_force(walk, norm.mean, norm.half_width)


def test_norm_force_of_a_run_is_half_a_sine_that_carries_the_body():
    assert 2.0 * running_force(np.linspace(0.0, 100.0, 100_001)).mean() == pytest.approx(1.0, abs=1e-4)
    check_force(walked("fwalk", 3.0, OF_TORQUES | {"norm_moments": 0.0}, gait="run"), running_force, RUNNING_FORCE_BAND)


def check_force(rollout, mean, half_width):
    recording = rollout.recording()
    total = np.zeros(len(recording.time))
    for number, side in enumerate(SIDES):
        force = recording[f"foot_force_{side}"][:, 1] / body_weight(rollout.numeric)
        percent = percent_of_cycle(recording, number, body_weight(rollout.numeric))
        total += ((force - mean(percent)) / half_width) ** 2
    np.testing.assert_allclose(rollout.terms()["norm_force"], total.mean() * rollout.end_time()[0], rtol=0.02)


def test_passive_force_is_that_of_fibres_stretched_beyond_their_optimum():
    rollout = walked("walk56", 1.0, ONES)
    recording, muscles = rollout.recording(), rollout.numeric.character.muscles
    total = 0.0
    for index, name in enumerate(recording.muscle_names):
        stretch = recording.muscle_fibre_length[:, index] / muscles[name].l_opt - 1.0
        passive = np.where(stretch > 0.0, np.expm1(4.0 * stretch / 0.6) / np.expm1(4.0), 0.0)  # Bergmann 2017, eq. 6
        total += muscles[name].f_max * np.minimum(passive, LARGEST_PASSIVE).mean()
    assert total > 100.0
    np.testing.assert_allclose(rollout.terms()["passive_force"], total * rollout.end_time()[0], rtol=0.01)


def test_step_width_is_how_far_the_other_foot_stands_from_the_line_of_a_foot_s_placements(walk: Rollout):
    recording = walk.recording()
    downs = sorted((time, side) for side in (0, 1) for time in touch_downs(recording, SIDES[side]))
    expected, width, last = 0.0, {}, {0: [], 1: []}
    ends = [*(time for time, _ in downs[1:]), walk.end_time()[0]]
    for (time, side), end in zip(downs, ends, strict=True):
        foot = recording.position_of("lr"[side] + "Foot")
        last[side].append(np.array([np.interp(time, recording.time, foot[:, axis]) for axis in (0, 2)]))
        if len(last[side]) > 1 and last[1 - side]:
            (x, z), (ox, oz) = last[side][-1] - last[side][-2], last[1 - side][-1] - last[side][-1]
            width[side] = (1.0 if side else -1.0) * (ox * z - oz * x) / np.hypot(x, z)  # the left of z is x
        expected += sum((one - 0.08) ** 2 for one in width.values()) * (end - time)
    assert len(width) == 2
    np.testing.assert_allclose(walk.terms()["step_width"], expected, rtol=0.1)


def test_stride_speed_is_what_a_foot_goes_from_landing_to_landing_over_the_time_between(walk: Rollout):
    recording, end = walk.recording(), float(walk.end_time()[0])
    target, expected = walk.numeric.objective.target_speed, 0.0
    for side in (0, 1):
        downs = touch_downs(recording, SIDES[side])
        foot = recording.position_of("lr"[side] + "Foot")[:, 2]
        places = np.interp(downs, recording.time, foot)
        fine = np.linspace(0.0, end, 20001)
        landed = np.searchsorted(downs, fine, side="right")
        speed = np.interp(fine, recording.time, recording.com_velocity[:, 2])
        for count in range(2, len(downs) + 1):
            now = landed == count
            length = downs[count - 1] - downs[count - 2]
            speed[now] = (places[count - 1] - places[count - 2]) / np.maximum(length, fine[now] - downs[count - 1])
        assert len(downs) > 1
        expected += np.mean((speed - target) ** 2) * end
    np.testing.assert_allclose(walk.terms()["stride_speed"], expected, rtol=0.05)


def test_rise_is_how_far_the_centre_of_mass_came_above_its_start_and_lowers_the_cost(walk: Rollout):
    height = walk.recording().com[:, 1]
    assert 0.005 < height.max() - height[0] < 0.2
    assert height[-1] < height.max()
    np.testing.assert_allclose(walk.terms()["rise"], height[0] - height.max(), atol=2e-4)


@pytest.mark.parametrize("way", [0.0, 0.7, 3.0])
@pytest.mark.parametrize("width", [0.12, -0.04])
def test_width_from_a_line_is_signed_and_does_not_depend_on_the_way_that_one_walks(way: float, width: float):
    turn = Rotation.from_euler("y", way)
    for side, outwards in ((0, 1.0), (1, -1.0)):
        before, place, other = np.array([[0, 0, 0], [0, 0, 1.2], [-outwards * width, 0, 0.6]], dtype=float)
        facing = turn.apply([np.sin(0.4), 0.0, np.cos(0.4)])
        found = evaluate(width_from_line, turn.apply(before), turn.apply(place), turn.apply(other), facing, side)
        np.testing.assert_allclose(found, width, atol=1e-6)
        backwards = evaluate(width_from_line, turn.apply(place), turn.apply(before), turn.apply(other), facing, side)
        np.testing.assert_allclose(backwards, width, atol=1e-6)
