"""Constraints that close loops: accelerations against M a = J^T x - b in float64, drift and energy of free runs."""

import copy

import numpy as np
import pytest

from reduced_tree import energy
from warpmuscle.core.pose import about, conjugate, multiply, normalized, rotate
from warpmuscle.kernels.constraint.constraints import DAMPING, STIFFNESS
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    Constraint,
    Displacement,
    Failure,
    Ground,
    Joint,
    JointState,
    Motion,
    Scene,
)
from warpmuscle.scene.constraints.pose import (
    bodies_at,
    constraint_errors,
    meeting_speeds,
    nearest_pose,
    start_coordinates,
)
from warpmuscle.scene.topology import Topology, topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics, joint_space

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
CURVE = Displacement((0.2, 0.9, -0.3), x=[-2.0, -1.0, 0.0, 1.0, 2.0], y=[-0.3, 0.1, 0.2, -0.1, 0.4])
SHIFT = Displacement(Y, polynomial=[0.01, -0.03, 0.02, 0.0, 0.01])
SMALL = 1e-5  # of differences


def body_of(mass: float) -> Body:
    return Body(mass, (0.02 * mass, 0.03 * mass, 0.01 * mass))


def tree(root: str, kind: str) -> Scene:
    """Two arms of joints of all types, the one with a far follower, whose ends a constraint holds to each other."""
    names = ("base", "a", "b", "c", "d", "e", "f", "g")
    bodies = {name: body_of(0.6 + 0.2 * k) for k, name in enumerate(names)}
    joints = {
        "ja": Joint("hinge", "base", "a", (0.1, 0.0, 0.0), (0.0, 0.2, 0.01), [(0.9, 0.2, 0.1)]),
        "jb": Joint("universal", "a", "b", (0.0, -0.2, 0.0), (0.02, 0.2, 0.0), [X, Z]),
        "jc": Joint("ball", "base", "c", (-0.1, 0.05, 0.0), (0.0, 0.25, 0.01)),
        "jd": Joint("slide", "c", "d", (0.0, -0.2, 0.0), (0.02, 0.2, 0.0), [(0.1, 1.0, 0.3)]),
        "je": Joint("coupled", "d", "e", (0.0, -0.2, 0.0), (0.02, 0.2, 0.0), rotations=[CURVE], translations=[SHIFT]),
        "jf": Joint("coupled", "b", "f", (0.0, -0.2, 0.0), (0.02, 0.2, 0.0), rotations=[CURVE], translations=[SHIFT],
            follows="je"),
        "jg": Joint("fixed", "f", "g", (0.0, -0.2, 0.0), (0.02, 0.2, 0.0)),
    }  # fmt: skip
    character = Character("base", bodies, joints, root)
    held = Constraint(kind, "g", "e", (0.0, -0.15, 0.02), (0.03, -0.1, 0.01), axis=(0.3, 0.8, 0.1), distance=0.3)
    character.constraints = {"loop": held}
    return Scene("loop", character, ground=Ground(stiffness=0.0))


