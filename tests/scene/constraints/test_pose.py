"""Constraints of a scene: how far they are from being met, the nearest pose, and what is wrong with one."""

import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import Body, Character, Constraint, Ground, Joint, JointState, Scene
from warpmuscle.scene.constraints.pose import (
    constraint_errors,
    meeting_speeds,
    met_pose,
    nearest_pose,
    searched_pose,
    slopes,
    start_coordinates,
    stray_pose,
)
from warpmuscle.scene.scaling import scaled_segments
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.scene import check_scene

TIP = (0.0, -0.2, 0.0)
X, NONE = (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def pair(kind: str = "point", **more: object) -> Scene:
    """Two rods that hang side by side from a fixed bar, 0.3 m apart, with a joint in the middle of each."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("bar", "a", "b", "c", "d")}
    joints = {
        "ja": Joint("hinge", "bar", "a", (0.0, 0.0, 0.15), (0.0, 0.2, 0.0), [X]),
        "jb": Joint("hinge", "a", "b", TIP, (0.0, 0.2, 0.0), [X]),
        "jc": Joint("hinge", "bar", "c", (0.0, 0.0, -0.15), (0.0, 0.2, 0.0), [X]),
        "jd": Joint("hinge", "c", "d", TIP, (0.0, 0.2, 0.0), [X]),
    }
    character = Character("bar", bodies, joints, "fixed")
    character.constraints = {"held": Constraint(kind, "b", "d", TIP, TIP, **more)}
    return Scene("pair", character, ground=Ground(stiffness=0.0))


def at(scene: Scene, angles: list[float]) -> np.ndarray:
    names = topology(scene.character)
    q = start_coordinates(scene, names)
    q[:, -4:] = angles
    return constraint_errors(scene.character, names, q)[0]


def test_errors_are_how_far_points_are_apart():
    upright = [0.0, 0.0, 0.0, 0.0]  # of ja, jc, jb, jd: bodies are numbered breadth first
    np.testing.assert_allclose(at(pair(), upright), [0.0, 0.0, 0.3], atol=1e-15)
    np.testing.assert_allclose(at(pair("distance", distance=0.1), upright), [0.2], atol=1e-15)
    across = at(pair("point_on_line", axis=(0.0, 1.0, 0.0)), upright)
    assert np.linalg.norm(across) == pytest.approx(0.3)
    np.testing.assert_allclose(at(pair("point_on_line", axis=(0.0, 0.0, 1.0)), upright), [0.0, 0.0], atol=1e-15)
    turned = at(pair("weld"), [0.1, -0.2, 0.05, 0.0])
    np.testing.assert_allclose(turned[3:], [2.0 * np.sin(0.5 * 0.35), 0.0, 0.0], atol=1e-12)


def test_the_nearest_pose_changes_coordinates_least():
    scene = pair()
    names, chosen = topology(scene.character), [7, 8, 9, 10]
    start = start_coordinates(scene, names)
    start[0, chosen] = [0.3, -0.1, 0.2, -0.4]
    far = np.full(4, 9.0)
    pose, missing = nearest_pose(scene.character, names, start, chosen, -far, far)
    assert missing < 1e-12
    change, slope = (pose - start)[0, chosen], slopes(scene.character, names, pose, chosen)
    along = np.linalg.svd(slope)[2][2:]  # in which constraints leave coordinates free
    np.testing.assert_allclose(along @ change, 0.0, atol=1e-7)
    assert 0.0 < np.linalg.norm(change) < 1.5


def test_rods_in_line_come_closer_by_the_law_of_cosines():
    """Two rods of 0.4 m hang straight, and the end of the second is held 0.7 m from where the first one hangs."""
    scene = pair("distance", distance=0.7)
    held = scene.character.constraints["held"]
    held.other_body, held.other_position = "bar", (0.0, 0.0, 0.15)
    names, chosen = topology(scene.character), [7, 9]  # ja and jb
    start, far = start_coordinates(scene, names), np.full(2, 1e3)
    _, missing = nearest_pose(scene.character, names, start, chosen, -far, far)
    assert missing == pytest.approx(0.1, abs=1e-9)
    q, missing = stray_pose(scene.character, names, start, chosen, -far, far)
    assert missing < 1e-8
    np.testing.assert_allclose(np.abs(q[0, chosen]), [0.0, np.arccos((0.7**2 - 2 * 0.4**2) / (2 * 0.4**2))], atol=1e-6)


def sliding(kind: str = "distance", **more: object) -> Scene:
    """A block that slides along two axes, and whose middle a constraint holds to the middle of the bar."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("bar", "a", "b")}
    joints = {
        "x": Joint("slide", "bar", "a", NONE, NONE, [X]),
        "y": Joint("slide", "a", "b", NONE, NONE, [(0.0, 1.0, 0.0)]),
    }
    character = Character("bar", bodies, joints, "fixed")
    character.constraints = {"rod": Constraint(kind, "b", "bar", **more)}
    return Scene("sliding", character, ground=Ground(stiffness=0.0))


def test_the_nearest_pose_is_found_where_constraints_bend_more_than_the_way_is_long():
    """From 1 m away, the nearest place of a circle of 0.1 m is on the line to its middle."""
    scene = sliding(distance=0.1)
    names, chosen, far = topology(scene.character), [7, 8], np.full(2, 1e3)
    q = start_coordinates(scene, names)
    q[0, chosen] = [0.96, 0.28]
    _, missing = nearest_pose(scene.character, names, q, chosen, -far, far)
    assert missing > 1e-3  # each step overshoots ninefold
    pose, missing = searched_pose(scene.character, names, q, chosen, -far, far)
    assert missing < 1e-8
    np.testing.assert_allclose(pose[0, chosen], [0.096, 0.028], atol=1e-6)
    met, _ = met_pose(scene.character, names, q, chosen, -far, far)
    np.testing.assert_array_equal(met, pose)
    far[1] = 0.02
    pose, _ = searched_pose(scene.character, names, q, chosen, -far, far)
    np.testing.assert_allclose(pose[0, chosen], [np.sqrt(0.1**2 - 0.02**2), 0.02], atol=1e-6)


def test_the_search_leaves_out_what_other_rows_say():
    """Of the three rows of a point in a plane, the one across it is always 0."""
    scene = pair()
    names, chosen, far = topology(scene.character), [7, 8, 9, 10], np.full(4, 9.0)
    q = start_coordinates(scene, names)
    q[0, chosen] = [0.3, -0.1, 0.2, -0.4]
    pose, missing = searched_pose(scene.character, names, q, chosen, -far, far)
    nearest, _ = nearest_pose(scene.character, names, q, chosen, -far, far)
    assert missing < 1e-8
    np.testing.assert_allclose(pose, nearest, atol=1e-5)


def test_coordinates_stay_within_their_bounds_and_what_is_missing_is_told():
    scene = pair()
    names, chosen = topology(scene.character), [7, 8, 9, 10]
    start, bounds = start_coordinates(scene, names), np.full(4, 0.1)
    pose, missing = nearest_pose(scene.character, names, start, chosen, -bounds, bounds)
    assert np.abs(pose[0, chosen]).max() <= 0.1
    assert missing > 0.01


def test_speeds_that_keep_constraints_met_are_the_nearest():
    scene = pair("distance", distance=0.3)
    names, chosen = topology(scene.character), [7, 8, 9, 10]
    q, v = start_coordinates(scene, names), np.array([1.0, 2.0, -1.0, 0.5])
    found, slope = meeting_speeds(scene.character, names, q, chosen, v), slopes(scene.character, names, q, chosen)
    np.testing.assert_allclose(slope @ found, 0.0, atol=1e-9)
    assert np.linalg.matrix_rank(np.stack([found - v, slope[0]]), tol=1e-6) == 1


def test_a_constraint_is_written_and_read_again():
    scene = pair("distance", distance=0.3)
    assert loads(dumps(scene)).character.constraints == scene.character.constraints


def test_points_grow_with_their_bodies():
    scaled = scaled_segments(pair("distance", distance=0.3), {"b": 1.5})
    held = scaled.character.constraints["held"]
    assert held.position == pytest.approx((0.0, -0.3, 0.0))
    assert held.other_position == TIP


def test_a_constraint_that_is_not_met_at_the_start_is_told_with_how_far_it_is_off():
    with pytest.raises(SceneError, match=r"constraints\.held: is off by 0\.3 .* at the start"):
        check_scene(pair())
    met = pair("distance", distance=0.3)
    check_scene(met)
    x, y, z, w = (float(number) for number in about(np.array(X), 0.1))
    met.initial_state.joints["ja"] = JointState((x, y, z, w))
    with pytest.raises(SceneError, match="is off by"):
        check_scene(met)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"body": "nobody"}, "nobody"), ({"other_body": "b"}, "two different bodies"),
        ({"axis": (0.0, 0.0, 0.0)}, "axis"),
        ({"distance": 0.0}, "distance"), ({"orientation": (0.0, 0.0, 0.0, 0.0)}, "quaternion"),
        ({"type": "rope"}, "rope"),
    ],
)  # fmt: skip
def test_what_a_constraint_cannot_be_is_refused(change: dict[str, object], said: str):
    scene = pair("distance", distance=0.3)
    for field, value in change.items():
        setattr(scene.character.constraints["held"], field, value)
    with pytest.raises(SceneError, match=said):
        check_scene(scene)


def test_more_rows_than_there_is_room_for_are_refused():
    scene = pair("distance", distance=0.3)
    scene.character.constraints = {f"c{k}": scene.character.constraints["held"] for k in range(61)}
    with pytest.raises(SceneError, match="more than 60"):
        check_scene(scene)
