"""Paths of muscles: straight, polynomial, and round surfaces.

May import: kernels.

To add: a surface as a file, and its number to `route_bends`.
"""

from warpmuscle.kernels.moved import of_former_module

__getattr__ = of_former_module(__name__, "path")