def states(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    random, names = np.random.default_rng(1), topology(scene.character)
    q, v = random.uniform(-0.7, 0.7, (count, names.coordinates)), random.normal(size=(count, names.speeds))
    for body in range(len(names.bodies)):
        place = names.coordinates_of(body)
        if place.stop - place.start >= 4 and names.driver[body] == body:
            q[:, place.stop - 4 : place.stop] = normalized(q[:, place.stop - 4 : place.stop])
    return q, v


def moved(scene: Scene, names: Topology, q: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
    """Coordinates a short time later."""
    found = q.copy()

    def turned(orientation: np.ndarray, spin: np.ndarray, world: bool) -> np.ndarray:
        small = normalized(np.concatenate([0.5 * time * spin, np.ones((len(spin), 1))], axis=1))
        return np.asarray(multiply(small, orientation) if world else multiply(orientation, small))

    if scene.character.root_joint == "planar":
        found[:, :3] += time * v[:, :3]
    elif scene.character.root_joint == "free":
        found[:, :3] += time * v[:, :3]
        found[:, 3:7] = turned(q[:, 3:7], v[:, 3:6], True)
    for body in range(1, len(names.bodies)):
        if names.driver[body] != body:
            continue
        place, speeds = names.coordinates_of(body), names.speeds_of(body)
        if place.stop - place.start == 4:
            found[:, place] = turned(q[:, place], v[:, speeds], False)
        else:
            found[:, place] += time * v[:, speeds]
    return found


def jacobian(scene: Scene, names: Topology, q: np.ndarray) -> np.ndarray:
    columns = []
    for k in range(names.speeds):
        unit = np.repeat(np.eye(names.speeds)[k : k + 1], len(q), axis=0)
        both = [constraint_errors(scene.character, names, moved(scene, names, q, unit, t)) for t in (SMALL, -SMALL)]
        columns.append((both[0] - both[1]) / (2.0 * SMALL))
    return np.stack(columns, axis=2)


def expected(scene: Scene, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Accelerations with pushes, all in float64, at the first step."""
    names, h = topology(scene.character), scene.time_step
    error, matrix = constraint_errors(scene.character, names, q), jacobian(scene, names, q)
    ahead, behind = (jacobian(scene, names, moved(scene, names, q, v, t)) for t in (SMALL, -SMALL))
    drift = np.einsum("nrk,nk->nr", (ahead - behind) / (2.0 * SMALL), v)
    wanted = -drift - DAMPING * np.einsum("nrk,nk->nr", matrix, v) / h - STIFFNESS * error / h**2
    bias, mass = inverse_dynamics(scene, q, v, np.zeros_like(v)), joint_space(scene, q).mass_matrix
    found = []
    for m, b, j, w in zip(mass, bias, matrix, wanted, strict=True):
        response = j @ np.linalg.solve(m, j.T)
        push = np.linalg.solve(response, w + j @ np.linalg.solve(m, b))
        found.append(np.linalg.solve(m, j.T @ push - b))
    return np.array(found)


@pytest.mark.parametrize("root", ["free", "planar", "fixed"])
@pytest.mark.parametrize("kind", ["point", "point_on_line", "distance"])
def test_accelerations_are_those_of_the_equations_with_multipliers(
    monkeypatch: pytest.MonkeyPatch, kind: str, root: str
):
    monkeypatch.setattr("warpmuscle.scene.validation.constraints.OPEN", 1e9)  # all states are equally far from met
    scene = tree(root, kind)
    q, v = states(scene, 5)
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    found, right = stages.forward_dynamics()["speed_rate"], expected(scene, q, v)
    np.testing.assert_allclose(found, right, atol=5e-5 * np.abs(right).max())


ARMS = {"p": 2, "q": 2, "l": 2, "m": 2, "d": 2, "e": 2, "w": 4, "x": 4}  # links of each


def linkage(duration: float) -> Scene:
    """Four closed loops of hinges, one by each kind of constraint, on a base that is welded to the ground."""
    bodies, joints = {"base": body_of(1.0)}, dict[str, Joint]()
    for k, (arm, count) in enumerate(ARMS.items()):
        parent, place = "base", (0.0, 0.0, 0.3 * (-1.0) ** k)
        for link in range(count):
            axis = (0.3 * link, 0.1 * link, 0.2 * link) if arm in "wxlm" and link else (0.0, 0.0, 0.0)
            name = f"{arm}{link}"
            bodies[name] = body_of(0.5 + 0.1 * k)
            joints[f"j{name}"] = Joint("hinge", parent, name, place, (0.0, 0.2, 0.0), [tuple(np.add(X, axis))])
            parent, place = name, (0.0, -0.2, 0.0)
    character = Character("base", bodies, joints, "fixed")
    tip = (0.0, -0.2, 0.0)
    character.constraints = {
        "point": Constraint("point", "p1", "q1", tip, tip),
        "line": Constraint("point_on_line", "l1", "m1", tip, tip, axis=(0.1, 0.9, 0.3)),
        "distance": Constraint("distance", "d1", "e1", tip, tip, distance=0.25),
        "weld": Constraint("weld", "w3", "x3"),
    }
    scene = Scene("linkage", character, ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))
    scene.duration, scene.time_step = duration, 1.0 / 2000.0
    names = topology(character)
    q, chosen = start_coordinates(scene, names), []
    random = np.random.default_rng(3)
    for name in names.joints:
        chosen.append(names.coordinates_of(names.body_of_joint(name)).start)
        q[0, chosen[-1]] = random.uniform(-0.6, 0.6)
    poses, weld = bodies_at(character, names, q), character.constraints["weld"]
    (place, turn), (other, other_turn) = poses["w3"], poses["x3"]  # are welded as they are
    weld.other_position = tuple(map(float, rotate(conjugate(other_turn), place - other)[0]))
    weld.other_orientation = tuple(map(float, multiply(conjugate(other_turn), turn)[0]))
    far = np.full(len(chosen), 9.0)
    q, missing = nearest_pose(character, names, q, chosen, -far, far)
    assert missing < 1e-10
    v = meeting_speeds(character, names, q, chosen, np.full(len(chosen), 2.0))
    for name, angle, rate in zip(names.joints, q[0, chosen], v, strict=True):
        axis = normalized(np.array(joints[name].axes[0]))
        scene.initial_state.joints[name] = JointState(tuple(map(float, about(axis, angle))), tuple(rate * axis))
    return scene


def run(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    assert rollout.status_names() == ("completed",)
    return tuple(rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds"))


def knee() -> Scene:
    """A shank of 40 kg that hangs on two plates of a gram, by a ball joint and by a weld."""
    plate, axis, tilted = Body(1e-3, (2.5e-6,) * 3), (1.0, 0.1, 0.2), 0.06
    bodies = {
        "base": body_of(1.0),
        "thigh": Body(8.0, (0.1, 0.1, 0.1)),
        "medial": plate,
        "lateral": plate,
        "shank": Body(40.0, (2.0, 0.4, 2.0)),
    }
    joints = {
        "hip": Joint("hinge", "base", "thigh", (0.0, 0.0, 0.0), (0.0, 0.3, 0.0), [X]),
        "inner": Joint("hinge", "thigh", "medial", (-0.03, -0.3, 0.0), (0.0, 0.0, 0.0), [axis]),
        "outer": Joint("hinge", "thigh", "lateral", (0.03, -0.3 + 0.1 * tilted, 0.2 * tilted), (0.0, 0.0, 0.0), [axis]),
        "tibia": Joint("ball", "medial", "shank", (0.0, -0.02, 0.0), (-0.03, 0.3, 0.0)),
    }
    character = Character("base", bodies, joints, "fixed")
    place = (0.03, 0.32 + 0.1 * tilted, 0.2 * tilted)
    character.constraints = {"weld": Constraint("weld", "lateral", "shank", other_position=place)}
    scene = Scene("knee", character, ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))
    scene.duration, scene.time_step = 0.4, 1.0 / 2000.0
    scene.initial_state.joints["hip"] = JointState(tuple(map(float, about(np.array(X), 0.6))))
    return scene


@pytest.mark.usefixtures("optimized_test")
def test_light_parts_hold_heavy_ones():
    scene = knee()
    q, _ = run(scene)
    errors = np.abs(constraint_errors(scene.character, topology(scene.character), q))
    assert np.ptp(q, axis=0).max() > 0.4
    assert errors[:, :3].max() < 2e-7
    assert errors[:, 3:].max() < 5e-6


@pytest.mark.usefixtures("optimized_test")
def test_loops_of_every_kind_stay_closed_and_keep_their_energy():
    scene = linkage(10.0)
    q, v = run(scene)
    assert np.abs(constraint_errors(scene.character, topology(scene.character), q)).max() < 1e-6
    both = energy(scene, q, v)
    assert np.ptp(both[0]) > 4.0
    assert np.ptp(both.sum(axis=0)) < 2e-3 * np.ptp(both[0])


def test_one_constraint_alone_is_kept():
    scene = linkage(0.3)
    scene.character.constraints = {"distance": scene.character.constraints["distance"]}
    q, _ = run(scene)
    assert np.abs(constraint_errors(scene.character, topology(scene.character), q)).max() < 1e-6


def test_light_parts_say_nothing_of_heavy_ones():
    """A loop of half a tonne beside one of grains of sand."""
    scene = linkage(0.3)
    for name, share in {"p": 1e3, "q": 1e3, "w": 1e-5, "x": 1e-5}.items():
        for link in range(ARMS[name]):
            body = scene.character.bodies[f"{name}{link}"]
            scene.character.bodies[f"{name}{link}"] = body_of(share * body.mass)
    q, _ = run(scene)
    assert np.abs(constraint_errors(scene.character, topology(scene.character), q)).max() < 2e-6


def test_a_row_that_says_what_others_do_changes_nothing():
    scene = linkage(0.5)
    twice = copy.deepcopy(scene)
    twice.character.constraints["again"] = copy.deepcopy(scene.character.constraints["point"])
    twice.character.constraints["on it"] = Constraint("point_on_line", "p1", "q1", (0.0, -0.2, 0.0), (0.0, -0.2, 0.0))
    (once, _), (again, _) = run(scene), run(twice)
    np.testing.assert_allclose(again, once, atol=2e-4)


def test_a_loop_with_a_driven_hinge_stays_closed():
    scene = linkage(0.5)
    start = 2.0 * np.arctan2(*np.array(scene.initial_state.joints["jp0"].orientation)[[0, 3]])
    rate = scene.initial_state.joints["jp0"].angular_velocity[0]
    time = np.linspace(0.0, 0.5, 26)
    scene.actuation["jp0"] = Actuation("kinematic")
    scene.motion["jp0"] = Motion(time.tolist(), (start + 0.2 * np.sin(5.0 * rate * time)).tolist())
    scene.initial_state.joints.pop("jp0")
    q, _ = run(scene)
    assert np.abs(constraint_errors(scene.character, topology(scene.character), q)).max() < 2e-6
