"""What notebooks show of a scene: it is built on what is built on scenes, and tells these of itself.

May import: core, scene.
To add: a row of the table to `table`.
"""
