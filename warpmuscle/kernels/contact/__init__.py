"""Bodies on the ground and on each other.

May import: kernels.

To add: a law of contact to `contact_laws`.
"""

from warpmuscle.kernels.moved import of_former_module

__getattr__ = of_former_module(__name__, "contact")
