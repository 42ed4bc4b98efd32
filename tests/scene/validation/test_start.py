"""What is told of a start before it runs: bodies deep in the ground, speeds that no gait has."""

import re
import warnings
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from warpmuscle.cli.program import app
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, scene_names, toml
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.damping import damping_warnings
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.scene.validation.start import doubts_of, start_depths, start_warnings, warn_of_changed_starts
from warpmuscle.simulation.rollout import Rollout

FAMILIES = {
    "bipV2": ("bipV2", "bipV2M", "."), "bigBird": ("bigBird",), "raptor": ("raptor",),
}  # folders of characters by those of controllers  # fmt: skip


def sunk(name: str = "fwalk", depth: float = 0.42):
    scene = load(name)
    x, y, z = scene.initial_state.root_position
    scene.initial_state.root_position = (x, y - depth, z)
    return scene


def test_a_foot_deep_in_the_ground_is_told_with_its_depth_and_what_to_do():
    (doubt,) = start_warnings(sunk())
    assert doubt.key == "initial_state.root_position"
    assert re.fullmatch(
        r"rFoot starts 0\.42 m deep in the ground, the deepest of \d bodies, which will throw the character up; "
        r"raise the root by 0\.42 m, or lower the ground",
        doubt.message,
    )


def test_a_centre_of_mass_below_the_ground_is_told_since_it_has_fallen_at_once():
    scene = load("elbow_open_loop")
    assert not start_warnings(scene)
    scene.initial_state.root_position, scene.failure.com_height = (0.0, -3.0, 0.0), 0.9
    scene.ground.stiffness = 0.0  # else the bodies in it are told
    (doubt,) = start_warnings(scene)
    assert re.search(r"centre of mass starts \d\.\d\d m below the ground, so that it has fallen at once", doubt.message)
    scene.duration = 0.01
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] == Status.FELL
    scene.failure.com_height = 0.0
    assert not start_warnings(scene)


@pytest.mark.parametrize("root_joint", ["free", "planar"])
def test_depths_are_those_of_the_simulated_bodies(root_joint: str):
    scene = load("fwalk")
    scene.character.root_joint, scene.initial_state.heading = root_joint, 0.7
    scene.ground.normal, scene.ground.height, scene.duration = (0.1, 1.0, 0.2), -0.3, 0.01
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000)
    rollout.run()
    recording, normal = rollout.recording(), np.array(scene.ground.normal) / np.linalg.norm(scene.ground.normal)
    head = scene.character.bodies["head"].shapes[0]
    place = recording.position_of("head")[0]
    expected = scene.ground.height + head.radius - normal @ (place + np.array(head.center))
    assert start_depths(scene)["head"] == pytest.approx(expected, abs=0.01)  # the head is upright, but for some degrees


def raised_ground(scene):
    scene.ground.height = 0.3


def thick_head(scene):
    scene.character.bodies["head"].shapes[0].radius = 3.0


def long_shank(scene):
    x, y, z = scene.character.joints["lAnkle"].position_in_parent
    scene.character.joints["lAnkle"].position_in_parent = (x, y - 0.4, z)


def fast_root(scene):
    scene.initial_state.root_velocity = (0.0, 0.0, 99.0)


def low_limit(scene):
    scene.failure.max_com_speed = 0.1


@pytest.mark.parametrize("change", [raised_ground, thick_head, long_shank, fast_root, low_limit])
def test_whatever_a_sweep_changes_of_a_start_is_looked_at(change):
    as_it_was, alike, changed = load("fwalk"), load("fwalk"), load("fwalk")
    alike.objective.speed = 3.0
    change(changed)
    with pytest.warns(SceneWarning) as told:
        warn_of_changed_starts("sweep.toml", [("a", alike), ("b", changed), ("c", changed)], [as_it_was])
    assert [str(one.message).split(": ")[:2] for one in told] == [["sweep.toml", "b"]]


def test_no_shipped_scene_starts_in_doubt():
    for name in scene_names():
        scene = load(name)
        assert not [*start_warnings(scene), *damping_warnings(scene)], name


def test_a_file_says_it_with_its_line_when_it_is_loaded_and_when_it_is_changed(tmp_path: Path):
    path = tmp_path / "sunk.toml"
    toml.write(sunk(), path)
    line = next(n for n, text in enumerate(path.read_text().splitlines(), 1) if text.startswith("root_position"))
    with pytest.warns(SceneWarning, match=rf"sunk\.toml:{line}: initial_state\.root_position: rFoot starts 0\.42 m"):
        load(path)
    said = CliRunner().invoke(app, ["info", "fwalk", "--set", "ground.height=0.42"])
    assert said.exit_code == 0
    assert "0.42 m deep in the ground" in " ".join(said.output.split())


def test_a_start_faster_than_any_gait_is_told():
    scene = load("fwalk")
    scene.initial_state.root_velocity = (0.0, 0.0, 53.0)
    (doubt,) = start_warnings(scene)
    assert doubt.key == "initial_state.root_velocity"
    assert "53 m/s" in doubt.message
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert (rollout.status()[0], rollout.end_time()[0]) == (Status.DIVERGED, 0.0)


@pytest.mark.parametrize("family", FAMILIES)
def test_files_of_the_original_program_run_or_are_refused_with_file_and_line(
    family: str, reference_data: Path, request: pytest.FixtureRequest
):
    """Every character with every controller and every state of its kind; none ends at its start or flies."""
    if family == "raptor":  # of which no scene is shipped
        request.getfixturevalue("unoptimized_test")
    folder = reference_data / "simbicon"
    characters = [file for place in FAMILIES[family] for file in sorted((folder / "characters" / place).glob("*.rbs"))]
    controllers = sorted((folder / "controllers" / family).glob("*.sbc"))
    states = [None, *sorted(folder.glob(f"c*/{family}/*.rs"))]
    ran, refusals = 0, list[str]()
    for character, controller, state in product(characters, controllers, states):
        if state is not None and character.parent.name == "bipV2M":
            continue  # its skeleton is that of bipV2
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                scene = load(character, controller, *[state] * (state is not None))
        except SceneError as error:
            refusals.append(str(error))
            continue
        scene.duration = 0.1
        rollout = Rollout(scene, 1, "cpu", record=[0])
        rollout.run()
        ran += 1
        assert rollout.status()[0] in (Status.COMPLETED, Status.FELL), (character, controller, state)
        assert rollout.end_time()[0] > 0.0
        assert np.abs(rollout.recording().com_velocity).max() < 3.0
    assert ran >= len(controllers)
    assert all(re.fullmatch(r"\S+\.(rbs|sbc|rs):\d+: .+", refusal) for refusal in refusals), refusals


def test_negative_weights_of_parts_of_ones_own_are_told_with_their_key():
    scene = load("fwalk")
    scene.objective.custom = {"m:near": -1.0, "m:far": 1.0, "m:free": Free(0.5, min=-1.0, max=1.0), "m:follows": 0.0}
    doubts = [doubt for doubt in doubts_of(scene) if "negative weight" in doubt.message]
    assert [doubt.key for doubt in doubts] == ["objective.custom.m:near", "objective.custom.m:free"]
    assert all('declare sign="earned"' in doubt.message for doubt in doubts)
