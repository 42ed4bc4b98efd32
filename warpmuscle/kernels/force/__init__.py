"""What else acts on joints and bodies: devices, springs, drives.

May import: kernels.

To add: a passive device to `devices`.
"""
