"""What drives the joints: projectors by definition, sources by degree of freedom, passive joints as oscillators."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled, matrix, turn_about, units, vectors

from muscle_arm import ABOUT_JOINT, MASS, REACH, arm, leg
from random_states import random_states
from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.body.kinematics import kinematics_stage
from warpmuscle.kernels.force import actuation
from warpmuscle.kernels.force.springs import SPRINGS, spring_torque
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.path.path import joint_velocities
from warpmuscle.kernels.stages import work_of
from warpmuscle.kernels.structs import (
    BALL,
    BY_MUSCLES,
    BY_TORQUE,
    HINGE,
    MIXED,
    ROOT_FREE,
    UNIVERSAL,
    Model,
    MuscleState,
    Paths,
    Scratch,
    Skeleton,
    State,
)
from warpmuscle.kernels.structs import Actuation as ActuationArrays
from warpmuscle.scene import Actuation, JointState, Scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

N = 200
WEIGHTS = np.random.default_rng(9).integers(0, 2, (N, 3)).astype(float)


damping_stage = actuation.implicit_damping_stage_of(SPRINGS)


@wp.kernel(enable_backward=False)
def damp(model: Model, state: State, work: Scratch):
    its = work
    damping_stage(0, 0, 1, model, state, its)


@pytest.mark.parametrize("passive", [0.0, 1.0])
def test_muscles_damp_implicitly_what_they_drive_of_a_joint_and_springs_the_rest(passive: float):
    """h' d (P r)(P r)^T by the muscles' dampings and moment arms, and h' d P P^T of springs; h' is a part of a step."""
    step, weights, others = 0.01 * 0.55, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, passive])
    kinds, drives = [ROOT_FREE, BALL, UNIVERSAL, HINGE], [BY_TORQUE, MIXED, MIXED, BY_MUSCLES]
    frames, axis_a, axis_b = matrix(units(4, 1, 4)), units(4, 2), units(4, 3)
    arm_of, damping = vectors(6, 4, 0.05), np.array([300.0, 500.0, 900.0])  # two crossings a joint
    muscle = np.array([0, 1, 1, 2, 0, 2])
    plan = {"joint_type": kinds, "parent": [-1, 0, 1, 2]}
    skeleton = filled(Skeleton, plan=plan, row={"axis_a": axis_a[None], "axis_b": axis_b[None]})
    drive = filled(
        ActuationArrays, drive=drives, by_muscles=np.tile(weights, (4, 1)), passive=np.tile(others, (4, 1)),
        damping=np.full((1, 4), 3.0),
    )  # fmt: skip
    paths = filled(Paths, crossing_start=[0, 0, 2, 4, 6], crossing_muscle=muscle)
    model = filled(Model, body_count=4, time_step=0.01, skeleton=skeleton, actuation=drive, paths=paths)
    state = filled(State, muscles=filled(MuscleState, damping=damping[None], moment_arm=arm_of[None]))
    work = filled(Scratch, rotation=frames, stiffness=np.zeros((4, 6), np.float32))
    wp.launch(damp, 1, [model, state, work], device="cpu")
    a, b = frames[2] @ axis_a[2], frames[1] @ axis_b[2]
    dual = np.linalg.pinv(np.stack([a, b]))  # columns a* and b*
    of_muscles = {1: frames[1] @ np.diag(weights) @ frames[1].T, 2: np.outer(dual[:, 0], a), 3: np.eye(3)}
    of_springs = {
        1: frames[1] @ np.diag(others) @ frames[1].T, 2: np.outer(dual[:, 1], b), 3: np.zeros((3, 3)),
    }  # fmt: skip
    six = work.stiffness.numpy()
    np.testing.assert_array_equal(six[0], 0.0)
    for body, first in ((1, 0), (2, 2), (3, 4)):
        r = arm_of[first : first + 2] @ of_muscles[body].T
        expected = np.einsum("c,ci,cj->ij", damping[muscle[first : first + 2]], r, r)
        expected += 3.0 * of_springs[body] @ of_springs[body].T
        np.testing.assert_allclose(six[body][[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3), step * expected, atol=1e-6)


def powers(torque: np.ndarray, axes: list[np.ndarray]) -> np.ndarray:
    """Generalised forces of torques (n, 3) along axes (n, 3), (n, axes)."""
    return np.stack([np.sum(torque * axis, axis=-1) for axis in axes], axis=-1)


def projected(function: wp.Function, torque: np.ndarray, *values: Any) -> np.ndarray:
    return np.einsum("nij,nj->ni", evaluate(function, *values), torque)


def test_hinge_keeps_what_acts_about_its_axis_and_nothing_else():
    axis, torque = units(N), vectors(N, 1, 100.0)
    got = projected(actuation.hinge_projector, torque, axis, WEIGHTS[:, 0])
    np.testing.assert_allclose(got, WEIGHTS[:, :1] * powers(torque, [axis]) * axis, atol=1e-4)


def test_universal_joint_keeps_what_acts_about_each_axis_though_they_are_not_at_right_angles():
    a, torque = units(N), vectors(N, 2, 100.0)
    b = units(N, 1) * 0.8 + a * 0.4
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    a, b, torque = (v[np.abs(np.sum(a * b, axis=1)) < 0.9] for v in (a, b, torque))
    weights = WEIGHTS[: len(a)]
    got = projected(actuation.universal_projector, torque, a, b, weights)
    np.testing.assert_allclose(powers(got, [a, b]), weights[:, :2] * powers(torque, [a, b]), atol=1e-3)
    np.testing.assert_allclose(powers(got, [np.cross(a, b)]), 0.0, atol=1e-3)


def test_ball_joint_keeps_what_acts_about_the_axes_of_its_child():
    rotation, torque = matrix(units(N, 3, 4)), vectors(N, 4, 100.0)
    axes = list(np.moveaxis(rotation, -1, 0))
    got = projected(actuation.ball_projector, torque, rotation, WEIGHTS)
    np.testing.assert_allclose(powers(got, axes), WEIGHTS * powers(torque, axes), atol=1e-4)


def test_spring_torque_is_that_of_a_spring_damper_on_the_parent():
    error, velocity = vectors(N), vectors(N, 1)
    got = evaluate(spring_torque, error, velocity, 30.0, 2.0)
    np.testing.assert_allclose(got, 2.0 * velocity - 30.0 * error, atol=1e-4)


# Sources of the torque of a joint.


by_muscles = actuation.actuation_stage_of(actuation.muscle_torque, SPRINGS)


@wp.kernel(enable_backward=False)
def driven(
    # in
    model: Model, state: State, workspace: wp.array2d[float], wanted: wp.array2d[wp.vec3], inertia: symmetric,
    # out
    torque: wp.array2d[wp.vec3], stiffness: wp.array2d[symmetric],
):  # fmt: skip
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    joint_velocities(0, 1, model, work)
    for body in range(model.body_count):
        work.torque[body] = wanted[i, body]
        work.stiffness[body] = inertia
    by_muscles(i, 0, 1, model, state, work)
    for body in range(model.body_count):
        torque[i, body] = work.torque[body]
        stiffness[i, body] = work.stiffness[body]


class Sources:
    """The first joint of a scene in random states, with torques from a controller and from muscles."""

    INERTIA = np.array([[0.5, 0.1, 0.05], [0.1, 0.7, -0.1], [0.05, -0.1, 0.6]])  # of the implicit controller

    def __init__(self, scene: Scene, count: int = 50) -> None:
        stages, states = Stages(scene, count, "cpu"), random_states(scene.character, count)
        stages.set_state(*(getattr(states, name) for name in type(states).__dataclass_fields__))
        self.model, state = stages.structs
        crossings = state.muscles.moment_arm.shape[1]
        arms = vectors(count * crossings, 5, 0.05).reshape(count, crossings, 3)
        state.muscles.moment_arm.assign(arms.astype(np.float32))
        force = np.random.default_rng(6).uniform(0.0, 500.0, state.muscles.force.shape)
        state.muscles.force.assign(force.astype(np.float32))
        bodies = len(stages.names.bodies)
        self.wanted = vectors(count * bodies, 7, 30.0).reshape(count, bodies, 3)
        workspace = wp.zeros((count, work_floats(capacity_of(bodies))), dtype=float, device="cpu")
        given = wp.array(self.wanted.astype(np.float32), dtype=wp.vec3, device="cpu")
        outputs = [wp.zeros((count, bodies), dtype=dtype, device="cpu") for dtype in (wp.vec3, symmetric)]
        upper = self.INERTIA[np.triu_indices(3)].tolist()
        wp.launch(driven, count, [*stages.structs, workspace, given, symmetric(*upper)], outputs, device="cpu")
        self.torque, six = (array.numpy()[:, 1].astype(float) for array in outputs)
        self.stiffness = six[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
        self.wanted = self.wanted[:, 1]
        start, of = (getattr(self.model.paths, f"crossing_{name}").numpy() for name in ("start", "muscle"))
        own = range(start[1], start[2])
        self.pulled = sum((arms[:, k] * force[:, of[k], None] for k in own), np.zeros((count, 3)))
        self.axes = self._axes(stages, scene)

    @staticmethod
    def _axes(stages: Stages, scene: Scene) -> list[np.ndarray]:
        """World axes of the joint's degrees of freedom."""
        parent, child = np.moveaxis(matrix(stages.forward_kinematics()["orientation"].astype(float)[:, :2]), 1, 0)
        joint = scene.character.joints[stages.names.joints[0]]
        if joint.type == "ball":
            return list(np.moveaxis(child, -1, 0))
        axes = [np.array(axis) / np.linalg.norm(axis) for axis in joint.axes]
        return [frame @ axis for frame, axis in zip((child, parent), axes, strict=False)]

    def expected(self, words: list[str]) -> np.ndarray:
        """Generalised forces by source."""
        by_torque, by_muscles = powers(self.wanted, self.axes), powers(self.pulled, self.axes)
        choice = {"torque": by_torque, "muscle": by_muscles, "assisted": by_torque + by_muscles, "none": 0 * by_torque}
        return np.stack([choice[word][:, k] for k, word in enumerate(words)], axis=-1)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("hinge", ["assisted"]),
        ("hinge", ["none"]),
        ("universal", ["muscle", "torque"]),
        ("universal", ["none", "muscle"]),
        ("ball", ["muscle", "torque", "torque"]),
        ("ball", ["assisted", "none", "muscle"]),
    ],
    ids=str,
)
def test_each_degree_of_freedom_is_driven_by_its_own_source(kind: str, words: list[str]):
    sources = Sources(arm(kind, actuation={"elbow": Actuation(words)}))
    np.testing.assert_allclose(powers(sources.torque, sources.axes), sources.expected(words), atol=2e-3)


