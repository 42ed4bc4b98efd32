"""Torques shared out by least effort, against bounded least squares in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled, matrix, vectors
from scipy.optimize import lsq_linear

from muscle_arm import INERTIA, MASS, REACH, arm, muscle
from random_states import random_states
from warpmuscle.kernels.curve.curves import LEE
from warpmuscle.kernels.muscle import muscle as law
from warpmuscle.kernels.muscle import muscle_strength, sharing, sharing_rules
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import Model, MuscleRow, MuscleState, State
from warpmuscle.scene import Actuation, Body, Character, Failure, InitialState, Joint, MuscleModel, Scene
from warpmuscle.scene.masses import muscle_mass
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.synergy.static_optimization import static_optimization

ZERO, X = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
AXES = {"hinge": [X], "universal": [X, (0.3, 0.2, 1.0)], "ball": [X, (0.0, 1.0, 0.0)], "slide": [(0.6, 0.2, -0.7)]}
AROUND = np.arange(8) * np.pi / 4.0


def limb(kind: str = "ball", drive: Any = "muscle", bent: float = 0.0, **model: Any) -> Scene:
    """A thigh on a joint with eight muscles around it, a shank with two at the knee, and two muscles over both joints.

    Args:
        kind: of the hip. drive: what drives it. bent: m, that muscles over both joints run to the left of the joints.
    """
    bodies = {name: Body(MASS, INERTIA) for name in ("pelvis", "thigh", "shank")}
    joints = {
        "hip": Joint(kind, "pelvis", "thigh", (0.0, -0.05, 0.0), (0.0, REACH, 0.0), AXES[kind]),
        "knee": Joint("hinge", "thigh", "shank", (0.0, -REACH, 0.0), (0.0, REACH, 0.0), [X]),
    }
    short: dict[str, Any] = {"l_opt": 0.11, "l_slack": 0.05}
    muscles = {}
    for i, angle in enumerate(AROUND):
        x, z, twist = np.cos(angle), np.sin(angle), 0.03 * (-1) ** i
        far = (0.05 * x + twist * z, 0.09, 0.05 * z - twist * x)
        strength = {"f_max": 400.0 + 150.0 * i}
        muscles[f"hip{i}"] = muscle(("pelvis", (0.07 * x, 0.01, 0.07 * z)), ("thigh", far), **short, **strength)
    for name, z in (("front", 0.05), ("back", -0.05)):
        ends = ("thigh", (0.01, -0.07, z)), ("shank", (0.0, 0.15, 0.8 * z))
        muscles[f"knee_{name}"] = muscle(*ends, f_max=900.0, **short)
        ends = ("pelvis", (bent, 0.0, 1.3 * z)), ("shank", (bent, 0.15, 0.9 * z))
        muscles[f"both_{name}"] = muscle(*ends, f_max=1000.0, l_opt=0.11, l_slack=0.39)
    scene = Scene(
        "limb", Character("pelvis", bodies, joints, "fixed", muscles), initial_state=InitialState((0.0, 1.0, 0.0)),
        failure=Failure(0.0, 0.0), muscle_model=MuscleModel(sharing="least_effort", **model),
    )  # fmt: skip
    scene.actuation = {"hip": Actuation(drive)}
    return scene


class Posed:
    """A scene in random states, and what its muscles can do there, in float64."""

    def __init__(self, scene: Scene, count: int = 60, speed: float = 1.0, spread: float = 0.3) -> None:
        self.scene, self.count = scene, count
        self.stages, states = Stages(scene, count, "cpu"), random_states(scene.character, count, 0, speed)
        fields = {name: getattr(states, name) for name in type(states).__dataclass_fields__}
        fields["joint_orientation"][..., :3] *= spread  # muscles would be slack far from where a limb hangs
        given: dict[str, Any] = {}
        if scene.character.joints["hip"].type == "slide":
            rng = np.random.default_rng(1)
            given = {
                "joint_coordinate": rng.normal(size=(count, 2)) * 0.01,
                "joint_speed": rng.normal(size=(count, 2)) * 0.1,
            }
        self.stages.set_state(**fields, **given)
        paths = self.stages.muscle_paths()
        muscles = list(scene.character.muscles.values())
        self.crossings = list(zip(paths.muscle, paths.joint, strict=True))
        self.mass = np.array([muscle_mass(own, scene.muscle_model.specific_tension) for own in muscles], float)
        f_max, l_opt, slack = (
            np.array([getattr(own, k) for own in muscles], float) for k in ("f_max", "l_opt", "l_slack")
        )
        length = np.maximum(paths.length.astype(float) - slack, 0.05 * l_opt) / l_opt
        fast = paths.speed.astype(float) / (10.0 * l_opt)
        half, full = (
            f_max * evaluate(law.fibre_force, LEE, a, length.ravel(), fast.ravel(), 0.1).reshape(length.shape)
            for a in (0.5, 1.0)
        )
        passive = 2.0 * half - full
        self.passive, lost = np.maximum(passive, 0.0), np.maximum(-passive, 0.0)
        self.active = np.maximum(full - self.passive, muscle_strength.WEAKEST * f_max)
        self.idle = lost / (self.active + lost)
        self.arm = np.einsum("ncij,ncj->nci", self._parts()[:, paths.joint], paths.moment_arm.astype(float))

    def _parts(self) -> np.ndarray:
        """Projectors on what muscles drive, by joint."""
        frames = matrix(self.stages.forward_kinematics()["orientation"].astype(float))
        parts = np.zeros((self.count, 2, 3, 3))
        for j, (name, joint) in enumerate(self.scene.character.joints.items()):
            parent, child = frames[:, j], frames[:, j + 1]
            words = self.scene.actuation[name].drive if name in self.scene.actuation else "muscle"
            axes = np.array([np.array(axis) / np.linalg.norm(axis) for axis in joint.axes])
            along = {"ball": child, "universal": np.stack([child @ axes[0], parent @ axes[-1]], axis=-1)}
            spanned = along.get(joint.type, (child @ axes[0])[..., None])
            if not isinstance(words, str):
                spanned = spanned[..., [word == "muscle" for word in words]]
            parts[:, j] = spanned @ np.linalg.pinv(spanned)
        return parts

    def gains(self, i: int) -> np.ndarray:
        """Torque at full activation, (6, muscles)."""
        gain = np.zeros((6, len(self.mass)))
        for (m, j), r in zip(self.crossings, self.arm[i], strict=True):
            gain[3 * j : 3 * j + 3, m] += r * self.active[i, m]
        return gain

    def passive_torque(self, i: int) -> np.ndarray:
        return self.gains(i) @ (self.passive[i] / self.active[i])

    def reachable(self, most: float, seed: int = 3) -> np.ndarray:
        """Torques (n, 2, 3) that some activations make, and as much again across what muscles drive."""
        a = np.random.default_rng(seed).uniform(0.0, most, (self.count, len(self.mass)))
        made = np.array([self.gains(i) @ a[i] + self.passive_torque(i) for i in range(self.count)])
        other = np.eye(3) - self._parts()
        return (
            made.reshape(-1, 2, 3) + np.einsum("njab,njb->nja", other, vectors(2 * self.count).reshape(-1, 2, 3)) * 20.0
        )

    def best(self, i: int, torque: np.ndarray) -> np.ndarray:
        """Parts of their active forces that the muscles should have, by bounded least squares."""
        gain = self.gains(i) / np.sqrt(self.mass)
        soft = sharing.SOFTNESS * np.repeat((gain.reshape(2, 3, -1) ** 2).sum(axis=(1, 2)), 3) + 1e-12
        lack = np.einsum("jab,jb->ja", self._parts()[i], torque[i]).ravel() - self.passive_torque(i)
        rows = np.vstack([gain / np.sqrt(soft)[:, None], np.eye(len(self.mass))])
        target = np.concatenate([lack / np.sqrt(soft), np.zeros(len(self.mass))])
        return lsq_linear(rows, target, (0.0, np.sqrt(self.mass)), "bvls", 1e-14).x / np.sqrt(self.mass)

    def shared(self, torque: np.ndarray, calls: int) -> np.ndarray:
        """Parts of their active forces after so many steps that ask for the same."""
        for _ in range(calls):
            excitation = self.stages.muscle_torques(torque)[1]["muscle_excitation"].astype(float)
        lifted = sharing_rules.NEAR * (1.0 - self.idle) + self.idle
        part = (excitation - self.idle) / (1.0 - self.idle)
        return np.where(excitation < lifted, excitation * sharing_rules.NEAR / lifted, part)

    def errors(self, parts: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Torque that is missing, over that wanted of the muscles, (n,)."""
        missing, wanted = [], []
        for i in range(self.count):
            lack = np.einsum("jab,jb->ja", self._parts()[i], torque[i]).ravel() - self.passive_torque(i)
            missing.append(np.linalg.norm(lack - self.gains(i) @ parts[i]))
            wanted.append(np.linalg.norm(lack))
        return np.array(missing) / np.array(wanted)


