"""Muscle synergies: signals and matrices of numbers, no bipeds.

May import: core.
To add: a module of one topic; a format of recordings to `recordings`.
"""
