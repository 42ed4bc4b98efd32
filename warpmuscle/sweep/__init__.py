"""Sweeps: many optimisations of one scene with other numbers, on this machine or on a cluster.

`plan.py` says what a sweep file holds; `run.py` runs one.

May import: report and all below.
To add: a key of sweep files to `plan`; a place where runs go on beside `local` and `cluster`.
"""
