"""Normalised curves of muscles, a file a set.

May import: kernels.

To add: a set of curves as a file, and its name to `curve_sets`.
"""
