"""What the solver of quadratic programmes is given, for many of one size, and the memory it works in."""

import warp as wp


@wp.struct
class Columns:
    """Which entries of B are not zero: the same ones in all programmes, a control after the other."""

    first: wp.array[int]  # (controls + 1,) in `row`
    row: wp.array[int]  # (entries,) coordinates, which increase within a control


@wp.struct
class Programs:
    """Numbers of all programmes, see `box_program.py`; n coordinates, m controls."""

    mass: wp.array2d[float]  # (programs, n n) M, symmetric
    bias: wp.array2d[float]  # (programs, n) h
    weight: wp.array2d[float]  # (programs, n n) W, symmetric
    wanted: wp.array2d[float]  # (programs, n) accelerations
    entry: wp.array2d[float]  # (programs, entries) of B
    gain: wp.array2d[float]  # (programs or 1, m) 1 over the cost of a squared control
    low: wp.array2d[float]  # (programs or 1, m) bounds
    high: wp.array2d[float]


@wp.struct
class ProgramWork:
    """Working memory of programmes; of symmetric matrices and factors the lower half, row by row."""

    factor: wp.array2d[wp.float64]  # (programs, n (n + 1)/2) L of W; 1 over its diagonal
    square: wp.array2d[wp.float64]  # (programs, n n) L^-1 M
    reserve: wp.array2d[wp.float64]  # (programs, n (n + 1)/2) R
    hessian: wp.array2d[wp.float64]  # (programs, n (n + 1)/2)
    vector: wp.array3d[wp.float64]  # (programs, 4, n) needed, h, sizes, d
    by_control: wp.array3d[wp.float64]  # (programs, 2, m) B^T x and B^T d
