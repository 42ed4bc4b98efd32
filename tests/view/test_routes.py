"""Muscles that wrap or move are drawn where their path runs: as long as the step has them, on their surfaces."""

import msgspec
import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.scene import (
    Condition,
    CylinderSurface,
    EllipsoidSurface,
    JointState,
    Muscle,
    PointMotion,
    SphereSurface,
    Surface,
    TorusSurface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.wrapping.polylines import over
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.muscle_lines import in_bodies
from warpmuscle.view.pieces import surface_pieces
from warpmuscle.view.track import Track, track_of

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

SURFACES: dict[str, Surface] = {
    "cylinder": CylinderSurface("base", (0.0, 0.0, 0.0), 0.05, 0.4, orientation=(0.0, np.pi / 2.0, 0.0)),
    "sphere": SphereSurface("base", (0.0, 0.0, 0.0), 0.05),
}


@pytest.fixture(scope="module")
def track() -> Track:
    """An arm that falls; each muscle wraps around the surface of its name, jumps over a point and moves one."""
    scene = arm()
    character = scene.character
    scene.initial_state.joints["elbow"] = JointState(angular_velocity=(5.0, 0.0, 0.0))
    character.surfaces = SURFACES
    end = character.muscles["flexor"].path[-1]
    beyond = ViaPoint("base", (0.0, -0.21, 0.05), Condition("elbow", 0.05, 3.0, blend=0.0))
    path = [ViaPoint("base", (0.0, 0.2, 0.03)), ViaPoint("base", (0.0, -0.2, 0.03)), beyond, end]
    path[0].motion = [PointMotion((0.0, 1.0, 0.0), slope=0.05, joint="elbow")]
    character.muscles = {
        name: Muscle(path=path, f_max=400.0, l_opt=0.15, l_slack=0.1, wraps=[Wrap(name)]) for name in SURFACES
    }
    rollout = Rollout(msgspec.structs.replace(scene, duration=0.3), 1, "cpu", record=[0], record_rate=50.0)
    rollout.run()
    return track_of(rollout.recording(), scene)


@pytest.mark.parametrize("surface", SURFACES)
def test_a_drawn_route_is_as_long_as_the_muscle_and_lies_on_its_surface(surface: str, track: Track):
    lines, points, row = track.doll.muscles, track.muscle_points(), list(SURFACES).index(surface)
    assert lines.routes == tuple(SURFACES)
    own = slice(*lines.start[row : row + 2])
    drawn = np.linalg.norm(np.diff(points[:, own], axis=1), axis=2).sum(axis=1)
    length = track.recording.muscle_path_length[:, row]
    assert np.ptp(length) > 0.005
    np.testing.assert_allclose(drawn, length, atol=3e-4)  # chords of the arc are shorter
    off = points[:, own] - track.recording.position_of("base")[:, None]
    radius = np.linalg.norm(off[..., 1:] if surface == "cylinder" else off, axis=2)
    assert ((radius > 0.0499).all(axis=1)).all()
    assert (np.isclose(radius, 0.05, atol=1e-6).sum(axis=1) >= 10).all()


def test_the_long_way_round_is_taken_where_the_length_says_so():
    surface = CylinderSurface("base", (0.0, 0.0, 0.0), 0.1, 1.0)
    a, b, part = np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.1, 0.0]), np.array([[0.5]])
    half = 0.1 * np.sqrt(0.5)
    np.testing.assert_allclose(over(surface, a, b, 0.1 * np.pi / 2.0, part)[0], [half, half, 0.0], atol=1e-12)
    np.testing.assert_allclose(over(surface, a, b, 0.1 * np.pi * 1.5, part)[0], [-half, -half, 0.0], atol=1e-12)


def test_surfaces_are_drawn_where_they_are_on_their_bodies():
    scene = arm()
    character = scene.character
    turn = (0.0, np.pi / 2.0, 0.0)  # the surface's z axis along the body's x axis
    character.surfaces = {
        "roll": CylinderSurface("tip", (0.1, 0.2, 0.3), 0.05, 0.4, orientation=turn),
        "egg": EllipsoidSurface("base", (0.0, 0.1, 0.0), (0.1, 0.2, 0.3)),
        "ring": TorusSurface("base", (0.0, 0.0, 0.0), 0.04, 0.06, orientation=turn),
        "unused": SphereSurface("base", (0.0, 0.0, 0.0), 0.05),
    }
    character.muscles["flexor"].wraps = [Wrap("roll"), Wrap("egg"), Wrap("ring")]
    roll, egg, *ring = surface_pieces(character, ["flexor"], ["base", "tip"])
    assert (roll.flat, roll.body, type(egg).__name__, egg.body) == (True, 1, "Ellipsoid", 0)
    assert {piece.layer for piece in (roll, egg, *ring)} == {"surface"}
    assert roll.radii == (0.05, 0.05)
    np.testing.assert_allclose(np.abs(roll.end - roll.start), [0.4, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose((roll.start + roll.end) / 2.0, [0.1, 0.2, 0.3], atol=1e-9)
    np.testing.assert_allclose(egg.radii, [0.1, 0.2, 0.3])
    places = np.array([piece.start for piece in ring])
    np.testing.assert_allclose(places[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), 0.05, rtol=0.01)
    assert {round(piece.radii[0], 9) for piece in ring} == {0.01}


def test_points_of_routes_are_told_in_the_body_that_carries_them(track: Track):
    recording, points = track.recording, track.routes.all()
    turns = normalized(recording.body_orientation)
    bodies, places = in_bodies(points, recording.body_position, turns)
    back = recording.body_position[:, bodies] + rotate(turns[:, bodies], places)
    np.testing.assert_allclose(back, points, atol=1e-6)
    carried = [recording.body_names[number] for number in bodies[: len(bodies) // len(SURFACES)]]
    assert carried[:1] + carried[-1:] == ["base", arm().character.muscles["flexor"].path[-1].body]
    assert np.ptp(places[:, -1], axis=0).max() < 1e-6 < np.ptp(points[:, -1], axis=0).max()  # which stays in its body
    assert np.abs(np.diff(places, axis=0)).sum() < np.abs(np.diff(points, axis=0)).sum()
