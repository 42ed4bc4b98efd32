"""Welded and locked bodies as parts of those that carry them: the same inertia, paths and places, with fewer bodies."""

from pathlib import Path

import numpy as np

import osim_models as small
from warpmuscle.formats import load
from warpmuscle.formats.osim.records import Body
from warpmuscle.formats.osim.tree import joined_body
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.stages import Stages

COUNT = 20


def arm(folder: Path) -> Path:
    """An upper arm on a pin, a forearm on another one, which carries a welded hand and on that a locked finger."""
    bodies = (
        small.body("upper", 2.0, center="0 -0.15 0.01", inertia="0.02 0.004 0.02 0 0 0")
        + small.body("fore", 1.0, center="0.01 -0.12 0", inertia="0.01 0.002 0.01 0.001 0 0")
        + small.body("hand", 0.5, center="0.02 -0.05 0.01", inertia="0.001 0.0005 0.0012 0 0.0002 0")
        + small.body("finger", 0.1, center="0 -0.03 0", inertia="0.0001 0.00005 0.0001 0 0 0")
    )
    hold = "<locked>true</locked><default_value>0.4</default_value>"
    joints = (
        small.joint("PinJoint", "shoulder", "ground", "upper", small.coordinate("a"), turn="0.3 0 0")
        + small.joint("PinJoint", "elbow", "upper", "fore", small.coordinate("b"), place="0 -0.3 0", own="0 0.01 0")
        + small.joint(
            "WeldJoint", "wrist", "fore", "hand", place="0.01 -0.25 0.02", turn="0.2 -0.1 0.3", own="0 0.02 0.01",
            own_turn="-0.1 0.2 0.1",
        )
        + small.joint("PinJoint", "knuckle", "hand", "finger", small.coordinate("c", hold), place="0 -0.09 0")
    )  # fmt: skip
    points = (
        small.point("p", "upper", "0.02 -0.1 0") + small.point("q", "fore", "0.03 -0.1 0.01")
        + small.point("r", "hand", "0.02 -0.03 0.02") + small.point("s", "finger", "0.01 -0.04 0")
    )  # fmt: skip
    marker = (
        '<MarkerSet><objects><Marker name="tip"><socket_parent_frame>/bodyset/finger</socket_parent_frame>'
        "<location>0.01 -0.06 0.02</location></Marker></objects></MarkerSet>"
    )
    return small.written(folder, small.model(bodies, joints, small.muscle("m", points), marker))


def both(folder: Path) -> tuple[Scene, Scene]:
    path = arm(folder)
    return load(path, ignored=[]), load(path, ignored=[], merge_welds=True)


def test_inertia_gravity_paths_and_markers_are_those_of_the_bodies_apart(tmp_path: Path):
    apart, merged = both(tmp_path)
    assert [len(topology(scene.character).bodies) for scene in (apart, merged)] == [5, 3]
    assert list(merged.character.joints) == ["a", "b"]
    angles = np.random.default_rng(1).uniform(-1.5, 1.5, (COUNT, 2))
    found = []
    for scene in (apart, merged):
        stages = Stages(scene, COUNT, "cpu")
        q, speeds = stages.state.coordinates.numpy(), stages.state.speeds.numpy()
        q[:, -2:], speeds[:, -2:] = angles, 2.0
        stages.state.coordinates.assign(q)
        stages.state.speeds.assign(speeds)
        paths, places = stages.muscle_paths(), stages.forward_kinematics()
        marker = scene.opensim.markers["tip"]
        body = topology(scene.character).bodies.index(marker.body)
        turn = places["orientation"][:, body]
        tip = places["position"][:, body] + rotated(turn, np.array(marker.position))
        acceleration = stages.forward_dynamics(0.0)
        found.append(
            (stages.mass_matrix()[:, -2:, -2:], paths.length, paths.speed, tip, acceleration["speed_rate"][:, -2:])
        )
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(other, one, rtol=2e-5, atol=2e-6)


def rotated(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A vector turned by quaternions (n, 4)."""
    across = 2.0 * np.cross(q[:, :3], v)
    return np.asarray(v + q[:, 3:] * across + np.cross(q[:, :3], across))


def test_a_joined_body_has_the_kinetic_energy_of_both():
    rng = np.random.default_rng(2)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes *= np.sign(np.linalg.det(axes))
    place = rng.normal(size=3)
    one, other = (
        Body("/bodyset/b", "b", 1, float(rng.uniform(0.1, 2.0)), rng.normal(size=3), np.diag(rng.uniform(1, 2, 3)))
        for _ in range(2)
    )
    joined = joined_body(one, other, axes, place)
    spin, speed = rng.normal(size=3), rng.normal(size=3)

    def energy(body: Body, turn: np.ndarray, at: np.ndarray) -> float:
        v = speed + np.cross(spin, at + turn @ body.center)
        return float(0.5 * body.mass * v @ v + 0.5 * spin @ turn @ body.inertia @ turn.T @ spin)

    assert joined.mass == one.mass + other.mass
    expected = energy(one, np.eye(3), np.zeros(3)) + energy(other, axes, place)
    np.testing.assert_allclose(energy(joined, np.eye(3), np.zeros(3)), expected, rtol=1e-12)


def test_a_body_welded_to_the_ground_stays(tmp_path: Path):
    bodies = small.body("base", 1.0) + small.body("rod", 1.0, center="0 -0.5 0")
    joints = small.joint("WeldJoint", "fixed", "ground", "base") + small.joint(
        "PinJoint", "pin", "base", "rod", small.coordinate("q")
    )
    path = small.written(tmp_path, small.model(bodies, joints))
    assert set(load(path, ignored=[], merge_welds=True).character.bodies) >= {"base", "rod"}
