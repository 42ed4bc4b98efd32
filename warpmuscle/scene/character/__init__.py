"""What a scene says of its character: shapes and materials, bodies, joints, and what it keeps of an OpenSim model.

May import: core, scene.
To add: a shape to `shapes`; what a joint may say to `tree`.
"""
