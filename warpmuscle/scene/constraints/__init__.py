"""Constraints that close loops of bodies: what a scene says of them (`part`), and poses in which they are met (`pose`).

May import: core, scene.
To add: a type to `Constraint`, its rows to `pose`; `kernels.constraint.constraints` has what they push.
"""
