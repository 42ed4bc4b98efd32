"""Batches of instances that run: inputs, launches, recording, one device or several.

May import: core, kernels, scene, results, model, formats, gait.
To add: what an instance starts from to `inputs`; what disturbs it to `perturbations`; what is recorded to `recorder`.
"""
