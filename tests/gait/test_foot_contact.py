"""Feet touch down and lift off where the force on them says so: not for a scuff, not again for a bounce."""

import numpy as np
import pytest

from small_result import STRIDE, walk_result, with_arrays
from warpmuscle.core.errors import Error
from warpmuscle.gait.foot_contact import Contact, contacts, mean_load, support, touch_downs

WEIGHT = 700.0  # N
TIME = np.arange(4000) / 1000.0


def force(*spells: tuple[float, float], load: float = 500.0) -> np.ndarray:
    """A load (F,), N, in each of these spells, s."""
    loaded = np.zeros(len(TIME), dtype=bool)
    for begin, end in spells:
        loaded |= (begin - 5e-4 <= TIME) & (end - 5e-4 > TIME)
    return load * loaded


def found(*spells: tuple[float, float], load: float = 500.0) -> list[Contact]:
    return contacts(TIME, force(*spells, load=load), WEIGHT)


def test_a_contact_is_from_one_crossing_of_the_bound_to_the_next():
    (one,) = found((1.0, 1.6))
    assert one == pytest.approx((0.9995, 1.6), abs=1e-3)


def test_a_load_of_less_than_20_ms_or_3_percent_of_the_weight_is_no_contact():
    assert found((1.0, 1.018)) == []
    assert len(found((1.0, 1.025))) == 1
    assert found((1.0, 1.6), load=0.029 * WEIGHT) == []
    assert len(found((1.0, 1.6), load=0.031 * WEIGHT)) == 1


def test_a_bounce_of_less_than_a_fifth_of_a_second_does_not_end_a_contact():
    assert len(found((1.0, 1.1), (1.29, 1.6))) == 1
    assert len(found((1.0, 1.1), (1.31, 1.6))) == 2
    assert len(found((1.0, 1.6), (1.7, 1.77), (2.1, 2.6))) == 2  # toes that drag after the foot has lifted off


def test_what_began_before_the_recording_or_lasts_beyond_it_has_no_such_end():
    first, last = found((0.0, 0.5), (3.5, 4.0))
    assert first == Contact(None, pytest.approx(0.5, abs=1e-3))
    assert last == Contact(pytest.approx(3.5, abs=1e-3), None)
    assert contacts(TIME[:0], TIME[:0], WEIGHT) == []


def test_a_foot_that_carries_from_the_first_step_on_stood_there_before():
    motion = walk_result().replays[0]
    loads = motion.foot_force_left.copy()
    assert loads[1, 1] > 100.0
    loads[0] = 0.0  # as the simulator records it
    assert touch_downs(with_arrays(motion, foot_force_left=loads), "left")[0] == pytest.approx(0.995)


@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0, 1000.0])
def test_touch_downs_of_a_sudden_load_are_known_without_bias_at_any_rate(rate: float):
    late = []
    for start in 1.0 + np.linspace(0.0, 1.0 / rate, 40, endpoint=False):
        time = np.arange(round(3.0 * rate)) / rate
        (one,) = contacts(time, np.where((time >= start) & (time < 2.0), 500.0, 0.0), WEIGHT)
        late.append(one.touch_down - start)
    assert np.abs(late).max() <= 0.5 / rate + 1e-9
    assert np.mean(late) == pytest.approx(0.0, abs=0.03 / rate)


def test_a_lift_off_is_interpolated_where_the_force_fades():
    time = np.arange(0.0, 2.0, 0.01)
    fading = np.clip(700.0 * (1.5034 - time), 0.0, 600.0)
    (one,) = contacts(time, fading, WEIGHT)
    assert one.lift_off == pytest.approx(1.5034 - 0.03, abs=1e-6)


def test_touch_downs_need_no_stance_and_no_weight():
    motion = walk_result().replays[0]
    for weight in (None, WEIGHT):
        np.testing.assert_allclose(touch_downs(motion, "left", weight), [0.995, 1.995, 2.995, 3.995], atol=1e-9)
        np.testing.assert_allclose(touch_downs(motion, "right", weight), [0.495, 1.495, 2.495, 3.495], atol=1e-9)


def test_the_mean_load_is_that_on_both_feet_whichever_carries_more():
    motion = walk_result().replays[0]
    share = np.linspace(0.0, 1.0, len(motion.time))
    left, right = (np.outer(carried, [1.0, 400.0, 3.0]) for carried in (1.0 + share, 0.25 * share))
    loaded = with_arrays(motion, foot_force_left=left, foot_force_right=right)
    assert mean_load(loaded) == pytest.approx(400.0 * (1.5 + 0.125))


def test_what_weighs_nothing_touches_the_ground_from_three_hundredths_of_a_newton_on():
    """A weight counts as one newton at least, so that noise is no contact."""
    motion = walk_result().replays[0]
    for load, touches in ((0.031, True), (0.029, False), (0.025, False)):
        left = np.outer(load * (motion.time % 2.0 > 1.0), [0.0, 1.0, 0.0])
        assert (len(touch_downs(with_arrays(motion, foot_force_left=left), "left", 0.0)) > 0) is touches, load


@pytest.mark.parametrize(("stance", "double", "flight"), [(0.6, 20.0, 0.0), (0.75, 50.0, 0.0), (0.4, 0.0, 20.0)])
def test_stance_double_support_and_flight_follow_from_the_contacts(stance: float, double: float, flight: float):
    motion = walk_result().replays[0]
    cycle = (motion.time / STRIDE) % 1.0
    loads = {}
    for side, first in (("left", 0.0), ("right", 0.5)):
        on = (cycle - first) % 1.0 < stance - 1e-9
        loads[f"foot_force_{side}"] = np.outer(on, [0.0, WEIGHT, 0.0])
    shares = support(with_arrays(motion, **loads), 0.995, 2.995, WEIGHT)
    assert shares == pytest.approx((100.0 * stance, double, flight), abs=1.1)


def test_an_empty_time_has_no_support():
    with pytest.raises(Error, match="between 2 and 2 s: the time is empty"):
        support(walk_result().replays[0], 2.0, 2.0)
