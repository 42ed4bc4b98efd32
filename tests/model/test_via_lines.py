"""Via points on lines: where they are, in a simulation, in files, and what a search may do with them."""

import numpy as np
import pytest

from muscle_arm import arm
from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored, load, mjcf, save, toml
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.muscles import driven
from warpmuscle.model.path_table import path_table
from warpmuscle.model.paths import paths_struct
from warpmuscle.scene import Condition, Scene, ViaPoint
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import moment_arms

START, END = (0.01, 0.08, 0.03), (-0.02, 0.14, 0.07)
LINE = {"start": START, "end": END}
KEY = "character.muscles.flexor.path.1"


def on_line(at: float) -> tuple[float, ...]:
    return tuple((np.array(START) + at * (np.array(END) - START)).tolist())


def with_point(point: ViaPoint, kind: str = "hinge") -> Scene:
    """The arm, whose flexor leaves the upper body at another point."""
    scene = arm(kind)
    scene.character.muscles["flexor"].path[1] = point
    return scene


def segment_ends(scene: Scene, values: np.ndarray) -> np.ndarray:
    """Ends of all segments (n, segments, 2, 3) of the scene's paths for parameter values (n, P)."""
    character = substitute(scene, values).character
    paths = {name: muscle.path for name, muscle in character.muscles.items()}
    names = topology(character)
    table = path_table(paths, names, character)
    ends = paths_struct(table, grouped_paths(table, names, character), names, character, "cpu").ends.numpy()
    return np.stack([ends["a"], ends["b"]], axis=2)


def test_each_instance_has_its_point_at_its_own_place_on_the_line():
    line = ViaPoint("base", start=START, end=(END[0], Free(END[1], 0.0, 1.0), END[2]), at=Free(0.5, 0.0, 1.0))
    scene = with_point(line)
    assert [(p.name, p.unit) for p in free_parameters(scene)] == [(f"{KEY}.end.1", "m"), (f"{KEY}.at", "")]
    at = np.array([0.0, 0.3, 0.5, 1.0])
    many = segment_ends(scene, np.stack([np.full(4, END[1]), at], axis=1))
    for i in range(4):
        alone = segment_ends(with_point(ViaPoint("base", on_line(at[i]))), np.zeros(0))
        np.testing.assert_allclose(many[i], alone[0], atol=1e-8)
    moved = segment_ends(scene, np.array([[0.3, 0.5]]))
    expected = segment_ends(with_point(ViaPoint("base", (-0.005, 0.19, 0.05))), np.zeros(0))
    np.testing.assert_allclose(moved, expected, atol=1e-8)


