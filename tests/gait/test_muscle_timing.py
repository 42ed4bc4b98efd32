"""When muscles are excited, against windows of people."""

import numpy as np
import pytest

from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.muscle_timing import NINE, _within, active_windows, beyond_chance, joined_windows, side_and_muscle
from warpmuscle.scene.people.emg import WINDOWS


def inside(muscle: str) -> np.ndarray:
    return np.any([(begin <= PERCENT) & (end > PERCENT) for begin, end in WINDOWS[muscle]], axis=0).astype(float)


@pytest.mark.parametrize("muscle", WINDOWS)
def test_all_within_the_windows_is_100_and_an_even_part_is_chance(muscle: str):
    within = inside(muscle)
    chance = within[:-1].mean()
    assert 0.05 < chance < 0.95
    assert beyond_chance(muscle, 0.2 + 0.3 * within) == pytest.approx(100.0)
    assert beyond_chance(muscle, 0.2 + 0.3 * (1.0 - within)) == pytest.approx(-100.0 * chance / (1.0 - chance))
    even = 0.5 + np.where(np.arange(101) % 100 == np.flatnonzero(within == 0.0)[0], -0.4, 0.0)
    assert abs(beyond_chance(muscle, even)) < 3.0
    half = within + 0.5 * (1.0 - within)
    half[np.flatnonzero(within == 0.0)[0]] = 0.0
    share = within[:-1].sum() / half[:-1].sum()
    assert beyond_chance(muscle, half) == pytest.approx(100.0 * (share - chance) / (1.0 - chance))


def test_a_muscle_that_does_nothing_is_neither_with_people_nor_against_them():
    muscle = next(iter(WINDOWS))
    assert beyond_chance(muscle, 0.3 + 0.009 * inside(muscle)) == 0.0
    assert beyond_chance(muscle, 0.3 + 0.011 * inside(muscle)) == pytest.approx(100.0)


def test_names_of_muscles_tell_their_side():
    assert side_and_muscle("lSOL") == side_and_muscle("soleus_l")
    assert side_and_muscle("rSOL") == side_and_muscle("soleus_r")
    assert side_and_muscle("lSOL")[0] == "left"
    assert side_and_muscle("rSOL")[0] == "right"
    assert side_and_muscle("lSOL")[1] == side_and_muscle("rSOL")[1] != ""
    assert side_and_muscle("nothing") == side_and_muscle("xSOL") == ("", "")


@pytest.mark.parametrize("muscle", WINDOWS)
def test_windows_that_the_contact_cuts_are_one(muscle: str):
    inside_of_whole = np.zeros(100, bool)
    for begin, end in joined_windows(muscle):
        inside_of_whole |= _within(begin, end)
    np.testing.assert_array_equal(inside_of_whole, inside(muscle)[:-1] > 0.0)


def test_windows_of_the_nine_muscles_are_ten_and_only_two_of_them_are_of_one_muscle():
    first = [names[0] for names in NINE]
    assert [len(joined_windows(muscle)) for muscle in first] == [1, 1, 1, 1, 2, 1, 1, 1, 1]
    assert joined_windows("gluteus maximus") == [(96.0, 14.0)]
    assert joined_windows("rectus femoris") == [(48.0, 70.0), (93.0, 12.0)]


class Beating:
    """Two muscles of each side whose activation follows their own cycle, 1 s long, the right one half a second late."""

    muscle_names = ("soleus_l", "rect_fem_l", "soleus_r", "rect_fem_r", "nothing")

    def __init__(self, *curves) -> None:
        self.time = np.linspace(0.0, 4.0, 401)
        phase = [(self.time - late) % 1.0 for late in (0.0, 0.0, 0.5, 0.5, 0.0)]
        self.muscle_activation = np.stack(
            [curve(100.0 * one) for curve, one in zip((*curves, *curves, np.sin), phase, strict=True)], axis=1
        )


CYCLES = {"left": [(1.0, 2.0), (2.0, 3.0)], "right": [(1.5, 2.5)]}


def test_a_window_is_met_where_the_muscle_is_more_active_than_in_the_mean_of_the_cycle():
    step = Beating(lambda percent: 0.1 + 0.6 * ((percent > 7) & (percent < 51)), lambda percent: 0.3 * (percent > 80))
    found = {(one.muscle, one.begin): one for one in active_windows(step, CYCLES)}
    assert list(found) == [("rectus femoris", 48.0), ("rectus femoris", 93.0), ("soleus", 7.0)]
    assert [one.is_met for one in found.values()] == [False, True, True]
    assert found["soleus", 7.0].mean == pytest.approx(0.1 + 0.6 * 0.43, abs=0.01)
    assert found["soleus", 7.0].inside == pytest.approx(0.7, abs=0.02)
    assert found["rectus femoris", 93.0].inside == pytest.approx(0.3 * 7.0 / 19.0, abs=0.02)


def test_a_muscle_that_is_always_as_active_meets_no_window():
    even = Beating(lambda percent: 0.2 + 0.009 * ((percent > 7) & (percent < 51)), lambda percent: 0.0 * percent)
    assert not any(one.is_met for one in active_windows(even, CYCLES))
