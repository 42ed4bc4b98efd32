"""Loops of bodies: what holds two bodies together that no joint joins.

May import: kernels.

To add: rows of a type of constraint in `constraints`.
"""
