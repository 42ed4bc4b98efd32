"""A wrist of two joints in a row that follow, half each, coordinates of bodies beside them which carry nothing."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.inverse.chain import chain_of
from warpmuscle.model.build import start_of
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import body_points
from warpmuscle.studies.moment_arms import muscle_geometry

HALF = small.spline("SimmSpline", "-1 0 0.4 1", "-0.5 0 0.15 0.6")
STEP = 2e-3  # rad, of differences of lengths in single precision


def coupler(dependent: str, independent: str) -> str:
    return (
        f'<CoordinateCouplerConstraint name="{dependent}_c"><isEnforced>true</isEnforced>'
        f"<coupled_coordinates_function>{HALF}</coupled_coordinates_function>"
        f"<independent_coordinate_names>{independent}</independent_coordinate_names>"
        f"<dependent_coordinate_name>{dependent}</dependent_coordinate_name></CoordinateCouplerConstraint>\n"
    )


def wrist_text() -> str:
    """The rows of carpals are numbered before the body that the flexion carries, and behind it."""
    names = ("radius", "proximal", "distal", "idle_deviation", "idle_flexion")
    bodies = "".join(small.body(name, 1.0, "0.02 -0.03 0.01", "0.01 0.02 0.015 0 0 0") for name in names)
    joints = "".join(
        small.joint("PinJoint", name, parent, child, small.coordinate(coordinate), "", place, turn)
        for name, parent, child, coordinate, place, turn in (
            ("elbow", "ground", "radius", "elbow_flexion", "0 0 0", "0 0 0"),
            ("first", "radius", "proximal", "first_flexion", "0.01 -0.25 0", "0.2 0.1 0"),
            ("second", "proximal", "distal", "second_flexion", "0 -0.03 0.01", "0.2 0.4 0"),
            ("dev", "radius", "idle_deviation", "deviation", "0.01 -0.25 0", "0 1.2 0"),
            ("flex", "idle_deviation", "idle_flexion", "flexion", "0 -0.03 0", "0.2 0.1 0"),
        )
    )
    path = small.point("a", "radius", "0.03 -0.1 0.02") + small.point("b", "distal", "0.02 -0.05 0.01")
    back = small.point("a", "ground", "-0.04 0.05 0") + small.point("b", "proximal", "-0.03 -0.02 0.01")
    muscles = small.muscle("flexor", path) + small.muscle("extensor", back)
    couplers = coupler("first_flexion", "flexion") + coupler("second_flexion", "flexion")
    more = f"<ConstraintSet><objects>{couplers}</objects></ConstraintSet>"
    return small.model(bodies, joints, muscles, more)


def wrist(folder: Path) -> tuple[Path, Scene]:
    file = small.written(folder, wrist_text())
    return file, load(file, ignored=[])


def poses(scene: Scene, count: int = 12) -> tuple[np.ndarray, dict[str, tuple[int, int]]]:
    """Coordinates of states, and where the model's are among them and among the speeds."""
    names, random = topology(scene.character), np.random.default_rng(2)
    q = np.repeat(start_of(scene, names).coordinates, count, axis=0)
    bodies = {name: names.body_of_joint(name) for name in ("elbow_flexion", "deviation", "flexion")}
    own = {name: (names.coordinates_of(body).start, names.speeds_of(body).start) for name, body in bodies.items()}
    for column, _ in own.values():
        q[:, column] = random.uniform(-0.9, 0.9, count)
    return q, own


def test_arms_are_the_slopes_of_lengths_with_all_that_follows(tmp_path: Path):
    _, scene = wrist(tmp_path)
    q, own = poses(scene)
    _, arm = muscle_geometry(scene, q)
    for column, speed in own.values():
        step = STEP * np.eye(q.shape[1])[column]
        slope = (muscle_geometry(scene, q - step)[0] - muscle_geometry(scene, q + step)[0]) / (2.0 * STEP)
        np.testing.assert_allclose(arm[:, :, speed], slope, atol=1e-4)
    assert np.ptp(arm[:, :, own["flexion"][1]], axis=0).min() > 0.005  # m


def test_lengths_and_arms_are_those_of_opensim(tmp_path: Path):
    opensim = pytest.importorskip("opensim", reason="OpenSim is not installed")
    file, scene = wrist(tmp_path)
    q, own = poses(scene)
    length, arm = muscle_geometry(scene, q)
    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(file))
    state = model.initSystem()
    coordinates = model.getCoordinateSet()
    for row, values in enumerate(q):
        for name, (column, _) in own.items():
            coordinates.get(name).setValue(state, float(values[column]), False)
        model.assemble(state)
        for m, name in enumerate(scene.character.muscles):
            muscle = model.getMuscles().get(name)
            assert length[row, m] == pytest.approx(muscle.getLength(state), abs=1e-6)
            for about, (_, speed) in own.items():
                theirs = muscle.computeMomentArm(state, coordinates.get(about))
                assert arm[row, m, speed] == pytest.approx(theirs, abs=1e-5)


def test_markers_move_with_a_coordinate_that_comes_behind_what_follows_it(tmp_path: Path):
    _, scene = wrist(tmp_path)
    chain = chain_of(scene)
    q, own = poses(scene)
    values = q[:, [own[name][0] for name in chain.coordinates]]
    placed = body_points(scene, q)
    for joint in scene.character.joints.values():
        at, turn = placed[joint.child]
        expected = at - rotate(turn, np.array(joint.position_in_child))
        found = chain.places(chain.poses(values), [chain.bodies[joint.child]])[:, 0]
        np.testing.assert_allclose(found, expected, atol=1e-12)
    place, k = [chain.bodies["distal"]], chain.coordinates.index("flexion")
    step = 1e-6 * np.eye(values.shape[1])[k]
    moved = (chain.places(chain.poses(values + step), place) - chain.places(chain.poses(values - step), place)) / 2e-6
    np.testing.assert_allclose(chain.jacobian(values, place)[..., k], moved, atol=1e-8)
    assert np.abs(moved).max() > 0.01
