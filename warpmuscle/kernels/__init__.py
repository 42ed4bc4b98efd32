"""Warp functions and kernels, on plain values and on the structures of `structs`.

Names that programs of others may rely on stand in `stable.py`. Functions have the decorator of `functions.py`, which
has Warp parse them when a kernel first needs them.

May import: nothing.
To add: an equation as a function, `@func`, in the module of its topic; what a step does with it to a stage, and that
to `step`.
"""

import warpmuscle.kernels.moved  # noqa: F401  finds modules by the names that they had
