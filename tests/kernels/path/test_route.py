"""Routes: paths that wrap around surfaces, whose points move, or come in at once; and polynomials."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from muscle_arm import arm, leg
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.core.pose import from_rotation_vector, multiply, rotate
from warpmuscle.formats import load
from warpmuscle.kernels.path.route import neighbours
from warpmuscle.kernels.route_structs import RouteSpan, RouteWrap
from warpmuscle.scene import (
    Condition,
    CylinderSurface,
    EllipsoidSurface,
    Joint,
    Muscle,
    PointMotion,
    PolynomialPath,
    Scene,
    SphereSurface,
    TorusSurface,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.wrapping.path import path_length
from warpmuscle.scene.wrapping.route import route_stops
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import MusclePaths, Stages

GIVEN = {"f_max": 400.0, "l_opt": 0.15, "l_slack": 0.1}


def wrapped_leg(wrapping: str = "opensim") -> Scene:
    """The leg whose muscles wrap around cylinders and spheres, one of them around both."""
    scene = leg()
    character = scene.character
    character.wrapping = wrapping
    character.surfaces = {
        "knee": CylinderSurface("thigh", (0.0, -0.2, 0.0), 0.03, 0.2, (0.1, 1.4, 0.2), "+x"),
        "shin": CylinderSurface("thigh", (0.0, -0.15, 0.02), 0.03, 0.2, (0.1, 1.4, 0.2)),
        "ball": SphereSurface("pelvis", (0.02, -0.1, -0.05), 0.03),
        "head": SphereSurface("thigh", (0.0, 0.15, 0.0), 0.04, side="-z"),
    }
    character.muscles["both"].wraps = [Wrap("knee", 2), Wrap("ball", 1, 2)]
    character.muscles["hip"].wraps = [Wrap("head")]
    character.muscles["knee"].wraps = [Wrap("shin")]
    return scene


@wp.kernel(enable_backward=False)
def find_neighbours(first: int, end: int, wrap: wp.array[RouteWrap], found: wp.array[int]):
    span = RouteSpan()
    span.first_wrap = first
    span.end_wrap = end
    found[wp.tid()] = neighbours(wp.tid(), span, wrap)


def test_neighbours_of_a_surface_share_a_segment_with_it():
    """Of a route behind others: points 0 to 2, 1 to 3, 2 to 3 and 4 to 5."""
    others = [(0, 9)] * 3
    first, last = np.array([*others, (0, 2), (1, 3), (2, 3), (4, 5), *others], dtype=np.int32).T
    found = wp.zeros(4, dtype=int, device="cpu")
    wrap = structs_to_device(RouteWrap, {"first": first, "last": last}, "cpu")
    wp.launch(find_neighbours, 4, [3, 7, wrap], [found], device="cpu")
    assert found.numpy().tolist() == [0b0010, 0b0101, 0b0010, 0]


def posed(scene: Scene, count: int, seed: int = 0) -> Stages:
    """Random angles and speeds of the joints behind the root, which is fixed."""
    stages, rng = Stages(scene, count, "cpu"), np.random.default_rng(seed)
    q, v = stages.state.coordinates.numpy().copy(), rng.normal(size=stages.state.speeds.shape)
    q[:, 7:] = rng.uniform(-1.5, 1.5, q[:, 7:].shape)
    if q.shape[1] == 12:  # the leg
        q[:, 7:11] = from_rotation_vector(rng.normal(size=(count, 3), scale=0.6))
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    return stages


def moved(stages: Stages, time: float) -> MusclePaths:
    """Paths a time later at the present speeds."""
    q, v = (getattr(stages.state, name).numpy().astype(float) for name in ("coordinates", "speeds"))
    later = q.copy()
    if q.shape[1] == 12:
        later[:, 7:11], later[:, 11] = (
            multiply(q[:, 7:11], from_rotation_vector(v[:, :3] * time)),
            q[:, 11] + v[:, 3] * time,
        )
    else:
        later[:, 7:] += v * time
    stages.state.coordinates.assign(later.astype(np.float32))
    paths = stages.muscle_paths()
    stages.state.coordinates.assign(q.astype(np.float32))
    return paths


def rates(stages: Stages, step: float = 2e-3) -> np.ndarray:
    """Lengthening speeds (n, M) by central differences of the lengths."""
    after, before = moved(stages, step).length.astype(float), moved(stages, -step).length.astype(float)
    return (after - before) / (2.0 * step)


@pytest.mark.parametrize("wrapping", ["opensim", "shortest"])
def test_lengths_are_those_of_the_geometry_in_float64(wrapping: str):
    stages = posed(wrapped_leg(wrapping), 300)
    kinematics, length = stages.forward_kinematics(), stages.muscle_paths().length
    character, touching = stages.scene.character, np.zeros(3)
    for i in range(300):
        poses = {
            name: (kinematics["position"][i, k].astype(float), kinematics["orientation"][i, k].astype(float))
            for k, name in enumerate(stages.names.bodies)
        }
        for m, muscle in enumerate(character.muscles.values()):
            found = route_stops(character, muscle, poses, {})
            touching[m] += any(stop.wrap >= 0 for stop in found)
            assert length[i, m] == pytest.approx(path_length(found), abs=1e-6)
    assert np.all(touching > 30)


def test_of_many_segments_the_one_goes_through_a_torus_whose_detour_is_the_shortest():
    """The search for nearest places is spared where a segment is too far from the torus's plane."""
    scene = leg()
    character = scene.character
    character.wrapping = "opensim"
    character.surfaces = {
        "ring": TorusSurface("thigh", (0.02, 0.0, -0.05), 0.012, 0.02, (1.5, 0.2, 0.1)),
        "ball": SphereSurface("thigh", (0.02, -0.08, -0.05), 0.02),
        "far": TorusSurface("pelvis", (0.03, -0.03, -0.06), 0.01, 0.015, (1.4, 0.0, 0.3), "+x"),
    }
    along = [(0.02, 0.1, -0.05), (0.03, 0.05, -0.07), (0.025, 0.02, -0.06), (0.03, -0.03, -0.03)]
    path = [ViaPoint("pelvis", (0.03, 0.0, -0.07)), *(ViaPoint("thigh", place) for place in along)]
    path += [ViaPoint("shank", (0.01, 0.1, -0.04)), ViaPoint("shank", (0.01, 0.05, -0.05))]
    for muscle, names in (("both", ("ring", "ball", "far")), ("hip", ("far",)), ("knee", ("far", "ring"))):
        character.muscles[muscle].path = path
        character.muscles[muscle].wraps = [Wrap(name) for name in names]
    stages = posed(scene, 200)
    kinematics, length = stages.forward_kinematics(), stages.muscle_paths().length
    segments: set[int] = set()
    off = np.zeros(length.shape)
    for i in range(200):
        poses = {
            name: (kinematics["position"][i, k].astype(float), kinematics["orientation"][i, k].astype(float))
            for k, name in enumerate(stages.names.bodies)
        }
        for m, one in enumerate(character.muscles.values()):
            found = route_stops(character, one, poses, {})
            segments |= {k for k, stop in enumerate(found) if stop.wrap >= 0}
            off[i, m] = abs(length[i, m] - path_length(found))
    assert len(segments) > 4
    assert np.mean(off < 2e-5) > 0.95  # others have several nearest places, or have just begun to touch
    assert np.mean(off < 1e-3) > 0.99


