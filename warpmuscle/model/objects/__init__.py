"""Objects of a scene as a kernel wants them.

May import: core, kernels, model, scene.
To add: a number of objects to `arrays`, where `kernels.object_structs` has it.
"""
