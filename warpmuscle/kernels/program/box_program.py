"""The quadratic programme of a controller: controls within bounds that bring a body to wanted accelerations.

With the mass matrix M of n coordinates, the forces h that no control makes, B the forces of m controls at a unit each:

    minimise  1/2 |wanted - q''|^2_W + 1/2 sum of c_j u_j^2    so that  M q'' + h = B u,  low <= u <= high

Controls are activations of muscles, torques, and forces along the edges of friction cones; so it is the programme of
Lee, Park, Kwon and Lee 2014 (ACM Trans. Graph. 33, 218), whose contact forces are nonnegative sums of such edges, too.

The unknown is one multiplier x a *coordinate*, as in `kernels.inverse.static_optimization`: controls are
u_j(x) = (B^T x)_j / c_j within their bounds, accelerations wanted - W^-1 M x. What is left,
R x + B u(x) = M wanted + h with R = M W^-1 M, is the slope of a convex function, which Newton's method solves with the
exact zero of the slope along each step. No set of active bounds is kept, and matrices have the size of the body. It is
solved in double precision: R has the square of the condition of M.
"""

import warp as wp

from warpmuscle.kernels.program.newton import (
    GIVEN_UP,
    GOES_ON,
    SMALLEST,
    balance,
    control_of,
    controls_at,
    newton_step,
    outcome,
    step_length,
)
from warpmuscle.kernels.program.reduction import accelerations, factorize, needed_forces, reserve_of
from warpmuscle.kernels.program.structs import Columns, Programs, ProgramWork

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.kernel
def box_program(
    # in
    chosen: wp.array[int], programs: Programs, columns: Columns,
    # in and out
    work: ProgramWork, multiplier: wp.array2d[wp.float64],
    # out
    control: wp.array2d[float], acceleration: wp.array2d[float], iterations: wp.array[int],
):  # fmt: skip
    """Solve the programmes that are chosen, a thread each.

    Args:
        chosen: their numbers. multiplier: (programs, n) where the search begins, and where it ends.

    Returns:
        control: (programs, m). acceleration: (programs, n). iterations: (programs,) -1: the balance was not reached.
    """
    p = chosen[wp.tid()]
    n = programs.bias.shape[1]
    m = columns.first.shape[0] - 1
    controls = controls_at(p, programs)
    controls.entry = programs.entry[p]
    mass = programs.mass[p]
    wanted = programs.wanted[p]
    factor = work.factor[p]
    reserve = work.reserve[p]
    hessian = work.hessian[p]
    needed = work.vector[p, 0]
    h = work.vector[p, 1]
    size = work.vector[p, 2]
    d = work.vector[p, 3]
    y = work.by_control[p, 0]
    dy = work.by_control[p, 1]
    x = multiplier[p]
    factorize(n, programs.weight[p], factor)
    needed_forces(n, mass, programs.bias[p], wanted, needed)
    reserve_of(n, mass, factor, work.square[p], reserve)
    count = wp.int32(0)
    ended = wp.int32(GOES_ON)
    before = wp.float64(wp.inf)
    while ended == GOES_ON:
        balance(n, m, controls, columns, reserve, x, y, needed, h, size, hessian)
        error = wp.float64(0.0)
        for i in range(n):
            error = wp.max(error, wp.abs(h[i]) / (size[i] + wp.float64(SMALLEST)))
        ended = outcome(count, error, before)
        if ended == GOES_ON:
            count += 1
            before = error
            newton_step(n, hessian, h, d)
            t = step_length(n, m, controls, columns, reserve, x, d, y, dy, needed, h)
            for i in range(n):
                x[i] = x[i] + t * d[i]
    for j in range(m):
        control[p, j] = wp.float32(control_of(y[j], j, controls)[0])
    accelerations(n, mass, wanted, factor, x, d, acceleration[p])
    iterations[p] = wp.where(ended == GIVEN_UP, -1, count)
