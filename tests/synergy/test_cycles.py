"""Cycles of a recording on a common scale."""

import numpy as np
import pytest

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.cycles import Cycles, by_cycles, read_cycles
from warpmuscle.synergy.signals import Signals

RAMP = Signals(("a",), 100.0, np.arange(1001)[:, None] / 100.0, "walk.csv")  # its values are its times


def write(path, text):
    path.write_text(text)
    return path


def test_phases_get_the_same_number_of_points_whatever_they_last(tmp_path):
    cycles = read_cycles(write(tmp_path / "c.csv", "touchdown,liftoff\n1,1.6\n2,2.8\n3,3.5\n"))
    found = by_cycles(RAMP, cycles, 4)
    assert (found.rate, len(found.values)) == (4.0, 8)
    np.testing.assert_allclose(found.values[:, 0], [1.0, 1.3, 1.6, 1.8, 2.0, 2.4, 2.8, 2.9])
    np.testing.assert_allclose(found.time, np.arange(8) / 4.0)


def test_one_column_gives_cycles_of_one_phase(tmp_path):
    cycles = read_cycles(write(tmp_path / "c.csv", "start\n1\n2\n4\n"))
    np.testing.assert_allclose(by_cycles(RAMP, cycles, 2).values[:, 0], [1.0, 1.5, 2.0, 3.0])
    np.testing.assert_allclose(by_cycles(RAMP, cycles.chosen(2, 2), 2).values[:, 0], [2.0, 3.0])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a,b,c\n1,2,3\n4,5,6\n", "has 3 columns; cycles have one or two"),
        ("start\n1\n", "holds 1 start of cycles; two are the least"),
        ("start\n1\n3\n2\n", "c.csv:4: channel 'start': times must increase, but 2 s follows 3 s"),
        ("on,off\n1,1.5\n2,1.9\n3,3.5\n", "c.csv:3: channel 'off': times must increase, but 1.9 s follows 2 s"),
        ("start\n1\nnan\n2\n", "c.csv:3: channel 'start': times must increase, but nan s follows 1 s"),
        ("", "c.csv: is empty"),
    ],
)
def test_bad_file_of_cycles_is_said(tmp_path, text, says):
    with pytest.raises(SignalError) as caught:
        read_cycles(write(tmp_path / "c.csv", text))
    assert says in str(caught.value)


def test_cycles_beyond_the_recording_or_their_number_are_said():
    cycles = Cycles(np.array([[9.0, 9.5], [9.5, 10.5]]), "c.csv")
    with pytest.raises(SignalError, match=r"c.csv: cycles from 9 s to 10.5 s are not within walk.csv, 0 s to 10 s"):
        by_cycles(RAMP, cycles, 10)
    with pytest.raises(SignalError, match="holds 2 whole cycles, so that 2 to 3 cannot be chosen"):
        cycles.chosen(2, 3)


def test_points_that_phases_cannot_share_are_said():
    with pytest.raises(SignalError, match="of a cycle of 2 phases must be a multiple of 2, from 4 to 10000, not 5"):
        by_cycles(RAMP, Cycles(np.array([[1.0, 1.5, 2.0]])), 5)
