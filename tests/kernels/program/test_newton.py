"""Steps of Newton's method for programmes with bounds, against closed forms in float64."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.program.newton import Controls, next_length, step_length
from warpmuscle.kernels.program.structs import Columns


@wp.kernel(enable_backward=False)
def lengths(
    controls: Controls, columns: Columns, reserve: wp.array[wp.float64], x: wp.array[wp.float64],
    d: wp.array[wp.float64], y: wp.array[wp.float64], dy: wp.array[wp.float64], needed: wp.array[wp.float64],
    h: wp.array[wp.float64], found: wp.array[wp.float64],
):  # fmt: skip
    found[0] = step_length(1, 1, controls, columns, reserve, x, d, y, dy, needed, h)


@pytest.mark.parametrize("size", [1.0, 1e-6])
def test_a_step_ends_where_the_balance_is_met_though_a_bound_is_on_the_way(size: float):
    """R x + B u = needed, u = min(gain B x, high): the slope at the start leads less far, whatever the size."""
    reserve, entry, gain, high, needed = 1.0, 2.0, 0.75, 0.6 * size, 4.0 * size
    met = (needed - entry * high) / reserve
    step = needed / (reserve + entry * gain * entry)
    assert gain * entry * step > high
    controls = filled(
        Controls, gain=np.float32([gain]), low=np.float32([-high]), high=np.float32([high]), entry=np.float32([entry])
    )
    columns = filled(Columns, first=np.int32([0, 1]), row=np.int32([0]))
    numbers = [reserve, 0.0, step, 0.0, 0.0, needed, -needed]
    found = wp.zeros(1, dtype=wp.float64, device="cpu")
    given = [wp.array([number], dtype=wp.float64, device="cpu") for number in numbers]
    wp.launch(lengths, 1, [controls, columns, *given], [found], device="cpu")
    assert found.numpy()[0] == pytest.approx(met / step, rel=1e-3)


@wp.kernel(enable_backward=False)
def following(
    t: wp.array[wp.float64], value: wp.array[wp.float64], bend: wp.array[wp.float64], bracket: wp.array[wp.vec2d],
    found: wp.array[wp.float64],
):  # fmt: skip
    i = wp.tid()
    found[i] = next_length(t[i], value[i], bend[i], bracket[i])


@pytest.mark.parametrize(
    ("value", "bend", "bracket", "expected"),
    [
        (-3.0, 2.0, (2.0, -1.0), 3.5),  # Newton's
        (-0.1, 2.0, (2.0, -1.0), 2.5),  # a quarter more at least, while nothing bounds it above
        (-900.0, 2.0, (2.0, -1.0), 128.0),  # 64 times as much at most
        (-3.0, 2.0, (2.0, 9.0), 3.5),
        (-30.0, 2.0, (2.0, 9.0), 5.5),  # beyond the bracket: its middle
        (3.0, 2.0, (1.0, 2.0), 1.5),
    ],
)
def test_the_next_length_is_newtons_within_bounds(value: float, bend: float, bracket: tuple, expected: float):
    given = [wp.array([number], dtype=wp.float64, device="cpu") for number in (2.0, value, bend)]
    found = wp.zeros(1, dtype=wp.float64, device="cpu")
    wp.launch(following, 1, [*given, wp.array([bracket], dtype=wp.vec2d, device="cpu")], [found], device="cpu")
    assert found.numpy()[0] == pytest.approx(expected, rel=1e-12)
