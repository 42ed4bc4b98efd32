"""Constraints of OpenSim that close loops of bodies: read, built into a scene that meets them, and written; and locks.

May import: core, scene, formats.osim, formats.lines.
To add: a class of OpenSim to `read.TYPES`, its elements to `read` and `write`.
"""
