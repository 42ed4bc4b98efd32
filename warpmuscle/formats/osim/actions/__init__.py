"""Forces of OpenSim that are functions or expressions, and actuators with what controllers prescribe for them.

May import: core, scene, formats.osim, formats.lines.
To add: a class of forces to `read.READERS`, and to `build.ActionBuilder`.
"""
