"""When muscles are excited, against windows of people."""

import numpy as np
import pytest

from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.muscle_timing import beyond_chance, side_and_muscle
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
