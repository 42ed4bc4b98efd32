"""Checks of scenes before anything is simulated; every finding names file, line and key.

May import: core, kernels, scene.
To add: a check to the module named after the part of the scene, with a test in `tests/scene/validation`.
"""