# One muscle, one joint.


def test_share_is_within_bounds_and_says_by_its_sign_whether_the_muscle_is_free():
    bid, most = np.array([-9.0, -0.01, 0.3, 1.99, 2.01, 9.0]), 2.0
    share = evaluate(sharing_rules.share_of, bid, most)
    np.testing.assert_allclose(np.abs(share), np.clip(bid, 0.0, most), atol=1e-6)
    np.testing.assert_array_equal(share > 0.0, [False, True, True, True, True, False])


def test_strength_is_the_line_through_the_forces_and_a_fast_fibre_pulls_from_some_activation_on():
    passive, active, idle = evaluate(
        muscle_strength.strength_of, [70.0, 20.0, 70.0], [120.0, 60.0, 120.0], [0.0, 0.0, 0.1], 100.0
    ).T
    np.testing.assert_allclose(passive, [20.0, 0.0, 30.0], atol=1e-4)
    np.testing.assert_allclose(active, [100.0, 60.0, 90.0], atol=1e-4)
    np.testing.assert_allclose(idle, [0.0, 0.25, 0.1], atol=1e-6)  # 80 a - 20
    part = np.linspace(0.0, 1.0, 11)
    activation = evaluate(sharing_rules.activation_of, part, 0.25)
    np.testing.assert_allclose(80.0 * activation[1:] - 20.0, 60.0 * part[1:], atol=1e-4)
    assert activation[0] == 0.0


