"""Numbers of bodies and joints."""

import pytest

from biped import biped
from warpmuscle.scene import Body, Character, Joint
from warpmuscle.scene.topology import topology

ZERO = (0.0, 0.0, 0.0)


def tree(links: dict[str, tuple[str, str]], root_joint: str = "free") -> Character:
    """A character from joints named by child: (type, parent)."""
    body = Body(1.0, (1.0, 1.0, 1.0))
    joints = {f"to {child}": Joint(kind, parent, child, ZERO, ZERO) for child, (kind, parent) in links.items()}
    return Character("root", {"root": body} | dict.fromkeys(links, body), joints, root_joint)


# in an order that is neither breadth nor depth first
LINKS = {
    "c": ("hinge", "b"),
    "a": ("ball", "root"),
    "b": ("universal", "root"),
    "d": ("fixed", "a"),
    "e": ("hinge", "d"),
    "f": ("ball", "b"),
}


def test_bodies_are_numbered_breadth_first_and_siblings_in_the_order_of_the_joints():
    names = topology(tree(LINKS))
    assert names.bodies == ("root", "a", "b", "d", "c", "f", "e")
    assert names.joints == tuple(f"to {body}" for body in names.bodies[1:])
    assert names.parents == (-1, 0, 0, 1, 2, 2, 3)


def test_levels_and_children_are_ranges_of_neighbours():
    names = topology(tree(LINKS))
    assert names.level_start == (0, 1, 3, 6, 7)
    for body in range(len(names.bodies)):
        first, count = names.first_child[body], names.child_count[body]
        assert list(range(first, first + count)) == [i for i, parent in enumerate(names.parents) if parent == body]


@pytest.mark.parametrize(("root_joint", "coordinates", "speeds"), [("free", 7, 6), ("planar", 3, 3), ("fixed", 7, 0)])
def test_coordinates_and_speeds_are_counted_by_joint_type(root_joint: str, coordinates: int, speeds: int):
    names = topology(tree(LINKS, root_joint))
    sizes = [4, 2, 0, 1, 4, 1]  # a, b, d, c, f, e
    assert names.coordinate_start == tuple([0] + [coordinates + sum(sizes[:i]) for i in range(7)])
    assert names.coordinates == coordinates + 12
    assert names.speeds == speeds + 3 + 2 + 0 + 1 + 3 + 1


def test_biped_has_34_degrees_of_freedom_in_the_order_of_the_original():
    names = topology(biped())
    assert (len(names.bodies), names.speeds) == (15, 34)
    assert names.joints[:3] == ("pelvis_torso", "lHip", "rHip")
    assert names.joints[-2:] == ("lToeJoint", "rToeJoint")


def test_a_joint_is_that_of_the_body_it_carries():
    names = topology(tree(LINKS))
    assert names.body_of_joint("root") == 0
    assert all(names.bodies[names.body_of_joint(f"to {body}")] == body for body in LINKS)


def test_a_single_body_is_a_character():
    names = topology(tree({}))
    assert (names.bodies, names.joints, names.level_start, names.speeds) == (("root",), (), (0, 1), 6)
