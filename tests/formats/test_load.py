"""Scenes from names and files, in any combination; writing them; hostile input."""

import math
import shutil
import warnings
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from small_scene import muscle_scene, sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.formats import Ignored, load, save, scene_names
from warpmuscle.scene import Capsule, Ground, JointState, Objective, Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.validation.muscles import SceneWarning

SHIPPED = {
    "fwalk": ("bipV2", "fWalk"), "iwalk": ("bipV2", "iWalk"), "bwalk": ("bipV2", "bWalk"), "fjog": ("bipV2", "fJog"),
    "bigbird_walk": ("bigBird", "walk"),
}  # fmt: skip


def originals(reference_data: Path, name: str) -> tuple[Path, Path]:
    character, controller = SHIPPED[name]
    folder = reference_data / "simbicon"
    return folder / f"characters/{character}/{character}.rbs", folder / f"controllers/{character}/{controller}.sbc"


def test_shipped_scenes_are_listed_without_the_characters_that_they_share():
    names = scene_names()
    assert set(SHIPPED) < set(names)
    assert {"biped", "bigbird", "muscles56", "muscles56_fitted"}.isdisjoint(names)
    assert names == sorted(names)


@pytest.fixture(scope="module")
def shipped():
    """Every shipped scene by its name, with the doubts that were told as it was loaded."""
    found = {}
    for name in scene_names():
        with warnings.catch_warnings(record=True) as doubts:
            warnings.simplefilter("always")
            found[name] = load(name), doubts
    return found


def test_shipped_scenes_load_without_a_doubt(shipped):
    doubted = {"jog56", "jog56_search"}  # start with an elbow so bent that a biceps fitted to walking is slack
    assert {name for name, (_, doubts) in shipped.items() if doubts} <= doubted


def test_shipped_scenes_do_not_fall_where_there_is_no_ground(shipped):
    bare = [scene for scene, _ in shipped.values() if not scene.ground.stiffness]
    assert {"arm18", "throw18"} <= {scene.name for scene in bare}
    assert [s.name for s in bare if s.character.root_joint != "fixed" and "root" not in s.motion] == []


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scene_equals_the_original_files(reference_data, name):
    scene = load(name)
    plain = substitute(scene, start_values(scene))
    original = load(*originals(reference_data, name), ignored=[])
    original.name, original.description = scene.name, scene.description
    original.objective.gait = scene.objective.gait  # which the files cannot say
    for state in original.controller.states:
        state.description = ""
    assert plain == original
    assert list(plain.character.joints) == list(original.character.joints)
    assert list(plain.controller.states[0].trajectories) == list(original.controller.states[0].trajectories)


def test_scene_of_the_original_muscles_that_walk_equals_the_original_files(reference_data):
    scene = load("walk44_legacy_short_steps")
    plain = substitute(scene, start_values(scene))
    folder = reference_data / "simbicon"
    with pytest.warns(SceneWarning, match="leaves no fibre"):
        original = load(
            folder / "characters/bipV2M/bipV2M_save_allUniArticularMuscles_butHips.rbs",
            folder / "controllers/bipV2/fWalk001.sbc", ignored=[],
        )  # fmt: skip
    original.controller.states[0].description = ""
    assert plain.controller == original.controller
    assert plain.initial_state == original.initial_state
    assert len(original.character.muscles) == 44
    assert {name: plain.character.muscles[name] for name in original.character.muscles} == original.character.muscles


def test_walk_declares_its_search_space():
    parameters = free_parameters(load("fwalk"))
    names = [parameter.name for parameter in parameters]
    trajectories = "controller.states.0.trajectories"
    assert len(parameters) == 37
    assert "controller.pd.lHip.kp" in names
    assert "controller.pd.rHip.kp" not in names
    assert f"{trajectories}.SWING_Hip.components.2.feedback.cd" in names
    assert f"{trajectories}.STANCE_Knee.components.0.angle.3" in names
    for parameter in parameters:
        assert parameter.min < parameter.value < parameter.max
        steps = (parameter.value - parameter.min) / parameter.step
        assert math.isclose(steps, round(steps), abs_tol=1e-6)


def test_original_files_come_in_any_order_and_say_once_what_they_ignore(reference_data):
    character, controller = originals(reference_data, "fwalk")
    ground = reference_data / "simbicon/ground/flatGround.rbs"
    with pytest.warns(UserWarning, match="notes on what was read:") as caught:
        scene = load(controller, ground, character)
    (said,) = (one for one in caught if issubclass(one.category, UserWarning))
    assert f"{character}:6,7,8,9," in str(said.message)
    assert f"not there; took {controller.parent / 'fWalkState.rs'}" in str(said.message)
    assert (scene.name, scene.ground) == ("fWalk", Ground(height=-0.025, friction=GREATEST_NUMBER))


