"""Programs of a scene's expressions in the device's table of curves (`programs`).

May import: core, kernels, scene.
To add: what else may have expressions, behind the forces in `programs.expression_tables`.
"""
