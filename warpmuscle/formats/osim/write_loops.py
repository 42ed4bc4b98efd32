"""Constraints between bodies, as a model file has them."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.formats.osim.loops import TYPES
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.formats.osim.write_frames import angles_of, frame_xml, placed
from warpmuscle.formats.osim.write_muscles import frame_path
from warpmuscle.formats.osim.xml_text import element, name_of, numbers
from warpmuscle.scene import Constraint, Scene
from warpmuscle.scene.initial_pose import plain_number, plain_vector

CLASSES = {kind: name for name, kind in TYPES.items()}


def constraint_elements(scene: Scene) -> list[str]:
    """All constraints between bodies of a scene without free parameters."""
    return [_element(scene, name, one) for name, one in scene.character.constraints.items()]


def _element(scene: Scene, name: str, one: Constraint) -> str:
    path, other_path = frame_path(scene, one.body), frame_path(scene, one.other_body)
    place, other_place = plain_vector(one.position), plain_vector(one.other_position)
    if one.type == "weld":
        near = frame_xml("near", path, WORLD.T @ place, _angles(plain_vector(one.orientation)))
        far = frame_xml("far", other_path, WORLD.T @ other_place, _angles(plain_vector(one.other_orientation)))
        inner = element("socket_frame1", "near") + element("socket_frame2", "far") + element("frames", near + far)
    elif one.type == "point_on_line":
        inner = placed("socket_line_body", other_path, other_place, "point_on_line")
        inner += placed("socket_follower_body", path, place, "point_on_follower")
        inner += element("line_direction_vec", numbers(vector(WORLD.T @ normalized(plain_vector(one.axis)))))
    else:
        inner = placed("socket_body_1", path, place, "location_body_1")
        inner += placed("socket_body_2", other_path, other_place, "location_body_2")
        if one.type == "distance":
            inner += element("constant_distance", numbers([plain_number(one.distance)]))
    return element(CLASSES[one.type], inner, name=name_of(name))


def _angles(orientation: Floats) -> tuple[float, float, float]:
    """The axes of a frame in OpenSim's axes of its body, as turns about x, the new y and the newer z."""
    return angles_of(WORLD.T @ rotate(normalized(orientation), np.eye(3)).T)
