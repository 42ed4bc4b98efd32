"""Joints that follow coordinates far from theirs, against the tree without followers reduced by M = J^T M J."""

import numpy as np
import pytest

from reduced_tree import check_energy_stays, energy, expected, lengths, put, recorded
from warpmuscle.core.pose import normalized
from warpmuscle.model.couplings import couplings_struct
from warpmuscle.model.joints import acting_unknowns, compiled_skeleton
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    CylinderSurface,
    Displacement,
    Excitation,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Motion,
    Muscle,
    Scene,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.topology import carried, followed_drivers, topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.inverse_dynamics import inverse_dynamics
from warpmuscle.studies.moment_arms import muscle_geometry

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
CURVE = Displacement((0.2, 0.9, -0.3), x=[-2.0, -1.0, 0.0, 1.0, 2.0], y=[-0.3, 0.1, 0.2, -0.1, 0.4])
SHIFT = Displacement(Y, polynomial=[0.01, -0.03, 0.02, 0.0, 0.01])
NEAR, FAR = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)


def following(parent: str, child: str, follows: str, scale: float) -> Joint:
    turns = [CURVE, Displacement((1.0, 0.3, 0.0), 0.1, scale)]
    return Joint("coupled", parent, child, NEAR, FAR, rotations=turns, translations=[SHIFT], follows=follows)


def body(root_joint: str = "free", ball: bool = True) -> Scene:
    """A shoulder rhythm, a spine, and a jaw that follows a knee; free joints of every type are between them."""
    names = ("pelvis", "chest", "clavicle", "scapula", "arm", "fore", "hand", "thigh", "shank", "foot", "head", "jaw")
    masses = zip(names, np.random.default_rng(1).uniform(0.5, 2.0, len(names)), strict=True)
    bodies = {name: Body(m, (0.02 * m, 0.03 * m, 0.01 * m)) for name, m in masses}
    joints = {
        "waist": Joint("ball" if ball else "hinge", "pelvis", "chest", NEAR, FAR, [] if ball else [X]),
        "sternoclavicular": following("chest", "clavicle", "elevation", 0.4),
        "acromioclavicular": Joint("slide", "clavicle", "scapula", NEAR, FAR, [Y]),
        "plane": Joint("hinge", "scapula", "arm", NEAR, FAR, [(0.3, 0.9, 0.1)]),
        "elevation": Joint("hinge", "arm", "fore", NEAR, FAR, [X]),
        "wrist": following("fore", "hand", "plane", -0.7),
        "hip": Joint("universal", "pelvis", "thigh", NEAR, FAR, [X, Z]),
        "knee": Joint("coupled", "thigh", "shank", NEAR, FAR, rotations=[CURVE], translations=[SHIFT]),
        "ankle": following("shank", "foot", "knee", 0.9),
        "neck": Joint("hinge", "chest", "head", FAR, NEAR, [(0.5, 0.1, 0.8)]),
        "bite": following("head", "jaw", "knee", 0.5),
    }
    character = Character("pelvis", bodies, joints, root_joint)
    return Scene("body", character, ground=Ground(stiffness=0.0))


def states(scene: Scene, count: int = 6) -> tuple[np.ndarray, np.ndarray]:
    rng, names = np.random.default_rng(5), topology(scene.character)
    q = rng.uniform(-1.0, 1.0, (count, names.coordinates))
    if scene.character.root_joint != "planar":
        q[:, 3:7] = normalized(q[:, 3:7])
    waist = names.coordinates_of(names.body_of_joint("waist"))
    if waist.stop - waist.start == 4:
        q[:, waist] = normalized(q[:, waist] + [0.0, 0.0, 0.0, 2.0])
    return q, rng.normal(size=(count, names.speeds)) * 2.0


def of_one_axis(scene: Scene) -> Scene:
    """The body with a hinge in place of its universal joint."""
    hip = scene.character.joints["hip"]
    hip.type, hip.axes = "hinge", [Z]
    return scene


@pytest.mark.parametrize("root", ["free", "planar", "fixed"])
@pytest.mark.parametrize("single", [False, True])
def test_accelerations_are_those_of_the_reduced_tree(root: str, single: bool):
    scene = of_one_axis(body(root, ball=False)) if single else body(root)
    assert compiled_skeleton(scene.character).single is single
    q, v = states(scene)
    mass, bias = expected(scene, q, v)
    stages = put(scene, q, v)
    assert stages.structure.skeleton.followed == 3
    np.testing.assert_allclose(stages.mass_matrix(), mass, atol=2e-6 * np.abs(mass).max())
    accelerations = np.linalg.solve(mass, -bias[..., None])[..., 0]
    rates = stages.forward_dynamics()["speed_rate"]
    np.testing.assert_allclose(rates, accelerations, atol=2e-4 * np.abs(accelerations).max())


