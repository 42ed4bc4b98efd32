"""Muscles: activation, fibres, what they cost, and what they are asked for.

May import: kernels.

To add: a law of muscles as a file, and its name to `law_names`.
"""

from warpmuscle.kernels.moved import of_former_module

__getattr__ = of_former_module(__name__, "muscle")
