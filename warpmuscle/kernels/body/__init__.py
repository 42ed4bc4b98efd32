"""Bodies and joints: kinematics, dynamics, integration, limits.

May import: kernels.

To add: a joint of one coordinate as a motion in `joint_motion`.
"""