@wp.kernel(enable_backward=False)
def stretch(row: MuscleRow, model: Model, state: State, result: wp.array[PathState]):
    i = wp.tid()
    path = PathState()
    path.fixed = 0.03
    path.moving = 0.2
    path.speed = -0.7
    result[i] = muscle_strength.as_stretched(i, 0, path, row, model, state)


def test_a_fibre_on_a_compliant_tendon_has_the_stretch_that_gives_it_its_length_and_speed():
    """Of the moving part: sqrt(l^2 - w^2) + l_slack - fixed; the speed of the fibre over the cosine of pennation."""
    fibre, before, width, step = np.array([0.1, 0.08, 0.0]), np.array([0.0995, 0.081, 0.0]), 0.04, 0.001
    muscles = filled(MuscleState, fibre_length=fibre[:, None], previous_fibre_length=before[:, None])
    result, row = wp.zeros(3, dtype=PathState, device="cpu"), filled(MuscleRow, width=width, l_slack=0.15)
    wp.launch(stretch, 3, [row, filled(Model, time_step=step), filled(State, muscles=muscles), result], device="cpu")
    found, along = result.numpy(), np.sqrt(fibre[:2] ** 2 - width**2)
    np.testing.assert_allclose(found["moving"], [*along + 0.15 - 0.03, 0.2], atol=1e-6)  # the last has not begun
    np.testing.assert_allclose(found["speed"], [*(fibre - before)[:2] / step * fibre[:2] / along, -0.7], rtol=1e-4)