@pytest.mark.parametrize(("word", "source"), [("torque", "wanted"), ("muscle", "pulled")])
def test_joint_with_one_source_gets_its_torque_as_it_is(word: str, source: str):
    sources = Sources(arm("universal", actuation={"elbow": Actuation(word)}))
    np.testing.assert_allclose(sources.torque, getattr(sources, source), atol=1e-4)


def test_joint_without_a_word_is_driven_by_its_muscles_and_by_torque_if_it_has_none():
    assert np.array_equal(Sources(arm()).torque, Sources(arm(actuation={"elbow": Actuation("muscle")})).torque)
    bare = arm()
    bare.character.muscles = {}
    sources = Sources(bare)
    np.testing.assert_allclose(sources.torque, sources.wanted, atol=1e-5)


def test_undriven_joint_gets_no_torque():
    sources = Sources(arm("ball", actuation={"elbow": Actuation("none")}))
    assert np.all(sources.torque == 0.0)
    assert np.all(sources.stiffness == 0.0)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("ball", ["muscle", "torque", "none"]), ("universal", ["muscle", "torque"]), ("universal", ["torque", "muscle"])],
    ids=str,
)
def test_implicit_controller_is_stiff_about_what_torque_drives_alone(kind: str, words: list[str]):
    sources = Sources(arm(kind, actuation={"elbow": Actuation(words)}, implicit_pd=True))
    axes = np.stack(sources.axes, axis=1)
    got = np.einsum("nai,nij,nbj->nab", axes, sources.stiffness, axes)
    full = np.einsum("nai,ij,nbj->nab", axes, sources.INERTIA, axes)
    by_torque = np.array([word == "torque" for word in words], dtype=float)
    np.testing.assert_allclose(got, full * by_torque[:, None] * by_torque, atol=1e-4)


