"""Quadratic programmes on a device: batches of them, and those of a controller in every step of control.

May import: simulation and all below.
To add: a way to state a programme, as a function to `solve`.
"""
