"""Ground that is not flat on a device: the bank of tiles that instances share, and where their own lie (`bank`).

May import: core, kernels, scene.
To add: a number of tiles to `kernels.terrain_structs` and here; kinds of tiles are grids, see `scene.terrain.shapes`.
"""
