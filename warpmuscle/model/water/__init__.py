"""Water as a kernel wants it.

May import: scene, kernels and what lies beside it in `model`.
To add: a number to `arrays`, where `kernels.water_structs` has it.
"""