CROOKED = {  # points, angles about x, the new y and the new z axis and places of surfaces, m; what OpenSim 4.6 measures
    "a turn back": (
        [(-0.02, 1.1, 0.03), (-0.01, 1.0, 0.04), (0.0, 0.9, 0.03), (0.025, 0.749, 0.029), (0.0, 0.601, 0.034),
         (-0.019, 0.502, 0.034)],
        [("first", (0.0, 0.85, 0.03), (1.571, -0.171, 1.671), (0.01, 0.03)),
         ("second", (0.009, 0.68, 0.028), (1.38, -0.081, 0.671), (0.008, 0.02))],
        1.2873190495330946,
    ),
    "with an ellipsoid": (
        [(-0.02, 1.1, 0.03), (-0.01, 1.0, 0.04), (0.0, 0.9, 0.03), (0.025, 0.749, 0.029), (0.0, 0.601, 0.034),
         (-0.019, 0.502, 0.034)],
        [("first", (0.0, 0.85, 0.03), (1.571, -0.171, 1.671), (0.01, 0.03)),
         ("ball", (0.0, 0.8, 0.0), (-0.023, -0.492, 0.242), (0.03, 0.05, 0.04)),
         ("second", (0.009, 0.68, 0.028), (1.38, -0.081, 0.671), (0.008, 0.02))],
        1.5455938386234107,
    ),
    "another way": (
        [(-0.02, 1.1, 0.03), (-0.01, 1.0, 0.04), (0.0, 0.9, 0.03), (-0.021, 0.758, 0.044), (0.026, 0.63, 0.107),
         (0.06, 0.545, 0.147)],
        [("first", (0.0, 0.85, 0.03), (1.571, -0.171, 1.671), (0.01, 0.03)),
         ("second", (0.006, 0.699, 0.07), (1.095, 0.139, 2.633), (0.008, 0.02))],
        1.2071432360239467,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CROOKED)
def test_detours_are_measured_between_the_places_where_a_path_first_touched_other_surfaces(case: str):
    """As in OpenSim: between those of the round itself, these paths would be 3.6 to 297 mm shorter or longer."""
    points, surfaces, expected = CROOKED[case]
    scene = arm()
    character = scene.character
    character.wrapping = "opensim"
    for name, place, angles, sizes in surfaces:
        at = tuple(np.subtract(place, (0.0, 1.0, 0.0)).tolist())  # the base hangs 1 m up
        turn = tuple(Rotation.from_euler("XYZ", angles).as_rotvec().tolist())
        made = TorusSurface("base", at, *sizes, turn) if len(sizes) == 2 else EllipsoidSurface("base", at, sizes, turn)
        character.surfaces[name] = made
    if "ball" in character.surfaces:
        character.surfaces["ball"].side = "+x"
    path = [ViaPoint("base", tuple(np.subtract(point, (0.0, 1.0, 0.0)).tolist())) for point in points[:-1]]
    path.append(ViaPoint("tip", tuple(np.subtract(points[-1], (0.0, 0.8, 0.0)).tolist())))
    character.muscles = {"long": Muscle(path=path, wraps=[Wrap(name) for name, *_ in surfaces], **GIVEN)}
    stages = Stages(scene, 1, "cpu")
    kinematics, length = stages.forward_kinematics(), stages.muscle_paths().length[0, 0]
    poses = {
        name: (kinematics["position"][0, k].astype(float), kinematics["orientation"][0, k].astype(float))
        for k, name in enumerate(stages.names.bodies)
    }
    assert path_length(route_stops(character, character.muscles["long"], poses, {})) == pytest.approx(
        expected, abs=1e-5
    )
    assert length == pytest.approx(expected, abs=1e-4)  # in single precision


def test_a_surface_that_another_one_bends_a_route_onto_is_gone_round_though_a_third_holds_the_end():
    """Straight, the route misses the first ball and ends within the second; round the third it runs into the first."""
    scene = arm()
    character = scene.character
    character.wrapping = "opensim"
    character.surfaces = {
        "first": SphereSurface("base", (-0.016, 0.14, 0.0), 0.006),
        "end": SphereSurface("tip", (0.0, 0.2, 0.0), 0.01),
        "third": SphereSurface("base", (0.002, 0.1, 0.0), 0.02),
    }
    path = [ViaPoint("base", (0.0, 0.2, 0.0)), ViaPoint("tip", (0.0, 0.2, 0.0))]
    character.muscles = {"long": Muscle(path=path, wraps=[Wrap(name) for name in character.surfaces], **GIVEN)}
    stages = Stages(scene, 1, "cpu")
    kinematics, length = stages.forward_kinematics(), stages.muscle_paths().length[0, 0]
    poses = {
        name: (kinematics["position"][0, k].astype(float), kinematics["orientation"][0, k].astype(float))
        for k, name in enumerate(stages.names.bodies)
    }
    found = route_stops(character, character.muscles["long"], poses, {})
    assert {stop.wrap for stop in found if stop.wrap >= 0} == {0, 2}
    assert length == pytest.approx(path_length(found), abs=1e-6)


def test_speeds_and_moment_arms_are_the_derivatives_of_the_lengths():
    stages = posed(wrapped_leg("shortest"), 400)
    paths = stages.muscle_paths()
    off = np.abs(rates(stages) - paths.speed)
    assert np.quantile(off, 0.99) < 1e-4  # others begin to touch within the step, where lengths have a kink
    angular = stages.forward_kinematics()["angular_velocity"].astype(float)
    power = np.zeros(paths.length.shape)
    for k, (muscle, joint) in enumerate(zip(paths.muscle, paths.joint, strict=True)):
        relative = angular[:, joint + 1] - angular[:, stages.names.parents[joint + 1]]
        power[:, muscle] += np.sum(paths.moment_arm[:, k] * relative, axis=1)
    np.testing.assert_allclose(power, paths.speed, atol=1e-6)


def test_moment_arms_round_several_surfaces_are_those_of_opensim(reference_data: Path):
    """Of OpenSim 4.6: the long head of triceps of arm26, round a cylinder, an ellipsoid and, in some, a cylinder."""
    poses = np.array([[1.1448, 0.925211], [1.280843, 1.743863], [1.665734, 2.116481], [1.980051, 1.53076],
                      [2.025362, 1.835057], [2.462595, 0.027628]])  # fmt: skip
    lengths = [0.338517, 0.361085, 0.377017, 0.369077, 0.374687, 0.329428]
    arms = np.array([[-0.02292, -0.022131], [-0.021576, -0.019968], [-0.015323, -0.019655], [0.006679, -0.019924],
                     [0.007843, -0.019934], [0.007747, -0.020811]])  # fmt: skip
    scene = load(reference_data / "opensim_models" / "arm26.osim", ignored=[])
    scene.character.muscles = {"TRIlong": scene.character.muscles["TRIlong"]}
    stages = Stages(scene, len(poses), "cpu")
    q = stages.state.coordinates.numpy()
    q[:, 7:] = poses
    stages.state.coordinates.assign(q)
    paths, turned = stages.muscle_paths(), stages.forward_kinematics()["orientation"].astype(float)
    np.testing.assert_allclose(paths.length[:, 0], lengths, atol=7e-5)  # the mean of other places, see the ellipsoid
    found = np.zeros_like(arms)
    for k, joint in enumerate(paths.joint):
        name = stages.names.joints[joint]
        column, own = ("r_shoulder_elev", "r_elbow_flex").index(name), scene.character.joints[name]
        axis = joint_type(own).pulled_about(own, poses[:, column : column + 1])[0]
        about = rotate(turned[:, stages.names.parents[joint + 1]], axis)
        found[:, column] = -np.sum(paths.moment_arm[:, k] * about, axis=1)
    np.testing.assert_allclose(found, arms, atol=1e-4)


def test_no_length_jumps_over_small_moves():
    stages = posed(wrapped_leg(), 3000, seed=4)
    v = stages.state.speeds.numpy()
    stages.state.speeds.assign(v / np.linalg.norm(v, axis=1, keepdims=True))
    step = moved(stages, np.deg2rad(0.1)).length - stages.muscle_paths().length
    assert np.abs(step).max() < 5e-3


def test_radius_and_place_of_a_surface_may_differ_between_instances():
    scene = wrapped_leg()
    radii = np.array([0.02, 0.025, 0.03])
    scene.character.surfaces["shin"].radius = Free(0.03, 0.01, 0.05)
    scene.character.surfaces["shin"].position = (0.0, Free(-0.15, -0.2, 0.0), 0.02)
    assert [p.name for p in free_parameters(scene)] == [
        "character.surfaces.shin.position.1", "character.surfaces.shin.radius"
    ]  # fmt: skip
    together = Stages(scene, 3, "cpu")
    together.set_parameters(np.stack([[-0.15, -0.16, -0.17], radii], axis=1))
    q = together.state.coordinates.numpy().copy()
    q[:, -1] = 0.5
    together.state.coordinates.assign(q)
    length = together.muscle_paths().length[:, 2]
    assert len(set(length)) == 3
    for k, radius in enumerate(radii):
        alone = wrapped_leg()
        alone.character.surfaces["shin"].radius = float(radius)
        alone.character.surfaces["shin"].position = (0.0, -0.15 - 0.01 * k, 0.02)
        stages = Stages(alone, 1, "cpu")
        stages.state.coordinates.assign(q[:1])
        assert stages.muscle_paths().length[0, 2] == pytest.approx(length[k], abs=1e-7)


def moving_arm() -> Scene:
    """An arm with muscles whose points move or come in at once, and one that is a polynomial."""
    scene = arm()
    character = scene.character
    flexor, extensor = character.muscles["flexor"], character.muscles["extensor"]
    flexor.path[2].motion = [
        PointMotion((0.0, 0.0, 1.0), x=[-2.0, -0.5, 0.3, 2.0], y=[0.0, 0.02, -0.01, 0.01], joint="elbow"),
        PointMotion((0.0, 1.0, 0.0), slope=0.01, joint="elbow"),
    ]
    extensor.path.insert(2, ViaPoint("tip", (0.0, 0.2, -0.06), Condition("elbow", -0.5, 0.7, 0.0)))
    polynomial = PolynomialPath(["elbow"], [[0], [1], [3]], [0.3, 0.03, -0.01])
    character.muscles["fitted"] = Muscle(polynomial=polynomial, **GIVEN)
    return scene


def test_moving_points_and_polynomials_have_exact_moment_arms():
    stages = posed(moving_arm(), 500)
    paths, q = stages.muscle_paths(), stages.state.coordinates.numpy()[:, 7].astype(float)
    off = np.abs(rates(stages) - paths.speed)
    switching = (np.abs(q + 0.5) < 0.02) | (np.abs(q - 0.7) < 0.02)
    assert off[:, [0, 2]].max() < 1e-4
    assert off[~switching, 1].max() < 1e-4
    np.testing.assert_allclose(paths.length[:, 2], 0.3 + 0.03 * q - 0.01 * q**3, atol=1e-7)
    rate = stages.state.speeds.numpy()[:, 0]
    np.testing.assert_allclose(paths.speed[:, 2], (0.03 - 0.03 * q**2) * rate, atol=1e-6)


def test_a_hard_condition_takes_its_point_in_within_its_interval_alone():
    scene, through, past = moving_arm(), moving_arm(), moving_arm()
    through.character.muscles["extensor"].path[2].condition = None
    del past.character.muscles["extensor"].path[2]
    length = [posed(one, 300).muscle_paths().length[:, 1] for one in (scene, through, past)]
    q = posed(scene, 300).state.coordinates.numpy()[:, 7]
    inside = (q >= -0.5) & (q <= 0.7)
    assert 50 < inside.sum() < 250
    np.testing.assert_allclose(length[0], np.where(inside, length[1], length[2]), atol=1e-7)
    assert np.abs(length[1] - length[2]).max() > 1e-3


@pytest.mark.parametrize("end", [0, -1])
def test_a_path_starts_and_ends_at_points_that_count(end: int):
    scene, through, past = moving_arm(), moving_arm(), moving_arm()
    for one in (scene, through, past):
        one.character.muscles["extensor"].path[2].condition = None
    scene.character.muscles["extensor"].path[end].condition = Condition("elbow", -0.5, 0.7, 0.0)
    del past.character.muscles["extensor"].path[end]
    length = [posed(one, 300).muscle_paths().length[:, 1] for one in (scene, through, past)]
    q = posed(scene, 300).state.coordinates.numpy()[:, 7]
    inside = (q >= -0.5) & (q <= 0.7)
    assert 50 < inside.sum() < 250
    np.testing.assert_allclose(length[0], np.where(inside, length[1], length[2]), atol=1e-7)
    assert np.abs(length[1] - length[2]).max() > 1e-3


def test_polynomials_of_several_joints_have_the_gradient_of_their_lengths():
    scene = leg()
    joint = Joint(
        "universal", "pelvis", "thigh", (0.0, -0.05, 0.0), (0.0, 0.2, 0.0), [(1.0, 0.0, 0.0), (0.3, 0.2, 1.0)]
    )
    scene.character.joints["hip"] = joint
    polynomial = PolynomialPath(
        ["hip", "hip", "knee"], [[0, 0, 0], [1, 0, 0], [0, 2, 1], [1, 1, 2]], [0.4, 0.02, -0.01, 0.005], [0, 1, 0]
    )
    twice = PolynomialPath(["knee", "hip", "knee"], [[1, 0, 2], [0, 3, 0]], [0.03, 0.01])
    scene.character.muscles = {name: Muscle(polynomial=one, **GIVEN) for name, one in (("a", polynomial), ("b", twice))}
    stages = posed(scene, 300)
    a, b, c = stages.state.coordinates.numpy()[:, 7:].astype(float).T
    paths = stages.muscle_paths()
    np.testing.assert_allclose(paths.length[:, 0], 0.4 + 0.02 * a - 0.01 * b**2 * c + 0.005 * a * b * c**2, atol=1e-7)
    gradient = np.stack([0.02 + 0.005 * b * c**2, -0.02 * b * c + 0.005 * a * c**2, -0.01 * b**2 + 0.01 * a * b * c])
    expected = np.sum(gradient * stages.state.speeds.numpy().astype(float).T, axis=0)
    np.testing.assert_allclose(paths.speed[:, 0], expected, atol=1e-6)
    np.testing.assert_allclose(paths.length[:, 1], 0.03 * c**3 + 0.01 * a**3, atol=1e-7)
    rate = stages.state.speeds.numpy().astype(float).T
    np.testing.assert_allclose(paths.speed[:, 1], 0.09 * c**2 * rate[2] + 0.03 * a**2 * rate[0], atol=1e-6)


@pytest.mark.parametrize("make", [wrapped_leg, pytest.param(moving_arm, marks=pytest.mark.long)])
def test_the_whole_step_has_the_same_lengths(make):
    scene = make()
    scene.duration, scene.muscle_model.initial_activation = 0.1, 0.2
    rollout = Rollout(scene, 2, "cpu", record=[0])
    rollout.run(10)
    recording = rollout.recording(0)
    stages = Stages(scene, 1, "cpu")
    np.testing.assert_allclose(recording.muscle_path_length[0], stages.muscle_paths().length[0], atol=1e-6)
    assert np.all(np.isfinite(recording.muscle_path_length))
