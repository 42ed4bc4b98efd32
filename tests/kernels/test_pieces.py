"""Which piece of a function a coordinate is in, and which muscle a lane takes."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.body.joint_motion import piece_of
from warpmuscle.kernels.memory.turns import in_turn
from warpmuscle.kernels.structs import CubicPiece


@wp.kernel(enable_backward=False)
def find(pieces: wp.array2d[CubicPiece], first: int, end: int, q: wp.array[float], found: wp.array[int]):
    i = wp.tid()
    found[i] = piece_of(pieces, 0, first, end, q[i])


@wp.kernel(enable_backward=False)
def share(lanes: int, count: int, taken: wp.array[int]):
    lane = wp.tid()
    for k in range(lane, count, lanes):
        taken[k] = in_turn(k, lane, lanes, count)


@pytest.mark.parametrize("count", [1, 2, 16, 17, 90])
def test_the_piece_is_the_last_that_starts_before_or_the_first(count: int):
    rng = np.random.default_rng(count)
    start = np.sort(rng.uniform(-1.0, 1.0, count)).astype(np.float32)
    table = np.zeros((1, count + 6), dtype=CubicPiece.numpy_dtype())
    table["start"][0] = np.concatenate([rng.uniform(-1, 1, 4), start, rng.uniform(-1, 1, 2)])
    q = np.concatenate([start, rng.uniform(-1.5, 1.5, 300)]).astype(np.float32)
    found = wp.zeros(len(q), dtype=int, device="cpu")
    pieces = wp.array(table, dtype=CubicPiece, device="cpu")
    inputs = [pieces, 4, 4 + count, wp.array(q, dtype=float, device="cpu")]
    wp.launch(find, dim=len(q), inputs=inputs, outputs=[found], device="cpu")
    np.testing.assert_array_equal(found.numpy(), 4 + np.maximum(np.searchsorted(start, q, side="right") - 1, 0))


@pytest.mark.parametrize(("lanes", "count"), [(1, 5), (4, 3), (4, 12), (16, 92), (16, 80), (8, 15)])
def test_every_muscle_is_taken_once_and_lanes_get_alike_work(lanes: int, count: int):
    taken = wp.zeros(count, dtype=int, device="cpu")
    wp.launch(share, dim=lanes, inputs=[lanes, count], outputs=[taken], device="cpu")
    turns = taken.numpy()
    assert sorted(turns) == list(range(count))
    whole = count // (2 * lanes) * 2 * lanes  # there and back
    if whole:
        by_lane = [turns[lane:whole:lanes].sum() for lane in range(lanes)]
        assert min(by_lane) == max(by_lane)
