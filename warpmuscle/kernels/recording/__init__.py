"""Frames of chosen instances.

May import: kernels.

To add: what frames hold to `record`.
"""
