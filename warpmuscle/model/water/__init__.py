"""Water as a kernel wants it.

May import: core, kernels, model, scene.
To add: a number to `arrays`, where `kernels.water_structs` has it.
"""
