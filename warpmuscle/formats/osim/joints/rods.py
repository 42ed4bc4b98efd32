"""Joints whose child is at the end of a rod that bends along an arc: OpenSim's ConstantCurvatureJoint.

The child turns about x, the new z and the newest y axis; where the end of the rod is, the first two say, see
`scene.joints.two_coordinates`.
"""

from __future__ import annotations

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import Rod

ROD = "ConstantCurvatureJoint"


def read_rod(element: Element, own: Properties) -> Rod:
    """The rod of a joint.

    Raises:
        SceneError: it has no length.
    """
    length = own.number(element, "length", 1.0)
    if not length > 0.0:
        element.fail(f"the length of its rod is greater than 0, not {length:g}")
    return Rod(length, own.vector(element, "neutral_angle_x_z_y"))
