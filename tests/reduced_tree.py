"""A character whose joints follow others beside the same one where all move by themselves, in float64."""

import copy

import numpy as np

from warpmuscle.core.pose import rotate
from warpmuscle.scene import Scene, ViaPoint
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics, joint_space


def unfollowed(scene: Scene) -> Scene:
    """The same with coordinates of their own for all joints."""
    free = copy.deepcopy(scene)
    for joint in free.character.joints.values():
        joint.follows = ""
    return free


def reduction(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and speeds of the tree without followers from those with them: matrices of zeros and ones."""
    own, free = topology(scene.character), topology(unfollowed(scene).character)
    q, v = np.zeros((free.coordinates, own.coordinates)), np.zeros((free.speeds, own.speeds))
    for number, name in enumerate(free.bodies):
        body = own.bodies.index(name)
        for matrix, there, here in (
            (q, free.coordinates_of(number), own.coordinates_of(body)),
            (v, free.speeds_of(number), own.speeds_of(body)),
        ):
            matrix[there, here] = np.eye(here.stop - here.start)
    return q, v


def expected(scene: Scene, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix and forces at rest, reduced from those of the tree without followers."""
    free, (of_q, of_v) = unfollowed(scene), reduction(scene)
    full_q, full_v = q @ of_q.T, v @ of_v.T
    bias = inverse_dynamics(free, full_q, full_v, np.zeros_like(full_v)) @ of_v
    return np.einsum("ai,nab,bj->nij", of_v, joint_space(free, full_q).mass_matrix, of_v), bias


def put(scene: Scene, q: np.ndarray, v: np.ndarray) -> Stages:
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    return stages


def recorded(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    assert rollout.status_names() == ("completed",)
    return tuple(rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))


def energy(scene: Scene, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Kinetic and potential energy (2, n), J."""
    kinetic = 0.5 * np.einsum("ni,nij,nj->n", v, joint_space(scene, q).mass_matrix, v)
    joints = {joint.child: joint for joint in scene.character.joints.values()}
    heights = sum(
        body.mass * (place[:, 1] - rotate(turn, np.array(joints[name].position_in_child))[:, 1])
        for name, body in scene.character.bodies.items()
        for place, turn in [body_points(scene, q)[name]]
        if name in joints
    )
    return np.stack([kinetic, scene.gravity * heights])


def lengths(scene: Scene, q: np.ndarray) -> np.ndarray:
    """Lengths (n, M) of paths in float64."""
    poses = body_points(scene, q)
    joints = {joint.child: joint for joint in scene.character.joints.values()}

    def world(point: ViaPoint) -> np.ndarray:
        place, turn = poses[point.body]
        joint = joints.get(point.body)
        return place + rotate(turn, np.array(point.position) - np.array(joint.position_in_child if joint else 0.0))

    paths = [np.stack([world(point) for point in muscle.path]) for muscle in scene.character.muscles.values()]
    return np.stack([np.linalg.norm(np.diff(path, axis=0), axis=2).sum(axis=0) for path in paths], axis=1)


def check_energy_stays(scene: Scene) -> None:
    """Hold a scene that swings freely to its energy at the start, while what moves and what is high exchange it."""
    q, v = (part[::20] for part in recorded(scene))
    both = energy(scene, q, v)
    total = both.sum(axis=0)
    assert np.ptp(both[0]) > 5.0
    np.testing.assert_allclose(total, total[0], atol=2e-3 * np.ptp(both[0]))