def test_state_file_is_found_by_the_tail_of_its_path_longest_first(reference_data, tmp_path):
    character, controller = originals(reference_data, "fwalk")
    state = controller.with_name("fWalkState.rs")
    own, near = tmp_path / "project/run", tmp_path / "project/controllers/bipV2"
    for folder in (own, near):
        folder.mkdir(parents=True)
    shutil.copy(controller, own)
    ignored: list[Ignored] = []
    with pytest.raises(SceneError, match=r"fWalk\.sbc:294: cannot find '\.\./data/controllers/bipV2/fWalkState\.rs'"):
        load(character, own / controller.name, ignored=[])
    for found in (tmp_path / "fWalkState.rs", near / "fWalkState.rs", own / "fWalkState.rs"):
        shutil.copy(state, found)
        load(character, own / controller.name, ignored=ignored)
        assert ignored[-1].reason == f"not there; took {found}" or ignored[-2].reason == f"not there; took {found}"
    shutil.copytree(near, tmp_path / "project/data/controllers/bipV2")  # now it is there as given
    ignored.clear()
    load(character, own / controller.name, ignored=ignored)
    assert not any("took" in one.reason for one in ignored)


def test_given_state_file_goes_before_the_named_one(reference_data):
    character, controller = originals(reference_data, "fwalk")
    ignored: list[Ignored] = []
    scene = load(character, controller, controller.with_name("tPose.rs"), ignored=ignored)
    assert scene.initial_state.joints["lKnee"] == JointState()
    assert any("was given instead" in one.reason for one in ignored)


@pytest.mark.parametrize("name", SHIPPED)
def test_original_files_are_written_and_read_back_equal(tmp_path, name):
    scene = load(name)
    lost: list[Ignored] = []
    save(scene, tmp_path / f"{name}.rbs", ignored=lost)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = load(*(tmp_path / f"{name}{suffix}" for suffix in (".rs", ".sbc", ".rbs")))
    others = {"description"} if scene.objective == Objective(torque=1.0) else {"description", "objective.gait"}
    scene.description, scene.objective.gait = "", Objective().gait
    assert again == substitute(scene, start_values(scene))
    assert {one.text for one in lost if "start values" not in one.reason} == others


def test_what_the_original_files_cannot_hold_is_listed(tmp_path):
    scene = sound_scene()
    scene.character.bodies["lFoot"].shapes = [Capsule((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), 0.1)]
    scene.character.root_joint = "planar"
    scene.character.joints["lHip"].limit_stiffness = 1.0
    scene.initial_state.joints["lHip"] = JointState((0.0, 0.6, 0.0, 0.8), (1.0, 2.0, 3.0))
    scene.gravity, scene.ground = 9.81, Ground(height=0.5, stiffness=1.0)
    scene.controller.heading_control = False
    with pytest.warns(UserWarning, match="these files cannot hold it"):
        save(scene, tmp_path / "a.sbc")
    lost: list[Ignored] = []
    save(scene, tmp_path / "a.sbc", ignored=lost)
    assert [one.text for one in lost] == [
        "controller.pd.lHip.kp", "name", "character.joints.lHip.limit_stiffness", "character.joints.lHip.limit_damping",
        "character.joints.rHip.limit_damping", "controller.heading_control", "ground.stiffness", "gravity",
    ]  # fmt: skip
    again = load(tmp_path / "a.rbs", tmp_path / "a.sbc")
    assert again.character.bodies == scene.character.bodies
    assert again.character.root_joint == "planar"
    assert again.controller.states == scene.controller.states
    assert again.initial_state.joints["lHip"] == scene.initial_state.joints["lHip"]


def test_errors_of_the_whole_scene_carry_file_and_line(reference_data, tmp_path):
    character, controller = originals(reference_data, "fwalk")
    text = controller.read_text().replace("trajectory SWING_Knee", "trajectory SWING_Kneee").replace("../data/", "")
    (tmp_path / "a.sbc").write_text(text)
    with pytest.raises(SceneError, match=r"a\.sbc:103: controller.*SWING_Kneee: no joint is called 'rKneee'"):
        load(character, tmp_path / "a.sbc", ignored=[])
    (tmp_path / "a.rbs").write_text(character.read_text().replace("mass 22.5", "mass 0"))
    with pytest.raises(SceneError, match=r"a\.rbs:24: character\.bodies\.torso\.mass: must be greater than 0"):
        load(tmp_path / "a.rbs", ignored=[])


