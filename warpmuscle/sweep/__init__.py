"""Sweeps: many optimisations of one scene with other numbers, on this machine or on a cluster.

`plan.py` says what a sweep file holds; `run.py` runs one.
"""
