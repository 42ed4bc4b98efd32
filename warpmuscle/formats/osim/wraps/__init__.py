"""What is known of paths that wrap before anything moves.

May import: core, scene, formats.osim, formats.lines.
To add: a class of surfaces to `idle.is_inside`.
"""
