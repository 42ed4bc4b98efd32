"""Paths that wrap around surfaces, in float64 on the host: a file a surface, `path` for several, `route` for a muscle.

The device has the same in `kernels.wrap_cylinder` and the files beside it, and in `kernels.route`.

May import: core, scene.
To add: a surface, as a file with its `touch` here, in `route`, in `kernels.route`, and in `model.routes`.
"""