def test_solution_is_exact_though_a_hinge_makes_the_matrix_nearly_singular():
    axis = vectors(100) / np.linalg.norm(vectors(100), axis=1, keepdims=True)
    full = 1e4 * axis[:, :, None] * axis[:, None] + 10.0 * np.eye(3)
    six = full.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]]
    residual = axis * 30.0
    got = evaluate(sharing_rules.symmetric_solution, six, residual)
    np.testing.assert_allclose(got, np.linalg.solve(full, residual[..., None])[..., 0], rtol=2e-3, atol=1e-6)


# All muscles.

KINDS = {
    "ball": ("ball", "muscle"),
    "universal": ("universal", "muscle"),
    "hinge": ("hinge", "muscle"),
    "slide": ("slide", "muscle"),
    "one axis of a ball": ("ball", ["muscle", "torque", "torque"]),
    "one axis of a universal joint": ("universal", ["torque", "muscle"]),
}


@pytest.mark.parametrize(("kind", "drive"), KINDS.values(), ids=KINDS)
def test_muscles_share_as_bounded_least_squares_says_and_few_sweeps_come_near(kind: str, drive: Any):
    posed = Posed(limb(kind, drive))
    torque = posed.reachable(0.5)
    best = np.array([posed.best(i, torque) for i in range(posed.count)])
    assert np.median(posed.errors(best, torque)) < 0.01
    first = posed.shared(torque, 1)
    assert np.median(posed.errors(first, torque)) < 0.1  # of a cold start
    settled = posed.shared(torque, 30)
    np.testing.assert_allclose(settled, best, atol=0.01)
    assert np.abs(posed.errors(settled, torque) - posed.errors(best, torque)).max() < 0.01
    both = [m for m, name in enumerate(posed.scene.character.muscles) if name.startswith("both")]
    assert settled[:, both].max() > 0.2


def test_the_speed_of_a_path_is_kept_from_the_sharing_to_the_force():
    posed = Posed(limb())
    posed.shared(posed.reachable(0.4), 1)
    kept, paths = posed.stages.state.muscles.sharing.muscle.numpy(), posed.stages.muscle_paths()
    assert np.abs(paths.speed).max() > 0.05
    np.testing.assert_allclose(kept["speed"], paths.speed, atol=1e-6)


def test_torque_that_follows_a_movement_is_met_within_two_percent():
    """As from step to step of a walk, where wanted torques change by some percent."""
    posed = Posed(limb())
    start, change = posed.reachable(0.4), posed.reachable(0.4, seed=4)
    posed.shared(start, 5)
    errors = []
    for step in range(1, 30):
        torque = start + (change - start) * step / 30.0
        errors.append(posed.errors(posed.shared(torque, 1), torque))
    assert np.sqrt(np.mean(np.square(errors))) < 0.02


def test_static_optimisation_of_a_held_posture_comes_out_where_all_muscles_weigh_the_same():
    scene = limb()
    for own in scene.character.muscles.values():
        own.specific_tension = 6.0e5 * own.f_max * own.l_opt / 100.0
    posed = Posed(scene, speed=0.0)
    posed.mass[:] = muscle_mass(own, own.specific_tension)
    torque = posed.reachable(0.3)
    got = posed.shared(torque, 30)
    for i in range(posed.count):
        moments = np.zeros((6, len(posed.mass)))
        for (m, j), r in zip(posed.crossings, posed.arm[i], strict=True):
            moments[3 * j : 3 * j + 3, m] += r
        wanted = np.einsum("jab,jb->ja", posed._parts()[i], torque[i]).reshape(1, 6)
        rows = static_optimization(wanted, moments[None], posed.active[i : i + 1], posed.passive[i : i + 1])
        np.testing.assert_allclose(got[i], rows.activation[0], atol=0.03)


