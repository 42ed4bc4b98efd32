"""What simulations and searches leave behind: recorded motions, evaluated candidates, the HDF5 files that hold them.

May import: core, kernels, scene.
To add: a recorded quantity, a field of `recorded_quantities.RecordedQuantities`; a dataset to `layout`.
"""
