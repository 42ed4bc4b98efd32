"""Bodies of other sizes: one of another height and mass, its gait by dynamic similarity, and many of them in a batch.

May import: core, scene, kernels.

To add: what else grows with a body to `similarity`; another proportion to `sized`.
"""