def swinging(**drives: str) -> Scene:
    """The body hung by its pelvis, with drives of some joints, moving."""
    scene = body("fixed", ball=False)
    scene.initial_state = InitialState(
        joints={"elevation": JointState(coordinate=0.5, speed=2.0), "knee": JointState(coordinate=-0.4, speed=-3.0)}
    )
    scene.failure, scene.duration = Failure(com_height=0.0, heading=0.0), 0.5
    moving = [name for name, joint in scene.character.joints.items() if not joint.follows]
    scene.actuation = {name: Actuation(drives.get(name, "torque")) for name in moving}
    scene.initial_state.joints["elevation"] = JointState(angular_velocity=(2.0, 0.0, 0.0))
    time = np.linspace(0.0, 0.5, 21)
    scene.motion = {
        name: Motion(time=time.tolist(), value=(0.3 * k + 0.4 * np.sin(6.0 * time)).tolist())
        for k, name in enumerate(drives, 1)
    }
    return scene


def test_a_body_that_swings_keeps_its_energy():
    check_energy_stays(swinging())


@pytest.mark.parametrize("prescribed", [("plane",), ("waist", "knee")])
def test_what_is_prescribed_moves_its_followers_and_the_rest_answers(prescribed: tuple[str, ...]):
    scene = swinging(**dict.fromkeys(prescribed, "kinematic"))
    q, v = recorded(scene)
    at = np.arange(100, 600, 50)
    needed = inverse_dynamics(scene, q[at], v[at], (v[at + 4] - v[at - 4]) / 0.004)
    names = topology(scene.character)
    held = [names.speeds_of(names.body_of_joint(name)).start for name in prescribed]
    assert np.abs(needed[:, held]).max(axis=0).min() > 0.5
    np.testing.assert_allclose(np.delete(needed, held, axis=1), 0.0, atol=2e-2)


ROUTES = {
    "subclavius": [("pelvis", (0.05, 0.2, 0.03)), ("clavicle", (-0.03, 0.02, 0.06))],  # before what moves it
    "trapezius": [("head", (0.0, 0.1, -0.06)), ("chest", (0.0, 0.0, -0.08)), ("scapula", (0.03, 0.0, -0.05))],
    "deltoid": [("clavicle", (0.05, 0.02, 0.04)), ("fore", (0.04, -0.03, 0.02))],
    "biceps": [("chest", (0.02, 0.0, 0.07)), ("hand", (0.01, 0.02, 0.05))],
    "masseter": [("head", (0.04, 0.05, 0.03)), ("jaw", (-0.02, 0.03, 0.05))],
    "platysma": [("chest", (0.0, 0.05, 0.06)), ("jaw", (0.01, -0.02, 0.06))],
    "soleus": [("thigh", (0.0, -0.1, -0.05)), ("shank", (0.01, 0.0, -0.06)), ("foot", (0.02, 0.0, -0.06))],
}


def with_muscles(scene: Scene) -> Scene:
    """Muscles on what follows before, behind and beside the joint that it follows."""
    for name, route in ROUTES.items():
        path = [ViaPoint(place, position) for place, position in route]
        scene.character.muscles[name] = Muscle(path=path, f_max=60.0, l_opt=0.2, l_slack=0.2)
    return scene


def slopes(scene: Scene, q: np.ndarray, joint: str) -> np.ndarray:
    """-dl/dq (n, M) of a joint's only coordinate, by differences in float64."""
    names = topology(scene.character)
    unit = 1e-6 * np.eye(q.shape[1])[names.coordinates_of(names.body_of_joint(joint)).start]
    return (lengths(scene, q - unit) - lengths(scene, q + unit)) / 2e-6


