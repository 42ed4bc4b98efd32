"""Objects of a scene as a kernel wants them.

May import: scene, kernels and what lies beside it in `model`.
To add: a number of objects to `arrays`, where `kernels.object_structs` has it.
"""
