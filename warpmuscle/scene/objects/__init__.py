"""Objects beside the character: what a scene says of them (`part`), how they bounce, and their motion in recordings.

May import: core, scene.
To add: a shape to `part`, with its size and inertia in `shape`, and its checks in `scene.validation.objects`.
"""
