"""Conditional points that would let a path jump come in over a band, unless they shall come in as OpenSim's."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

import osim_models as small
from warpmuscle.formats import Ignored, load
from warpmuscle.scene import JointState, Scene
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import moment_arms

JUMPING = "iliopsoas_r"  # of gait10dof18musc, by 20 mm where its hip extends beyond 90 degrees


def model(folder: Path, name: str, **options: bool) -> tuple[Scene, list[Ignored]]:
    ignored: list[Ignored] = []
    return load(folder / "opensim_models" / f"{name}.osim", ignored=ignored, **options), ignored


def blends(scene: Scene) -> dict[str, float]:
    muscles = scene.character.muscles.items()
    return {
        name: float(p.condition.blend) for name, one in muscles for p in one.path if p.condition and p.condition.blend
    }


def test_only_points_that_a_path_would_jump_by_come_in_over_a_band(reference_data: Path):
    found = blends(model(reference_data, "gait10dof18musc")[0])
    assert found.keys() == {JUMPING, "iliopsoas_l"}
    assert all(0.05 < width < 0.1 for width in found.values())
    assert not blends(model(reference_data, "gait10dof18musc", hard_points=True)[0])


@pytest.mark.parametrize("hard", [False, True])
def test_path_moves_by_less_than_five_millimetres_in_a_tenth_of_a_degree(reference_data: Path, hard: bool):
    scene, _ = model(reference_data, "gait10dof18musc", hard_points=hard)
    angles = np.arange(-1.66, -1.48, np.radians(0.1))
    muscles = {JUMPING: scene.character.muscles[JUMPING]}
    scene = replace(scene, character=replace(scene.character, muscles=muscles), actuation={}, forces={})
    stages = Stages(scene, len(angles), "cpu")
    names, coordinates = stages.names, stages.state.coordinates.numpy()
    coordinates[:, names.coordinate_start[names.body_of_joint("hip_flexion_r")]] = angles
    stages.state.coordinates.assign(coordinates)
    change = np.abs(np.diff(stages.muscle_paths().length[:, 0]))
    assert (change.max() > 0.015) == hard
    assert hard or change.max() < 0.002


@pytest.mark.parametrize("hard", [False, True])
def test_points_that_count_until_the_range_ends_count_beyond_it(reference_data: Path, hard: bool):
    """A knee that leans on its stop goes beyond its range; the gastrocnemius of OpenSim is 7 mm shorter at once."""
    scene, _ = model(reference_data, "gait10dof18musc", hard_points=hard)
    (point,) = (point for point in scene.character.muscles["gastroc_r"].path if point.condition)
    low, high = scene.character.joints["knee_angle_r"].limits[0]
    assert point.condition.low == pytest.approx(-0.785408)  # within the range
    assert (point.condition.high > high + 0.5) == (not hard)
    (far,) = (point for point in scene.character.muscles["vasti_r"].path if point.condition)
    assert far.condition.low == pytest.approx(-2.618)
    assert far.condition.low < low - 0.5


def test_path_over_a_ball_joint_is_told_to_jump(reference_data: Path):
    scene, ignored = model(reference_data, "gait2392_millard2012muscle", ball_joints=True)
    assert not blends(scene)
    told = [one for one in ignored if "path jumps by" in one.reason]
    assert len(told) == 4
    assert "it depends on angles of a ball joint" in told[0].reason
    assert "psoas" in told[0].text or "iliacus" in told[0].text


def test_blended_points_of_other_hinges_stay_as_they_are(reference_data: Path):
    scene, _ = model(reference_data, "gait10dof18musc")
    assert scene.initial_state.joints.get("hip_flexion_r", JointState()) == JointState()


def conditional(low: float, high: float) -> str:
    """A point far out on the rod that counts in an interval of the pin's angle."""
    point = small.point("out", "base", "0.1 0.04 0").replace("PathPoint", "ConditionalPathPoint")
    more = f"<socket_coordinate>/jointset/pin/q</socket_coordinate><range>{low} {high}</range>"
    return point.replace("</Cond", f"{more}</Cond")


def test_moment_arms_within_the_band_lie_between_those_with_the_point_and_without_it(tmp_path: Path):
    """A path from a on the base to b on the rod has the moment arm (a x b) / |b - a| about z.

    OpenSim's moment arm is -dl/dq of the path that it has at the time, and knows nothing of the jump.
    """
    points = small.point("a", "base", "0.02 0.2 0") + conditional(-0.5, 1.0) + small.point("b", "rod", "0.02 -0.2 0")
    bodies = small.body("base") + small.body("rod", center="0 -0.5 0")
    joints = small.joint("WeldJoint", "weld", "ground", "base")
    joints += small.joint("PinJoint", "pin", "base", "rod", small.coordinate("q"))
    scene = load(small.written(tmp_path, small.model(bodies, joints, small.muscle("m", points))), ignored=[])
    (muscle,) = scene.character.muscles.values()
    condition = muscle.path[1].condition
    assert condition is not None
    assert condition.blend > 0.04
    q = np.linspace(-0.65, -0.35, 241)
    b = np.stack([0.02 * np.cos(q) + 0.2 * np.sin(q), 0.02 * np.sin(q) - 0.2 * np.cos(q)])
    length, arm = (np.zeros((2, len(q))) for _ in range(2))
    for row, (x, y) in enumerate([(0.02, 0.2), (0.1, 0.04)]):  # a, past the point, and through it
        length[row] = np.hypot(b[0] - x, b[1] - y) + (0.0, np.hypot(0.08, 0.16))[row]
        arm[row] = (y * b[0] - x * b[1]) / np.hypot(b[0] - x, b[1] - y)
    t = np.clip((q - condition.low) / condition.blend + 0.5, 0.0, 1.0)
    weight = t * t * (3.0 - 2.0 * t)
    got = moment_arms(scene, "q", 0, q).arm[:, 0]
    np.testing.assert_allclose(np.abs(got), np.abs((1.0 - weight) * arm[0] + weight * arm[1]), atol=1e-6)
    slope = np.gradient((1.0 - weight) * length[0] + weight * length[1], q)
    assert np.abs(slope).max() > 0.3  # which the moment arm must not be
    assert np.abs(got).max() < 0.1


@pytest.mark.parametrize("name", ["psoas_l", "iliacus_r"])
def test_moment_arms_are_between_those_of_opensim_on_both_sides_of_the_jump(reference_data: Path, name: str):
    """Over 401 hip angles; OpenSim's arms change by less than 3 mm within the band but for the jump."""
    opensim = pytest.importorskip("opensim", reason="no OpenSim: pip install opensim")
    opensim.Logger.setLevelString("error")
    file = reference_data / "opensim_models" / "gait2392_millard2012muscle.osim"
    theirs = opensim.Model(str(file))
    state, hip = theirs.initSystem(), f"hip_flexion_{name[-1]}"
    coordinate, muscle = theirs.getCoordinateSet().get(hip), theirs.getMuscles().get(name)
    q, arms = np.linspace(-1.66, -1.48, 401), []
    for angle in q:
        coordinate.setValue(state, float(angle), False)
        arms.append(muscle.computeMomentArm(state, coordinate))
    ours = moment_arms(load(file, ignored=[]), hip, 0, q)
    got, expected = ours.arm[:, ours.muscles.index(name)], np.array(arms)
    assert np.abs(got).max() < 0.06
    assert np.all(got < expected.max() + 1e-3)
    assert np.all(got > expected.min() - 1e-3)
    outside = np.abs(q + 1.5708) > 0.05
    np.testing.assert_allclose(got[outside], expected[outside], atol=1e-4)
