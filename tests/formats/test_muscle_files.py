"""Muscles in the files of the original program and in TOML: read, written, doubted."""

import re
import warnings

import pytest

from small_scene import X, muscle_scene
from warpmuscle.formats import Ignored, load, save, toml
from warpmuscle.formats.toml_layout import layout
from warpmuscle.scene import Actuation, InitialState, Muscle, ViaPoint
from warpmuscle.scene.validation.muscles import SceneWarning

MUSCLES = {
    "bipV2M/bipV2M_save_allUniArticularMuscles": 56,
    "bipV2M/bipV2M_save_allUniArticularMuscles_butHips": 44,
    "bipV2M/bipV2M_save_lowerBodyUniArticular": 28,
    "bipV3": 2,
}


@pytest.mark.filterwarnings("ignore::warpmuscle.scene.validation.muscles.SceneWarning")
@pytest.mark.parametrize("keyword_rule", [False, True])
@pytest.mark.parametrize("name", MUSCLES)
def test_muscles_survive_both_formats(reference_data, tmp_path, name, keyword_rule):
    scene = load(reference_data / f"simbicon/characters/{name}.rbs", ignored=[], keyword_rule=keyword_rule)
    assert len(scene.character.muscles) == MUSCLES[name]
    lost: list[Ignored] = []
    save(scene, tmp_path / f"{scene.name}.rbs", ignored=lost)
    save(scene, tmp_path / "a.toml")
    assert lost == []
    assert load(tmp_path / "a.toml") == scene
    again = load(tmp_path / f"{scene.name}.rbs", tmp_path / f"{scene.name}.rs", ignored=lost, keyword_rule=keyword_rule)
    assert lost == []
    assert (again.character, again.actuation) == (scene.character, scene.actuation)
    assert list(again.character.muscles) == list(scene.character.muscles)


@pytest.mark.filterwarnings("ignore::warpmuscle.scene.validation.muscles.SceneWarning")
def test_muscles_drive_all_joints_that_they_cross_or_only_those_that_are_marked(reference_data):
    file = reference_data / "simbicon/characters/bipV2M/bipV2M_save_allUniArticularMuscles.rbs"
    ignored: list[Ignored] = []
    crossed = load(file, ignored=ignored)
    assert crossed.actuation == {}
    assert sum(one.text.startswith("actuationType") for one in ignored) == 8
    ignored.clear()
    marked = load(file, ignored=ignored, keyword_rule=True)
    assert not any(one.text.startswith("actuationType") for one in ignored)
    assert all(own == Actuation("torque") for own in marked.actuation.values())
    legs = {f"{side}{joint}" for side in "lr" for joint in ("Hip", "Knee", "Ankle", "ToeJoint")}
    assert set(marked.actuation) == set(marked.character.joints) - legs
    assert crossed.character == marked.character
    assert crossed.controller is None
    assert crossed.initial_state == InitialState(root_position=(0.0, 1.035, 0.0))


def test_fixed_joints_stay_undriven_by_the_keyword_rule(tmp_path):
    scene = muscle_scene()
    scene.character.joints["rHip"].type, scene.character.joints["rHip"].axes = "fixed", []
    scene.character.joints["rHip"].limits = []
    scene.controller, scene.actuation = None, {"lHip": Actuation("torque")}
    save(scene, tmp_path / "a.rbs", ignored=[])
    assert load(tmp_path / "a.rbs", ignored=[], keyword_rule=True).actuation == scene.actuation


def test_slack_lengths_that_leave_no_fibre_are_warned_about_with_file_and_line(reference_data, tmp_path):
    file = reference_data / "simbicon/characters/bipV2M/bipV2M_save_lowerBodyUniArticular.rbs"
    with pytest.warns(SceneWarning) as caught:
        scene = load(file, ignored=[])
    texts = [str(warning.message) for warning in caught]
    assert len(texts) == 4
    assert texts[0] == (
        f"{file}:718: character.muscles.lToeFlex.l_slack: slack length 0.2 m leaves no fibre in the initial pose, "
        "where the path is 0.17 m; 0.153 m would fit (path minus l_opt)"
    )
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        save(scene, tmp_path / "a.rbs", ignored=[])  # says nothing of what the caller was told before
        save(scene, tmp_path / "a.toml")
    with pytest.warns(SceneWarning) as caught:
        load(tmp_path / "a.toml")
    pattern = r"a\.toml:\d+: character\.muscles\.[lr]Toe(Flex|Ext)\.l_slack: slack length 0\.2 m"
    assert all(re.search(pattern, str(warning.message)) for warning in caught)
    scene.muscle_model.legacy = True
    save(scene, tmp_path / "a.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(tmp_path / "a.toml")


def test_slack_lengths_are_blamed_on_the_file_that_says_them(tmp_path):
    scene = muscle_scene()
    (tmp_path / "character.toml").write_text(layout(scene.character))
    (tmp_path / "fitted.toml").write_text("[muscles]\nTFL.l_slack = 0.2\nHFL.l_slack = 0.5\n")
    (tmp_path / "a.toml").write_text(toml.dumps(scene, ["character.toml", "fitted.toml"]))
    with pytest.warns(SceneWarning, match=r"fitted\.toml:3: character\.muscles\.HFL\.l_slack"):
        load(tmp_path / "a.toml")


def test_what_the_original_files_cannot_hold_of_muscles_is_listed(tmp_path):
    scene = muscle_scene()
    scene.controller = None
    scene.actuation["lHip"] = Actuation(["muscle", "assisted", "torque"])
    scene.muscle_model.rise_time = 0.02
    lost: list[Ignored] = []
    save(scene, tmp_path / "small.rbs", ignored=lost)
    texts = [one.text for one in lost if "limit_damping" not in one.text]
    point = "character.muscles.TFL.path.1.condition"
    excitation = "character.muscles.TFL.excitation"
    for key in (
        f"{point}.joint", f"{point}.low", "character.muscles.TFL.pennation", f"{excitation}.time.1",
        f"{excitation}.value.0", "actuation.rHip.stiffness", "actuation.lHip.drive.1", "muscle_model.rise_time",
    ):  # fmt: skip
        assert key in texts
    assert all(text.startswith((point, "character.muscles.TFL", "actuation.", "muscle_model.rise")) for text in texts)
    again = load(tmp_path / "small.rbs", ignored=[])
    assert again.character.muscles["HFL"] == scene.character.muscles["HFL"]


def test_joints_that_muscles_drive_are_marked_where_the_scene_restricts_them(tmp_path):
    scene, lost = muscle_scene(), list[Ignored]()
    scene.character.muscles["TFL"] = Muscle(
        path=[ViaPoint("lFoot", X), ViaPoint("lToes", X)], f_max=1.0, l_opt=1.0, l_slack=0.0
    )
    scene.actuation = {}
    save(scene, tmp_path / "small.rbs", ignored=lost)
    assert "actuationType" not in (tmp_path / "small.rbs").read_text()
    scene.actuation = {"lHip": Actuation("torque"), "lToe": Actuation("muscle"), "rHip": Actuation("torque")}
    lost.clear()
    save(scene, tmp_path / "small.rbs", ignored=lost)
    assert not any(one.text.startswith("actuation") for one in lost)
    again = load(tmp_path / "small.rbs", ignored=[], keyword_rule=True)
    assert again.actuation == {"lHip": Actuation("torque"), "rHip": Actuation("torque")}
    with pytest.warns(UserWarning, match="muscles drive all joints that they cross"):
        assert load(tmp_path / "small.rbs").actuation == {}
