"""Numbers, vectors and curves that know of no body.

May import: kernels.

To add: a function on plain values.
"""