@pytest.mark.parametrize(
    ("sources", "message"),
    [
        ([], "no scene given; shipped scenes: arm18, arm18_reach, back56, back56_search, bigbird_walk"),
        (["fwlk"], "there is no scene called 'fwlk'; did you mean 'fwalk'? `warpmuscle scenes` or wm."),
        (["biped"], "there is no scene called 'biped'"),
        (["/"], "a scene is read from .toml"),
        (["a.toml", "b.sbc"], "'a.toml' cannot be combined with other files"),
        (["a.sbc"], "a .rbs file with an ArticulatedFigure is needed"),
        (["nowhere.rbs"], "nowhere.rbs: there is no such file"),
        (["a.rbs", "b.sbc", "c.sbc"], "more than one .sbc file: b.sbc, c.sbc"),
    ],
)
def test_sources_that_make_no_scene(sources, message):
    with pytest.raises(SceneError) as caught:
        load(*sources)
    assert message in str(caught.value)


@pytest.mark.parametrize("name", ["a.txt", "nowhere/a.toml", "nowhere/a.rbs"])
def test_scenes_cannot_be_written_anywhere(tmp_path, name):
    with pytest.raises(SceneError, match=name):
        save(sound_scene(), tmp_path / name)


def test_nameless_characters_cannot_be_written_for_the_original(tmp_path):
    scene = sound_scene()
    scene.character.joints["a b"] = scene.character.joints.pop("rHip")
    scene.controller = None
    with pytest.raises(SceneError, match="'a b' cannot be a name in this format"):
        save(scene, tmp_path / "a.rbs")


# Hostile input: whatever the bytes, there is a scene or a SceneError of one line.


@pytest.fixture(scope="module")
def sound_files(tmp_path_factory) -> Path:
    """A folder with the small scene with muscles in every format."""
    folder, scene = tmp_path_factory.mktemp("sound"), muscle_scene()
    scene.controller.pd["lHip"].kp = Free(10.0, 5.0, 20.0, 0.5)
    scene.ground.height = -0.1
    save(scene, folder / "s.toml")
    save(scene, folder / "s.rbs", ignored=[])
    return folder


def sources(folder: Path, suffix: str) -> list[Path]:
    """The files that a scene is read from when the one with this suffix matters."""
    return [folder / "s.toml"] if suffix == ".toml" else [folder / f"s{s}" for s in (".rbs", ".sbc", ".rs")]


def check_outcome(folder: Path, suffix: str, data: bytes, sound_files: Path) -> None:
    for path in sources(sound_files, suffix):
        target = folder / path.name
        target.write_bytes(data if path.suffix == suffix else path.read_bytes())
    outcome: Scene | str
    try:
        with warnings.catch_warnings(action="ignore"):
            outcome = load(*sources(folder, suffix), ignored=[])
    except SceneError as error:
        outcome = str(error)
    assert isinstance(outcome, Scene) or (outcome and "\n" not in outcome)


@pytest.mark.parametrize("suffix", [".toml", ".rbs", ".sbc", ".rs"])
def test_arbitrary_bytes_give_a_scene_or_a_scene_error(tmp_path, sound_files, suffix):
    @settings(max_examples=60, deadline=None)
    @given(st.binary(max_size=200))
    def check(data):
        check_outcome(tmp_path, suffix, data, sound_files)

    check()


@pytest.mark.parametrize("suffix", [".toml", ".rbs", ".sbc", ".rs"])
def test_mutated_files_give_a_scene_or_a_scene_error(tmp_path, sound_files, suffix):
    sound = (sound_files / f"s{suffix}").read_bytes()
    tokens = [
        b"",
        b"\n",
        b"0",
        b"-1",
        b"nan",
        b"1e999",
        b"\xff",
        b"\0",
        b"[",
        b'"',
        b"=",
        b"/",
        b"#",
        b"x",
        *sound.split(),
    ]

    @settings(max_examples=250, deadline=None)
    @given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), st.sampled_from(tokens)), min_size=1, max_size=4))
    def check(edits):
        data = sound
        for place, length, token in edits:
            start = int(place * len(data))
            data = data[:start] + token + data[start + length :]
        check_outcome(tmp_path, suffix, data, sound_files)

    check()


@pytest.mark.parametrize("suffix", [".toml", ".rbs", ".sbc", ".rs"])
def test_files_cut_short_give_a_scene_or_a_scene_error(tmp_path, sound_files, suffix):
    lines = (sound_files / f"s{suffix}").read_bytes().splitlines(keepends=True)
    for count in range(len(lines)):
        check_outcome(tmp_path, suffix, b"".join(lines[:count]), sound_files)
        check_outcome(tmp_path, suffix, b"".join(lines[:count] + lines[count + 1 :]), sound_files)
