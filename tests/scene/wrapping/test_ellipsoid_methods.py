"""Paths round ellipsoids by the methods `midpoint` and `axial`, as long as OpenSim's are."""

import numpy as np
import pytest

from warpmuscle.scene import EllipsoidSurface
from warpmuscle.scene.wrapping.cylinder import IN_PLANE
from warpmuscle.scene.wrapping.route import touch

ZERO = (0.0, 0.0, 0.0)
# Method, side, both ends and radii, m; getLength of OpenSim 4.6's muscle of two points round a WrapEllipsoid, m.
OPENSIM = [
    ("midpoint", "+z", (0.016, 0.07, 0.036), (0.011, 0.001, -0.071), (0.049, 0.05, 0.056), 0.305993464),
    ("midpoint", "+z", (0.006, -0.035, -0.032), (-0.084, 0.098, 0.046), (0.04, 0.044, 0.049), 0.209101744),
    ("midpoint", "-x", (-0.026, 0.01, -0.084), (0.064, 0.015, 0.022), (0.043, 0.043, 0.056), 0.313246982),
    ("axial", "+z", (0.006, -0.035, -0.032), (-0.084, 0.098, 0.046), (0.04, 0.044, 0.049), 0.205713673),
    ("axial", "+z", (-0.105, -0.072, -0.013), (0.045, 0.031, -0.039), (0.055, 0.046, 0.057), 0.270814422),
    ("axial", "-x", (0.017, 0.023, 0.011), (-0.041, -0.038, -0.059), (0.038, 0.023, 0.055), 0.124433216),
]


@pytest.mark.parametrize(("method", "side", "a", "b", "radii", "length"), OPENSIM)
def test_paths_by_a_method_go_where_opensims_go(method, side, a, b, radii, length):
    a, b = np.array(a), np.array(b)
    got = touch(EllipsoidSurface("b", ZERO, radii, side=side), method, IN_PLANE, a, b)
    found = float(np.linalg.norm(got.first - a) + np.linalg.norm(got.second - b)) + got.length
    assert found == pytest.approx(length, abs=2e-8)
