"""Batches of instances that run: inputs, launches, recording, one device or several.

May import: core, kernels, scene, results, model, formats, gait.
To add: what a batch can do to `batch`, and to `rollout` and `multi_device`, which have it; what it is told to `inputs`;
how its state begins, ends and returns to `batch_state`; which kernel it launches to `launcher`; what disturbs it to
`perturbations`; what is recorded to `recorder`; what its results are to `outcome`.
"""
