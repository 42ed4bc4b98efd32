"""Thousands of independent muscle-actuated bipeds at once, with NVIDIA Warp."""