def test_muscles_on_all_that_follows_a_coordinate_pull_on_it():
    scene = with_muscles(body())
    q, v = states(scene)
    names = topology(scene.character)
    found, arm = muscle_geometry(scene, q)
    np.testing.assert_allclose(found, lengths(scene, q), atol=1e-6)
    for joint in ("plane", "elevation", "knee"):
        expected_arm = slopes(scene, q, joint)
        own = names.speeds_of(names.body_of_joint(joint)).start
        assert np.ptp(expected_arm, axis=0).max() > 0.05
        np.testing.assert_allclose(arm[:, :, own], expected_arm, atol=3e-6, err_msg=joint)
    scalars = ("acromioclavicular", "plane", "elevation", "knee", "neck")
    own = [names.speeds_of(names.body_of_joint(joint)).start for joint in scalars]
    alone = np.zeros_like(v)
    alone[:, own] = v[:, own]
    speed = -sum(slopes(scene, q, joint) * v[:, [k]] for joint, k in zip(scalars, own, strict=True))
    np.testing.assert_allclose(put(scene, q, alone).muscle_paths().speed, speed, atol=1e-5)


def test_a_path_that_wraps_on_followers_pulls_on_what_they_follow():
    """Its lengths are in single precision, and so are their differences."""
    scene = with_muscles(body())
    scene.character.muscles = {"biceps": scene.character.muscles["biceps"]}
    scene.character.surfaces = {"rib": CylinderSurface("clavicle", (0.0, 0.0, 0.0), 0.05, 1.0)}
    scene.character.muscles["biceps"].wraps = [Wrap("rib")]
    scene.character.wrapping = "shortest"
    q, _ = states(scene, 60)
    names = topology(scene.character)
    _, arm = muscle_geometry(scene, q)
    bent = np.abs(muscle_geometry(scene, q)[0] - lengths(scene, q))[:, 0] > 1e-3
    assert bent.sum() > 5
    for joint in ("plane", "elevation"):
        at = names.body_of_joint(joint)
        unit = 2e-3 * np.eye(q.shape[1])[names.coordinates_of(at).start]
        slope = (muscle_geometry(scene, q - unit)[0] - muscle_geometry(scene, q + unit)[0]) / 4e-3
        off = np.abs(arm[:, 0, names.speeds_of(at).start] - slope[:, 0])
        assert np.median(off[bent]) < 1e-4
        assert (off > 2e-3).mean() < 0.1  # where a path begins to touch, within the difference


def test_energy_changes_by_the_work_of_muscles_on_what_follows():
    scene = with_muscles(swinging())
    for name, muscle in scene.character.muscles.items():
        muscle.excitation = Excitation([0.0, 0.5], [0.8, 0.2] if name in ("subclavius", "platysma") else [0.1, 0.7])
        muscle.tendon = "rigid"
    scene.actuation |= {name: Actuation("muscle") for name in scene.actuation if name != "hip"}
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
    rollout.run()
    assert rollout.status_names() == ("completed",)
    q, v, force = (rollout.recorded(name)[0].astype(float) for name in ("coordinates", "speeds", "muscle_force"))
    total = energy(scene, q, v).sum(axis=0)
    work = -np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(lengths(scene, q), axis=0), axis=0)
    assert np.abs(work).max(axis=0).min() > 0.02
    assert np.ptp(total) > 2.0
    np.testing.assert_allclose(total[1:] - total[0], work.sum(axis=1), atol=5e-4 * np.ptp(total))


def test_unknowns_act_on_the_bodies_between_what_they_move_and_the_root_alone():
    scene = body()
    names = topology(scene.character)
    drivers = followed_drivers(scene.character, names)
    acting = acting_unknowns(scene.character, names)
    moved = [
        {names.body_of_joint(j) for j in names.joints if names.driver[names.body_of_joint(j)] == k} for k in drivers
    ]
    for number, name in enumerate(names.bodies[1:], start=1):
        joint = next(j for j in names.joints if names.body_of_joint(j) == number)
        expected = [k for k, bodies in enumerate(moved) if bodies & carried(joint, names)]
        assert acting[number] == expected, name
    assert acting[0] == list(range(len(drivers)))
    c, unknowns = couplings_struct(scene, names, "cpu"), len(drivers)
    entries = [(body, k) for body, of_body in enumerate(acting) for k in of_body]
    assert compiled_skeleton(scene.character).entries == len(entries) < unknowns * len(names.bodies)
    table = c.entry.numpy().reshape(len(names.bodies), unknowns)
    assert [tuple(np.argwhere(table == k)[0]) for k in range(len(entries))] == entries
    assert (table >= 0).sum() == len(entries)
    assert c.unknown_driver.numpy().tolist() == list(drivers)
    starts, acted = c.acted_start.numpy(), c.acted.numpy()
    for k in range(unknowns):
        assert acted[starts[k] : starts[k + 1]].tolist() == [body for body, one in entries if one == k and body > 0]
