"""What lanes make of a programme of reserves, against float64; and that they keep to the places that are theirs."""

import numpy as np
import warp as wp
from probes import filled

from warpmuscle.kernels.program.lane_program import LaneWork, lane_reserve

N, SENTINEL = 4, 7.0


@wp.kernel(enable_backward=False)
def reserve(
    n: int, mass: wp.array[float], weight: wp.array[float], factor: wp.array[wp.float64], work: LaneWork,
):  # fmt: skip
    its = work
    lane_reserve(0, 1, n, mass, weight, factor, its)


def test_reserves_are_m_w_inverse_m_and_nothing_is_written_beside_them():
    random = np.random.default_rng(0)
    mass, weight = (one @ one.T + N * np.eye(N) for one in random.normal(size=(2, N, N)))
    half = N * (N + 1) // 2
    work = filled(
        LaneWork, hessian=np.full(half + 1, SENTINEL), reserve=np.full(half + 1, SENTINEL),
        square=np.full(N * N + 1, SENTINEL),
    )  # fmt: skip
    factor = wp.array(np.full(half + 1, SENTINEL), dtype=wp.float64, device="cpu")
    given = [wp.array(np.r_[m.ravel(), np.zeros(N)].astype(np.float32), device="cpu") for m in (mass, weight)]
    wp.launch(reserve, 1, [N, *given, factor, work], device="cpu")
    rows, columns = np.tril_indices(N)
    expected = (mass @ np.linalg.solve(weight, mass))[rows, columns]
    np.testing.assert_allclose(work.reserve.numpy()[:half], expected, rtol=1e-5)
    lower = np.linalg.cholesky(weight)
    inverted = np.where(rows == columns, 1.0 / lower[rows, columns], lower[rows, columns])
    np.testing.assert_allclose(factor.numpy()[:half], inverted, rtol=1e-5)
    for array in (work.hessian, work.reserve, work.square, factor):
        assert array.numpy()[-1] == SENTINEL
