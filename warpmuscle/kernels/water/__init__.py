"""Water: what it does to bodies that are in it, and how heavy it makes them.

May import: kernels.
To add: a force on a section to `section`, with its numbers in `water_structs`.
"""
