"""Policies, what they sense, and what their decisions are worth.

May import: kernels.

To add: an observation to `senses`, a reward to `rewards`; what it is near to in people, to `likeness`.
"""
