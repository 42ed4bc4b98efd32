"""Paths that wrap around surfaces, in float64 on the host: a file a surface, `path` for several, `route` for a muscle.

The device has the same in `kernels.path.wrap_cylinder` and the files beside it, and in `kernels.path.route`.

May import: core, scene.
To add: a surface, as a file with its `touch` here, in `route`, in `kernels.path.route`, and in `model.routes`.
"""
