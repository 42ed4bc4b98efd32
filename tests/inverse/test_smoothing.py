"""Filters and splines over recordings: laws that they keep, and OpenSim's own."""

import numpy as np
import pytest

from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.smoothing import _filter_state, low_pass, spline


def inside(times, values, cutoff):
    """The filtered values at the given times alone."""
    at, found = low_pass(times, values, cutoff)
    first = int(np.argmin(np.abs(at - times[0])))
    return found[first : first + len(times)]


@pytest.mark.parametrize("frequency", [2.0, 6.0, 15.0])
def test_a_sine_comes_through_as_butterworth_says_of_both_ways(frequency):
    times = np.arange(2000) / 200.0
    found = inside(times, np.sin(2.0 * np.pi * frequency * times)[:, None], 6.0)[500:1500, 0]
    warped = np.tan(np.pi * frequency / 200.0) / np.tan(np.pi * 6.0 / 200.0)
    assert np.abs(found).max() == pytest.approx(1.0 / (1.0 + warped**6), rel=0.02)


def test_a_line_stays_a_line_up_to_both_ends():
    times = np.arange(100) / 100.0
    assert inside(times, 3.0 - 2.0 * times[:, None], 6.0)[:, 0] == pytest.approx(3.0 - 2.0 * times, abs=1e-5)


def test_uneven_times_are_filtered_as_even_ones_are():
    even = np.arange(400) / 100.0
    uneven = even + 0.002 * np.sin(9.0 * even)
    signals = [np.sin(5.0 * times)[:, None] for times in (even, uneven)]
    at, found = low_pass(uneven, signals[1], 6.0)
    there = spline(at, found, even[50:350])[0]
    assert there == pytest.approx(inside(even, signals[0], 6.0)[50:350], abs=2e-3)


def test_rates_of_a_spline_are_those_of_what_it_goes_through():
    times = np.linspace(0.0, 3.0, 301)
    value, rate, bend = spline(times, np.sin(4.0 * times)[:, None], times, orders=3)
    middle = slice(30, -30)
    assert value[:, 0] == pytest.approx(np.sin(4.0 * times), abs=1e-12)
    assert rate[middle, 0] == pytest.approx(4.0 * np.cos(4.0 * times)[middle], abs=1e-6)
    assert bend[middle, 0] == pytest.approx(-16.0 * np.sin(4.0 * times)[middle], abs=1e-4)


def test_fewer_frames_have_splines_of_lower_degree_and_one_frame_stands_still():
    line = spline(np.array([0.0, 1.0]), np.array([[1.0], [3.0]]), np.array([0.5]), orders=2)
    assert [float(array[0, 0]) for array in line] == [2.0, 2.0]
    still = spline(np.array([0.0]), np.array([[1.0]]), np.array([0.0]), orders=3)
    assert [float(array[0, 0]) for array in still] == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 50.0, np.nan])
def test_a_cut_off_that_is_none_is_refused(cutoff):
    with pytest.raises(ArgumentError, match="cut-off"):
        low_pass(np.arange(50) / 100.0, np.zeros((50, 1)), cutoff)


def test_both_are_those_of_opensim(tmp_path):
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("error")
    times = np.arange(200) / 100.0
    values = np.sin(5.0 * times) + 0.2 * np.random.default_rng(0).normal(size=200)
    file = tmp_path / "signal.sto"
    rows = "".join(f"{t:.17g}\t{x:.17g}\n" for t, x in zip(times, values, strict=True))
    file.write_text(f"signal\nversion=1\nnRows=200\nnColumns=2\ninDegrees=no\nendheader\ntime\tx\n{rows}")
    storage = opensim.Storage(str(file))
    storage.pad(100)
    storage.lowpassIIR(6.0)
    splines = opensim.GCVSplineSet(5, storage)  # owns what it gives
    theirs = splines.get(0)
    second = (0, 0)  # not a vector of OpenSim, which is none any more where ezc3d has written a file
    at = np.linspace(0.0, 1.99, 57)
    ours = spline(*low_pass(times, values[:, None], 6.0), at, orders=3)
    assert ours[0][:, 0] == pytest.approx([theirs.calcValue(opensim.Vector(1, t)) for t in at], abs=1e-9)
    bends = [theirs.calcDerivative(second, opensim.Vector(1, t)) for t in at]
    assert ours[2][:, 0] == pytest.approx(bends, abs=1e-6 * np.abs(bends).max())


def test_a_filter_goes_on_as_scipy_has_it_bit_for_bit():
    from scipy.signal import butter, lfiltic

    before = np.random.default_rng(4).normal(size=(3, 5))
    b, a = butter(3, 0.12)
    expected = np.array([lfiltic(b, a, column, column) for column in before.T]).T
    assert _filter_state(b, a, before).tobytes() == np.ascontiguousarray(expected).tobytes()
