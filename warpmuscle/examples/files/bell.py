"""A custom muscle curve."""

import warp as wp


@wp.func
def bell(length: float) -> float:
    """Active force over f_max at a fibre length over l_opt."""
    return wp.exp((length - 1.0) * (length - 1.0) * (-4.0))
