"""Expressions that a scene has as text: what forces are, of what they depend on. They are read, never run as code.

May import: core, kernels, scene.
To add: a function to `kernels.algebra.operations.UNARY`, its value to `kernels.algebra.programs.of_one` and `NUMPY`.
"""