def test_joint_that_muscles_drive_is_not_stiff_and_one_that_torque_drives_is_as_the_controller_made_it():
    assert np.all(Sources(arm("ball")).stiffness == 0.0)
    kept = Sources(arm("ball", actuation={"elbow": Actuation("torque")})).stiffness
    np.testing.assert_allclose(kept, np.broadcast_to(Sources.INERTIA, kept.shape), atol=1e-6)


def test_joints_of_a_scene_are_driven_one_by_one():
    """The hip by torque and the knee by its muscles: those that cross the hip pull on the knee alone."""
    sources = Sources(leg(actuation={"hip": Actuation("torque")}))
    np.testing.assert_allclose(sources.torque, sources.wanted, atol=1e-5)


# Passive joints.

STIFFNESS = 25.0  # N m/rad


def oscillation(kind: str, damping: float, angle: float = 0.2, implicit: bool = False, **own: Any) -> np.ndarray:
    """Angles of a passive joint about x, every step from a standing start at an angle, without gravity."""
    turn = turn_about(np.array([1.0, 0.0, 0.0]), np.array(angle))
    scene = arm(kind, actuation={"elbow": Actuation("passive", STIFFNESS, damping, **own)}, gravity=0.0)
    scene.initial_state.joints = {"elbow": JointState(tuple(turn))}
    scene.implicit_pd, scene.duration = implicit, 2.0
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    q = rollout.recording().joint_orientation[:, 0]
    return 2.0 * np.arctan2(q[:, 0], q[:, 3])


