"""Stages by themselves: the energy that masses, speeds and torques must have, for every kind of root and joint."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from probes import filled, matrix

from muscle_arm import arm, constant
from warpmuscle.kernels.body.speed_axes import speed_rate_of
from warpmuscle.kernels.structs import ROOT_FIXED, ROOT_FREE, ROOT_PLANAR, Model, Scratch, Skeleton
from warpmuscle.scene import Body, Box, Character, Failure, Ground, InitialState, Joint, Scene
from warpmuscle.simulation.stages import Stages

ROOT = Path(__file__).parents[2]
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
AXES = {"universal": [X, (0.3, 0.2, 1.0)], "hinge": [(0.2, 1.0, 0.1)], "ball": [X, Y], "slide": [(0.5, -0.3, 1.0)]}
COUNT, G = 12, 9.8


def chain(root: str) -> Scene:
    """Five bodies, each on a joint of another kind, two of them on the same body."""
    parents = {"universal": "root", "hinge": "universal", "ball": "universal", "slide": "ball"}
    bodies = {"root": Body(3.0, (0.1, 0.2, 0.15))}
    joints = {}
    for k, (kind, parent) in enumerate(parents.items()):
        bodies[kind] = Body(1.0 + 0.3 * k, (0.02, 0.03 + 0.01 * k, 0.025))
        joints[kind] = Joint(kind, parent, kind, (0.05, -0.2, 0.02 * k), (-0.01, 0.15, 0.03), AXES[kind])
    failure = Failure(com_height=0.0, heading=0.0, max_com_speed=1000.0)
    return Scene("chain", Character("root", bodies, joints, root), ground=Ground(stiffness=0.0), failure=failure)


def test_lanes_that_share_a_loop_begin_each_at_its_own_place():
    """A processor has one lane, whose number is 0: there a loop that all lanes begin at one place looks right."""
    loops = 0
    for path in (ROOT / "warpmuscle/kernels").rglob("*.py"):
        assert "lanes, lane," not in path.read_text(), path
        for node in ast.walk(ast.parse(path.read_bytes())):
            if not isinstance(node, ast.For) or not (
                of := re.fullmatch(r"range\((.+), .+, lanes\)", ast.unparse(node.iter))
            ):
                continue
            loops += 1
            groups = f"{ast.unparse(node.target)} + lane" in ast.unparse(node)  # all begin at a group's first
            assert re.search(r"\blane\b", of[1]) or groups, f"{path}:{node.lineno}"
    assert loops > 50


def test_contacts_have_the_inertia_by_which_springs_and_dampers_give_way_within_a_step():
    """Of a box that lies flat: four corners, each h (d + h k) upwards and h d_t across, moved to the joint."""
    k, d, across, half, depth = 1e5, 1e3, 1e4, 0.1, 1e-3
    body = Body(5.0, (0.05, 0.05, 0.05), [Box((-half,) * 3, (half,) * 3)], friction=0.5)
    ground = Ground(stiffness=k, damping=d, tangential_damping=across)
    start = InitialState((0.0, half - depth, 0.0))
    scene = Scene("box", Character("box", {"box": body}), initial_state=start, ground=ground, failure=Failure(0.0, 0.0))
    contacts, h = Stages(scene, 1, "cpu").contacts(), scene.time_step
    one = h * np.diag([across, d + h * k, across])
    corners = half * np.array([[x, -1.0, z] for x in (-1.0, 1.0) for z in (-1.0, 1.0)])
    arms = np.array([[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]] for x, y, z in corners])
    np.testing.assert_allclose(contacts.force[0, 0], [0.0, 4.0 * k * depth, 0.0], rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(contacts.c[0, 0], 4.0 * one, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(contacts.b[0, 0], (arms @ one).sum(axis=0), rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(contacts.a[0, 0], (arms @ one @ arms.swapaxes(1, 2)).sum(axis=0), rtol=1e-4, atol=1e-4)


@wp.kernel(enable_backward=False)
def rates(model: Model, work: Scratch, rate: wp.array2d[float]):
    body, k = wp.tid()
    its = work
    rate[body, k] = speed_rate_of(body, k, model, its)


@pytest.mark.parametrize(
    ("root", "expected"),
    [(ROOT_FREE, [1.0, 2.0, 3.0, 10.0, 20.0, 30.0]), (ROOT_PLANAR, [2.0, 3.0, 10.0]), (ROOT_FIXED, [])],
)
def test_speeds_of_the_root_are_along_world_axes_and_of_a_planar_one_y_z_and_about_x(root: int, expected: list[float]):
    model = filled(Model, body_count=2, skeleton=filled(Skeleton, plan={"joint_type": [root, 3]}))
    given = {
        "acceleration": [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
        "angular_acceleration": [[10.0, 20.0, 30.0], [40.0, 50.0, 60.0]],
        "factor_c": [[7.0, 7.0, 7.0], [-1.0, -2.0, -3.0]],
    }  # fmt: skip
    rate = wp.zeros((2, 6), dtype=float, device="cpu")
    work = filled(Scratch, **{name: np.float32(value) for name, value in given.items()})
    wp.launch(rates, (2, len(expected)), [model, work, rate], device="cpu")
    np.testing.assert_array_equal(rate.numpy()[0, : len(expected)], expected)
    if expected:
        np.testing.assert_array_equal(rate.numpy()[1, :3], [-1.0, -2.0, -3.0])


@pytest.fixture(scope="module", params=["free", "planar", "fixed"])
def moving(request: pytest.FixtureRequest) -> Stages:
    """The chain in random states."""
    stages, rng = Stages(chain(request.param), COUNT, "cpu"), np.random.default_rng(3)

    def turned(*shape: int) -> np.ndarray:
        return rng.normal(size=(COUNT, *shape, 4)) * 0.5 + [0.0, 0.0, 0.0, 1.0]

    names = stages.names.joints
    q, v = 0.2 * rng.normal(size=(COUNT, len(names))), rng.normal(size=(COUNT, len(names)))
    root = turned() if request.param == "free" else np.array([[0.3, 0.0, 0.0, 1.0]]) * np.ones((COUNT, 1))
    stages.set_state(
        rng.normal(size=(COUNT, 3)), root, rng.normal(size=(COUNT, 3)), 2.0 * rng.normal(size=(COUNT, 3)),
        turned(len(names)), 2.0 * rng.normal(size=(COUNT, len(names), 3)), joint_coordinate=q, joint_speed=v,
    )  # fmt: skip
    return stages


def masses(stages: Stages) -> tuple[np.ndarray, np.ndarray]:
    """Masses (B,), and tensors of inertia in the world (n, B, 3, 3)."""
    bodies = [stages.scene.character.bodies[name] for name in stages.names.bodies]
    frames = matrix(stages.forward_kinematics()["orientation"].astype(float))
    principal = np.array([one.inertia for one in bodies])
    return np.array([one.mass for one in bodies]), frames * principal[:, None] @ frames.swapaxes(-1, -2)


def test_the_mass_matrix_gives_the_kinetic_energy_of_the_bodies(moving: Stages):
    mass, inertia = masses(moving)
    now, own = moving.forward_kinematics(), moving.state.speeds.numpy().astype(float)
    v, w = now["velocity"].astype(float), now["angular_velocity"].astype(float)
    energy = 0.5 * np.einsum("b,nbi,nbi->n", mass, v, v) + 0.5 * np.einsum("nbi,nbij,nbj->n", w, inertia, w)
    full = moving.mass_matrix().astype(float)
    np.testing.assert_allclose(0.5 * np.einsum("ni,nij,nj->n", own, full, own), energy, rtol=2e-5)
    np.testing.assert_allclose(full, full.swapaxes(1, 2), atol=1e-6)


def test_the_power_of_gravity_and_torques_is_the_rate_of_the_kinetic_energy(moving: Stages):
    """Sum of m a.v + w.(I w' + w x I w) over the bodies; a torque t on the parent has the power -t.(w - w_parent)."""
    mass, inertia = masses(moving)
    names = moving.names
    torque = 5.0 * np.random.default_rng(4).normal(size=(COUNT, len(names.joints), 3))
    slides = [moving.scene.character.joints[name].type == "slide" for name in names.joints]
    torque[:, slides] = 0.0  # there it stands for a force
    now, then = moving.forward_kinematics(), moving.forward_dynamics(torque)
    v, w = now["velocity"].astype(float), now["angular_velocity"].astype(float)
    a, alpha = then["acceleration"].astype(float), then["angular_acceleration"].astype(float)
    spin = np.einsum("nbij,nbj->nbi", inertia, w)
    moment = np.einsum("nbij,nbj->nbi", inertia, alpha) + np.cross(w, spin)
    gained = np.einsum("b,nbi,nbi->n", mass, a, v) + np.sum(w * moment, axis=(1, 2))
    power = -G * np.einsum("b,nb->n", mass, v[..., 1])
    power -= np.sum(torque * (w[:, 1:] - w[:, np.array(names.parents[1:])]), axis=(1, 2))
    fixed = moving.scene.character.root_joint == "fixed"
    np.testing.assert_allclose(gained, power, rtol=2e-4, atol=5e-3 if not fixed else 3e-3)
    assert np.ptp(power) > 10.0


def test_the_accelerations_of_a_free_chain_change_no_momentum_but_by_gravity():
    stages, rng = Stages(chain("free"), COUNT, "cpu"), np.random.default_rng(5)
    n = len(stages.names.joints)
    shapes = ((3,), (4,), (3,), (3,), (n, 4), (n, 3))
    q, v = rng.normal(size=(2, COUNT, n))
    stages.set_state(*(rng.normal(size=(COUNT, *shape)) for shape in shapes), joint_coordinate=0.1 * q, joint_speed=v)
    mass, inertia = masses(stages)
    now, then = stages.forward_kinematics(), stages.forward_dynamics(3.0 * rng.normal(size=(COUNT, n, 3)))
    place, w = now["position"].astype(float), now["angular_velocity"].astype(float)
    a, alpha = then["acceleration"].astype(float), then["angular_acceleration"].astype(float)
    force = mass[:, None] * (a - [0.0, -G, 0.0])
    moment = np.einsum("nbij,nbj->nbi", inertia, alpha) + np.cross(w, np.einsum("nbij,nbj->nbi", inertia, w))
    scale = np.abs(force).max()
    np.testing.assert_allclose(force.sum(axis=1), 0.0, atol=1e-4 * scale)
    np.testing.assert_allclose((np.cross(place, force) + moment).sum(axis=1), 0.0, atol=3e-4 * scale)


def test_muscles_turn_a_joint_by_their_forces_times_their_moment_arms():
    scene = arm(flexor={"excitation": constant(0.6)})
    stages = Stages(scene, 3, "cpu")
    coordinates = stages.state.coordinates.numpy()
    coordinates[:, 7] = [-0.5, 0.1, 0.8]
    stages.state.coordinates.assign(coordinates)
    paths = stages.muscle_paths()
    for _ in range(5):
        torque, found = stages.muscle_torques(np.zeros((3, 1, 3)))
    assert found["muscle_force"][:, 0].min() > 1.0
    expected = np.einsum("nc,nci->ni", found["muscle_force"][:, list(paths.muscle)], paths.moment_arm)
    np.testing.assert_allclose(torque[:, 0], expected, rtol=1e-4, atol=1e-5)
    assert stages.state.step.numpy().tolist() == [5, 5, 5]
