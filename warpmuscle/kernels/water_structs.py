"""Device structures of water, see `water/`."""

import warp as wp


@wp.struct
class WaterRow:
    """A part of a body as a capsule, and the water about it."""

    middle: wp.vec3  # m, body axes, from its joint
    half: wp.vec3  # m, from there to the tip, round end included
    reach: float  # m, the same as a length
    radius: float  # m
    volume: float  # m^3
    share: float  # 1/m^2, of a section's volume in that, for each unit of its squared radius
    level: float  # m, y of the surface
    density: float  # kg/m^3
    across: float  # m^2, drag coefficient times area, moved across its length
    along: float  # m^2, and along it
    added_across: float  # added mass in that of the displaced water
    added_along: float
    current: wp.vec3  # m/s, of the water


@wp.struct
class WaterExtension:
    """All that may be under water."""

    row: wp.array2d[WaterRow]  # (rows, parts)
    start: wp.array[int]  # (bodies + 1,) first part of each body
