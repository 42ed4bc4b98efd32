"""Search strategies: ask/tell, on plain numbers in the unit cube.

May import: core.
To add: a class with `ask` and `tell` like `random.py`, its line in `strategies`.
"""