def crossings(angle: np.ndarray) -> np.ndarray:
    """Times of zeros, s."""
    before = np.flatnonzero(np.sign(angle[1:]) != np.sign(angle[:-1]))
    return (before + angle[before] / (angle[before] - angle[before + 1])) / 2000.0


@pytest.mark.parametrize("kind", ["hinge", "universal", "ball"])
@pytest.mark.parametrize("implicit", [False, True])
def test_passive_joint_swings_at_the_frequency_of_its_spring(kind: str, implicit: bool):
    zeros = crossings(oscillation(kind, 0.0, implicit=implicit))
    assert len(zeros) > 8
    assert np.pi / np.diff(zeros).mean() == pytest.approx(np.sqrt(STIFFNESS / ABOUT_JOINT), rel=0.01)


@pytest.mark.parametrize("kind", ["hinge", "ball"])
@pytest.mark.parametrize("implicit", [False, True])
def test_damping_makes_a_passive_joint_die_away(kind: str, implicit: bool):
    damping = 0.4
    angle, time = oscillation(kind, damping, implicit=implicit), np.arange(4000) / 2000.0
    decay = damping / (2.0 * ABOUT_JOINT)
    swing = np.sqrt(STIFFNESS / ABOUT_JOINT - decay**2)
    expected = 0.2 * np.exp(-decay * time) * (np.cos(swing * time) + decay / swing * np.sin(swing * time))
    np.testing.assert_allclose(angle, expected, atol=0.2 * 0.02)


@pytest.mark.parametrize("kind", ["hinge", "universal", "ball"])
def test_passive_joint_comes_to_rest_where_its_spring_is_relaxed(kind: str):
    angle = oscillation(kind, 3.0, angle=0.0, rest=(0.4, 0.0, 0.0))
    assert angle[-1] == pytest.approx(0.4, abs=1e-3)


def test_undriven_joint_is_a_free_pendulum():
    """Small swings at the frequency of a physical pendulum."""
    scene = arm(actuation={"elbow": Actuation("none")}, duration=3.0)
    scene.initial_state.joints = {"elbow": JointState((np.sin(0.025), 0.0, 0.0, np.cos(0.025)))}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    q = rollout.recording().joint_orientation[:, 0]
    frequency = np.pi / np.diff(crossings(q[:, 0])).mean()
    assert frequency == pytest.approx(np.sqrt(MASS * 9.8 * REACH / ABOUT_JOINT), rel=0.002)


def test_passive_axes_of_a_joint_hold_while_another_one_swings_freely():
    """A ball joint with springs about y and z only: it swings about x as a pendulum and about nothing else."""
    scene = arm("ball", actuation={"elbow": Actuation(["none", "passive", "passive"], 500.0, 5.0)}, duration=1.0)
    half = 0.3
    scene.initial_state.joints = {"elbow": JointState((np.sin(half), 0.0, 0.0, np.cos(half)), (0.0, 0.5, 0.5))}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    q = rollout.recording().joint_orientation[-1, 0]
    assert rollout.recording().joint_orientation[:, 0, 0].min() < -0.2
    assert np.abs(q[1:3]).max() < 0.02
