"""Skeletons from URDF, as MuJoCo compiles them without meshes: links, joints, and joints that mimic others."""

from __future__ import annotations

from xml.etree import ElementTree

DRAWN_OR_RUN = {"visual", "material", "gazebo", "transmission", "mujoco", "plugin", "sensor", "ros2_control"}
Tree = ElementTree.Element


def without_files(text: bytes | str) -> str:
    """A URDF without what is drawn, run or a mesh, so that it names no file any more.

    Args:
        text: sound XML without a document type.

    Raises:
        ValueError: a joint mimics one that there is not, which MuJoCo would leave free.
    """
    root = ElementTree.fromstring(text)
    joints = {joint.get("name") for joint in root.iter("joint")}
    for joint in root.iter("joint"):
        for mimic in joint.iter("mimic"):
            if mimic.get("joint") not in joints:
                raise ValueError(f"joint {joint.get('name')!r} mimics {mimic.get('joint')!r}, which is no joint")
    rest = [root]
    while rest:
        element = rest.pop()
        for child in [child for child in element if _left_out(child)]:
            element.remove(child)
        rest += element
    return ElementTree.tostring(root, encoding="unicode")


def _left_out(element: Tree) -> bool:
    """Whether a part of a URDF is no part of a skeleton: pictures, programmes, and collisions with meshes."""
    return element.tag in DRAWN_OR_RUN or (element.tag == "collision" and element.find(".//mesh") is not None)
