"""What notebooks show of a scene, and what its devices look like: built on what is built on scenes.

May import: core, scene.
To add: a row of the table to `table`, a device to `devices`.
"""
