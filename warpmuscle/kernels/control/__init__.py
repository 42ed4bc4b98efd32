"""Controllers of joints and muscles.

May import: kernels.

To add: a controller as a file, and its name to the table of controllers.
"""

from warpmuscle.kernels.moved import of_former_module

__getattr__ = of_former_module(__name__, "control")
