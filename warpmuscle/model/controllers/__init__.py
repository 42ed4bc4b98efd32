"""The controllers that a scene may have, in one table: what each has compiled into a step, and its numbers on a device.

May import: core, kernels, model, scene.
To add: a controller that takes numbers, some for each joint, body or muscle, and keeps a memory, is a module of
`kernels` that declares it, as `control/joint_pd.py` does, and an entry in `control/controllers.py`; scenes choose it
by its `type`. One with a part of the scene or structures of its own is an `Entry` in `table.py`, as SIMBICON is.
"""