def test_length_within_a_body_follows_the_point():
    scene = with_point(ViaPoint("base", **LINE, at=Free(0.5, 0.0, 1.0)))
    rollout = Rollout(scene, 3, "cpu")
    at = np.array([0.0, 0.25, 1.0])
    rollout.set_parameters(at[:, None])
    origin = np.array(scene.character.muscles["flexor"].path[0].position)
    expected = [np.linalg.norm(np.array(on_line(value)) - origin) for value in at]
    np.testing.assert_allclose(rollout.model.paths.fixed_length.numpy()[:, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("at", [0.0, 0.4, 1.0])
def test_moment_arm_is_that_of_the_position(at: float):
    angles = np.linspace(-0.5, 0.5, 5)
    on = moment_arms(with_point(ViaPoint("base", **LINE, at=at)), "elbow", 0, angles).arm
    placed = moment_arms(with_point(ViaPoint("base", on_line(at))), "elbow", 0, angles).arm
    np.testing.assert_allclose(on, placed, atol=1e-7)


def test_moment_arm_grows_as_the_point_moves_away_from_the_joint():
    arms = []
    for at in (0.0, 0.5, 1.0):
        line = ViaPoint("base", start=(0.0, 0.1, 0.02), end=(0.0, 0.1, 0.08), at=Free(at, 0.0, 1.0))
        arms.append(abs(moment_arms(with_point(line), "elbow", 0, np.zeros(1)).arm[0, 0]))
    assert arms[0] < arms[1] < arms[2]


def test_a_conditional_point_may_be_on_a_line():
    lengths = []
    for place in ({"position": on_line(0.4)}, {**LINE, "at": 0.4}):
        scene = with_point(ViaPoint("base", condition=Condition("elbow", -0.5, 0.5), **place))
        stages = Stages(scene, 1, "cpu")
        lengths.append(stages.muscle_paths().length)
    np.testing.assert_allclose(*lengths, atol=1e-7)


def test_points_on_both_sides_may_share_one_place():
    scene = with_point(ViaPoint("base", **LINE, at=Free(0.2, 0.0, 1.0)))
    scene.character.muscles["extensor"].path[1] = ViaPoint("base", **LINE, at=Free(same_as=f"{KEY}.at"))
    ends = segment_ends(scene, np.array([[0.7]]))[0].reshape(2, 2, 3)
    np.testing.assert_array_equal(ends[0, 0], ends[1, 0])


@pytest.mark.parametrize(
    ("point", "key", "message"),
    [
        (ViaPoint("base"), "", "missing key 'position' (or `start`, `end` and `at` of a line)"),
        (
            ViaPoint("base", START, at=0.5),
            "",
            "either `position`, or a line with `start`, `end` and `at`, not `at` too",
        ),
        (ViaPoint("base", START, start=START), "", "not `start` too"),
        (ViaPoint("base", start=START, at=0.5), "", "a line needs `start`, `end` and `at`; missing key 'end'"),
        (ViaPoint("base", **LINE), "", "missing key 'at'"),
        (ViaPoint("base", **LINE, at=1.5), ".at", "must be within 0 and 1, is 1.5"),
        (ViaPoint("base", **LINE, at=Free(0.5, -0.5, 1.0)), ".at", "must be within 0 and 1, is -0.5"),
        (ViaPoint("base", start=(0.0, np.inf, 0.0), end=END, at=0.5), ".start.1", "not a finite number"),
    ],
)
def test_a_point_has_either_a_position_or_a_whole_line(point: ViaPoint, key: str, message: str):
    with pytest.raises(SceneError) as caught:
        check_scene(with_point(point))
    assert caught.value.key == KEY + key
    assert message in str(caught.value)


def test_errors_name_file_line_and_key(tmp_path):
    text = toml.dumps(with_point(ViaPoint("base", **LINE, at=0.25)))
    for new, key, line in (
        ("at = 2\n", f"{KEY}.at", "at = 2"),
        ("", KEY, "[[character.muscles.flexor.path]]"),
        ("position = [0, 0, 0]\nat = 0.25\n", KEY, "[[character.muscles.flexor.path]]"),
    ):
        broken = text.replace("at = 0.25\n", new)
        assert broken != text
        (tmp_path / "a.toml").write_text(broken)
        with pytest.raises(SceneError, match=rf"a\.toml:\d+: {KEY}") as caught:
            toml.read(tmp_path / "a.toml")
        assert (caught.value.key, broken.splitlines()[caught.value.line - 1]) == (key, line)


def test_lines_are_read_back_equal():
    scene = with_point(ViaPoint("base", **LINE, at=Free(0.1, 0.0, 1.0, 0.05)))
    scene.character.muscles["extensor"].path[1] = ViaPoint("base", **LINE, at=Free(same_as=f"{KEY}.at", factor=0.5))
    assert toml.loads(toml.dumps(scene)) == scene


def test_other_formats_get_the_position(tmp_path):
    scene = muscle_scene()
    path = scene.character.muscles["HFL"].path
    path[0] = ViaPoint("pelvis", start=START, end=END, at=Free(0.5, 0.0, 1.0))
    expected = on_line(0.5)
    lost: list[Ignored] = []
    save(scene, tmp_path / "a.rbs", ignored=lost)
    key = "character.muscles.HFL.path.0"
    assert [one.text for one in lost if one.text.startswith(key)] == [f"{key}.at", key]
    again = load(tmp_path / "a.rbs", ignored=[]).character.muscles["HFL"].path[0]
    np.testing.assert_allclose(again.position, expected, atol=1e-12)
    assert f'pos="{" ".join(map(repr, expected))}"' in mjcf.dumps(scene)
    assert path[0].position is None


def test_points_on_lines_count_for_what_drives_the_joints():
    scene = with_point(ViaPoint("base", **LINE, at=0.5))
    assert driven(scene, topology(scene.character)).muscles == ("flexor", "extensor")
