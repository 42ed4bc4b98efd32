"""Warp functions and kernels."""
