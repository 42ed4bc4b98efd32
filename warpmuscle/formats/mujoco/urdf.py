"""Skeletons from URDF, as MuJoCo compiles them without meshes: links, joints, and joints that mimic others."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.parsers import expat

DRAWN_OR_RUN = {"visual", "material", "gazebo", "transmission", "mujoco", "plugin", "sensor", "ros2_control"}
POINT = 1.0e-9  # m^2, moments of inertia over mass of a link whose file gives none
Tree = ElementTree.Element


def without_files(text: bytes | str) -> str:
    """A URDF without what is drawn, run or a mesh, so that it names no file any more.

    A mass without moments of inertia, as cameras have that are fixed to others, is one of a point.

    Args:
        text: sound XML without a document type.

    Raises:
        ValueError: a joint mimics one that there is not, which MuJoCo would leave free.
    """
    root = _tree(text)
    joints = {joint.get("name") for joint in root.iter("joint")}
    for joint in root.iter("joint"):
        for mimic in joint.iter("mimic"):
            if mimic.get("joint") not in joints:
                raise ValueError(f"joint {joint.get('name')!r} mimics {mimic.get('joint')!r}, which is not a joint")
    rest = [root]
    while rest:
        element = rest.pop()
        for child in [child for child in element if _left_out(child)]:
            element.remove(child)
        rest += element
    for inertial in root.iter("inertial"):
        mass = inertial.find("mass")
        if mass is not None and inertial.find("inertia") is None:
            _make_point(inertial, mass.get("value", ""))
    return ElementTree.tostring(root, encoding="unicode")


def mimicking(text: str) -> list[str]:
    """Names of the joints of a URDF that move as another one does."""
    joints = [joint for joint in _tree(text).iter("joint") if joint.get("type") not in ("fixed", "floating")]
    return [joint.get("name", "") for joint in joints if joint.find("mimic") is not None]


def _tree(text: bytes | str) -> Tree:
    """Elements by the names that the file gives them, since prefixes of ROS are often bound to nothing."""
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate()
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.Parse(text, True)
    return builder.close()


def _left_out(element: Tree) -> bool:
    """Whether a part of a URDF is no part of a skeleton: pictures, programmes, and collisions with meshes."""
    strange = element.tag in DRAWN_OR_RUN or ":" in element.tag
    return strange or (element.tag == "collision" and element.find(".//mesh") is not None)


def _make_point(inertial: Tree, mass: str) -> None:
    try:
        moment = POINT * float(mass)
    except ValueError:
        return  # of which the compiler tells
    products = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    ElementTree.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "iyy", "izz"), repr(moment)) | products)
