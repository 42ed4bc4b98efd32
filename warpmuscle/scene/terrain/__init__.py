"""Ground that is not flat: tiles that a scene describes, the grids that they are made of, and where they lie.

May import: core, scene.
To add: a kind of tile to `tiles`, the grid that it is made of to `shapes`, its checks to `scene.validation.terrain`.
"""
