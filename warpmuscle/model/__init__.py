"""Scenes as arrays on a device: what the kernels read.

May import: core, kernels, scene.
To add: a part of the device's model in the module named after it, and to `build.PARTS`; what a scene has whatever its
numbers are to `structure`; what a batch tells a model beside its scene to `build.ModelInputs`.
"""