def test_muscle_over_two_joints_works_where_both_want_it_and_rests_where_they_disagree():
    posed = Posed(limb("hinge"), 1, speed=0.0, spread=0.0)
    names = list(posed.scene.character.muscles)
    back, hips, knee = names.index("both_back"), slice(0, 8), names.index("knee_back")
    gain = posed.gains(0)
    passive = posed.passive_torque(0).reshape(1, 2, 3)
    agree = passive + (gain[:, back] * 0.4).reshape(1, 2, 3)
    disagree = agree.copy()
    disagree[:, 0] = passive[:, 0] - (agree - passive)[:, 0]
    together, apart = posed.shared(agree, 20)[0], posed.shared(disagree, 20)[0]
    assert together[back] > 0.1
    assert together[back] > together[knee]
    assert apart[back] < 0.5 * together[back]
    assert apart[hips].max() > 0.05


def test_torque_beyond_all_muscles_is_forgotten_as_soon_as_it_is_gone():
    posed = Posed(limb())
    torque = posed.reachable(0.3)
    far = posed.shared(torque * 50.0, 40)
    assert far.max() > 0.99
    back = posed.shared(torque, 6)
    assert np.median(posed.errors(back, torque)) < 0.02


def test_ideal_muscles_share_too():
    posed = Posed(limb(ideal=True))
    passive, posed.passive = posed.passive, np.zeros_like(posed.passive)
    posed.active[:] = [own.f_max for own in posed.scene.character.muscles.values()]
    posed.idle[:] = 0.0
    assert passive.shape == posed.active.shape
    torque = posed.reachable(0.4)
    got = posed.shared(torque, 30)
    np.testing.assert_allclose(got, [posed.best(i, torque) for i in range(posed.count)], atol=0.01)


# In the fused step.


@pytest.mark.parametrize("tendon", ["rigid", "switch", "compliant"])
def test_joint_held_against_gravity_gets_the_torque_that_is_wanted(tendon: str):
    """One muscle on each side of a hinge, ideal control: what the extensor need not do the flexor does not undo."""
    scene = arm(muscle_model=MuscleModel(sharing="least_effort", tendon=tendon))
    scene.duration = 0.2
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.step(300, torques=np.array([[2.0]]))
    motion = rollout.recording()
    force = motion.muscle_force[200:300]
    assert np.isfinite(force).all()
    assert force.max() > 20.0
    assert (motion.muscle_excitation[200:300].min(axis=1) < 0.02).all()


@pytest.mark.parametrize("implicit", [False, True], ids=["at hand", "in the state"])
@pytest.mark.parametrize(
    "around", [{"count": 5, "slot": 2, "threads": 1}, {"count": 40, "slot": 39, "threads": 2}], ids=str
)
def test_shared_torques_give_the_same_bits_whatever_is_around(implicit: bool, around: dict[str, int]):
    def moved(count: int = 1, slot: int = 0, threads: int = 1, pieces: int = 1) -> np.ndarray:
        scene = limb("universal", ["muscle", "muscle"], implicit_damping=implicit, tendon="rigid")
        scene.duration = 0.1
        rollout = Rollout(scene, count, "cpu", threads=threads)
        speeds = np.random.default_rng(count).normal(size=(count, len(rollout.speed_names)))
        speeds[slot] = [0.5, -0.3, 0.7]
        rollout.set_initial(speeds=speeds)
        torques = np.tile([4.0, -3.0, 2.0], (count, 1))
        for _ in range(pieces):
            rollout.step(100 // pieces, torques=torques)
        return np.concatenate([rollout.state.coordinates.numpy()[slot], rollout.state.muscles.activation.numpy()[slot]])

    alone = moved()
    assert np.ptp(alone[-12:]) > 0.05
    np.testing.assert_array_equal(moved(**around), alone)
    np.testing.assert_array_equal(moved(pieces=4), alone)
