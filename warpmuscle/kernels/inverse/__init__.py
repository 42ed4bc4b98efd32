"""From recorded motions to coordinates, moments and muscle forces.

May import: kernels.

To add: a kernel over many frames as a file.
"""
