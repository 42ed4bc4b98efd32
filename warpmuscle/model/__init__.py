"""Scenes as arrays on a device: what the kernels read.

May import: core, kernels, scene.
To add: a part of the device's model in the module named after it, called by `build`.
"""
