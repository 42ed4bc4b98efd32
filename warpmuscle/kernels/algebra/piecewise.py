"""Functions of one number in cubic pieces, in a table of rows of two."""

import warp as wp

from warpmuscle.kernels.functions import func

PIECE = 3  # rows of a piece in a table: where it starts and its constant, then its other coefficients in twos


@func
def piecewise(table: wp.array[wp.vec2], first: int, x: float) -> float:
    """Value at x of a function of cubic pieces.

    Args:
        first: row of its head, the number of its pieces, which follow; the first one counts before its start, too.
    """
    found = first + 1
    end = found + PIECE * int(table[first][0])
    for row in range(found + PIECE, end, PIECE):
        if table[row][0] <= x:
            found = row
    t = x - table[found][0]
    low = table[found + 1]
    return table[found][1] + t * (low[0] + t * (low[1] + t * table[found + 2][0]))
