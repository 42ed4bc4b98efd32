"""Conditional points that would let a path jump come in over a band, unless they shall come in as OpenSim's."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from warpmuscle.formats import Ignored, load
from warpmuscle.scene import JointState, Scene
from warpmuscle.simulation.stages import Stages

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
