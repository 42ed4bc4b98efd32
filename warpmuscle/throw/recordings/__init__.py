"""Recorded motions that arms are fitted to: read, low-passed where they are noisy, and held against the arm's limits.

May import: throw and all below.
To add: another kind of file to `motion_files`; a reason to refuse a motion, or a note on it, to `arm_motions`.
"""
