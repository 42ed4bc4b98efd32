"""Frames of every kind: offsets of offsets, and those that stations define, are where OpenSim has them."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.osim.placement import WORLD

STATIONS = {"a": ("deep", "0.06 0 0"), "b": ("/bodyset/rod", "0.1 0.2 -0.1"), "c": ("/bodyset/rod", "-0.2 0.1 0.3")}


def offset(name: str, parent: str, place: str, turn: str) -> str:
    return (
        f'<PhysicalOffsetFrame name="{name}"><socket_parent>{parent}</socket_parent><translation>{place}</translation>'
        f"<orientation>{turn}</orientation></PhysicalOffsetFrame>"
    )


def framed(ab: str = "<ab_axis>z</ab_axis>", normal: str = "<ab_x_ac_axis>-x</ab_x_ac_axis>", c: str = "c") -> str:
    """A rod with two frames of its own, on which a frame of stations hangs, and on that another offset.

    The rod hangs by that, and a muscle's point is in it.
    """
    own = (
        "<components>" + offset("shallow", "..", "0.1 0 0.02", "0.3 0.1 0")
        + offset("deep", "../shallow", "0 0.05 0", "0 0 -0.5") + "</components>"
    )  # fmt: skip
    places = {name: ("/bodyset/rod/deep" if where == "deep" else where, at) for name, (where, at) in STATIONS.items()}
    stations = "".join(
        f'<Station name="{name}"><socket_parent_frame>{where}</socket_parent_frame><location>{at}</location></Station>'
        for name, (where, at) in places.items()
    )
    sockets = "".join(
        f"<socket_{socket}>/{name}</socket_{socket}>"
        for socket, name in (("point_a", "a"), ("point_b", "b"), ("point_c", c), ("origin_point", "b"))
    )
    more = (
        f'<components>{stations}<StationDefinedFrame name="three">{sockets}{ab}{normal}</StationDefinedFrame>'
        f'{offset("beyond", "/three", "0.02 0.03 0.04", "0.1 0.2 0.3")}</components>'
    )  # fmt: skip
    joint = (
        '<PinJoint name="pin"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/beyond'
        f"</socket_child_frame><coordinates>{small.coordinate('q')}</coordinates></PinJoint>"
    )
    point = (
        '<PathPoint name="p"><socket_parent_frame>/three</socket_parent_frame><location>0.1 0 0.2</location>'
        "</PathPoint>"
    )
    force = small.muscle("m", small.point("g", "ground", "0.5 0.4 0.1") + point)
    return small.model(small.body("rod", center="0.05 -0.3 0.02", more=own), joint, force, more)


def test_a_rod_that_hangs_by_a_frame_of_stations_is_where_opensim_has_it(tmp_path: Path):
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")
    for axes in (
        {},
        {"ab": "", "normal": ""},
        {"ab": "<ab_axis>-y</ab_axis>", "normal": "<ab_x_ac_axis>+z</ab_x_ac_axis>"},
    ):
        path = small.written(tmp_path, framed(**axes))
        model = opensim.Model(str(path))
        state = model.initSystem()
        model.realizePosition(state)
        rod = model.getBodySet().get("rod")
        center = rod.findStationLocationInGround(state, rod.getMassCenter())
        expected = WORLD @ [center.get(k) for k in range(3)]
        scene = load(path, ignored=[])
        joint = scene.character.joints["q"]
        place = np.array(joint.position_in_parent) - np.array(joint.position_in_child)
        np.testing.assert_allclose(place, expected, atol=1e-12)
        at = model.getMuscles().get(0).getGeometryPath().getPathPointSet().get(1).getLocationInGround(state)
        point = scene.character.muscles["m"].path[1]
        np.testing.assert_allclose(place + np.array(point.position), WORLD @ [at.get(k) for k in range(3)], atol=1e-12)


def test_axes_of_stations_are_the_edge_and_the_normal(tmp_path: Path):
    text = framed(ab="", normal="")  # x along b - a, y along the normal
    for name, place in (("a", "0 0 0"), ("b", "0 2 0"), ("c", "0 1 3")):
        where, at = STATIONS[name]
        before = "/bodyset/rod/deep" if where == "deep" else where
        text = text.replace(f"<socket_parent_frame>{before}</socket_parent_frame><location>{at}<",
            f"<socket_parent_frame>/bodyset/rod</socket_parent_frame><location>{place}<")  # fmt: skip
    text = text.replace("<socket_child_frame>/beyond<", "<socket_child_frame>/three<")
    joint = load(small.written(tmp_path, text), ignored=[]).character.joints["q"]
    # the frame's x, y and z are the rod's y, x and -z; the pin turns about z, our bodies are aligned with it
    np.testing.assert_allclose(joint.axes[0], WORLD @ [0.0, 0.0, 1.0], atol=1e-15)
    to_center = np.array([0.05, -0.3, 0.02]) - [0.0, 2.0, 0.0]
    expected = WORLD @ [to_center[1], to_center[0], -to_center[2]]
    np.testing.assert_allclose(np.array(joint.position_in_child), -expected, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (framed(c="b"), "lie on a line"),
        (framed(c="none"), "there is no station '/none'"),
        (framed(normal="<ab_x_ac_axis>z</ab_x_ac_axis>"), "must be different axes"),
        (framed(ab="<ab_axis>w</ab_axis>"), "is one of"),
        (framed().replace('name="b"><socket_parent_frame>/bodyset/rod', 'name="b"><socket_parent_frame>/ground'),
         "different bodies"),
        (framed().replace('name="b"><socket_parent_frame>/bodyset/rod', 'name="b"><socket_parent_frame>/beyond'),
         "hangs on itself"),
    ],
)  # fmt: skip
def test_frames_that_are_none_are_refused_with_their_line(tmp_path: Path, text: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        load(small.written(tmp_path, text), ignored=[])
    assert caught.value.line > 0


def test_units_that_are_not_assigned_are_metres_and_newtons(tmp_path: Path):
    text = small.pendulum(more="<length_units>Unassigned</length_units><force_units>Unassigned</force_units>")
    assert load(small.written(tmp_path, text), ignored=[]).character.joints


def test_places_and_turns_that_are_empty_are_none(tmp_path: Path):
    text = framed()
    for number in ("0.1 0 0.02", "0.3 0.1 0", "0.06 0 0"):
        assert number in text
        text = text.replace(f">{number}<", "> <", 1)
    zeros = framed()
    for number in ("0.1 0 0.02", "0.3 0.1 0", "0.06 0 0"):
        zeros = zeros.replace(f">{number}<", ">0 0 0<", 1)
    empty, level = (load(small.written(tmp_path, one)) for one in (text, zeros))
    assert empty.character == level.character
