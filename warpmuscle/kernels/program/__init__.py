"""Quadratic programmes of controllers: wanted accelerations, and what muscles, torques and contacts can do for them.

May import: kernels.

To add: a task of the controller to `tasks.py`, another kind of control to `gather.py`.
"""
