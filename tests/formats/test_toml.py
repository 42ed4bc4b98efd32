"""Scenes as TOML: what is written is read back equal, and errors know file, line and key."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.formats import load, toml
from warpmuscle.formats.simbicon import sbc_text
from warpmuscle.formats.toml_lines import key_lines
from warpmuscle.scene import PD, MachineState, Scene, SearchStage, Trajectory
from warpmuscle.scene.number import Free

CHARACTER = """root = "pelvis"
[bodies]
pelvis = { mass = 10, inertia = [1, 1, 1] }
leg = { mass = 1, inertia = [1, 1, 1] }

[joints.hip]
type = "hinge"
parent = "pelvis"
child = "leg"
position_in_parent = [0, 0, 0]
position_in_child = [0, 0, 0]
axes = [
    [1, 0, 0],
]
"""


def write(folder: Path, scene: str, character: str = CHARACTER) -> Path:
    (folder / "leg.toml").write_text(character)
    (folder / "scene.toml").write_text(scene)
    return folder / "scene.toml"


def round_trip(folder: Path, scene: Scene) -> Scene:
    toml.write(scene, folder / "a.toml")
    return toml.read(folder / "a.toml")


def test_small_scene_is_read_back_equal(tmp_path):
    assert round_trip(tmp_path, sound_scene()) == sound_scene()


def test_free_numbers_ties_and_long_lists_are_read_back_equal(tmp_path):
    scene = sound_scene()
    component = scene.controller.states[0].trajectories["SWING_Hip"].components[0]
    component.phase = [index / 64 for index in range(64)]
    component.angle = [Free(index / 3, 0.0, 1e3, 0.1) if index % 2 else 1e-17 * index for index in range(64)]
    scene.controller.pd["root"].kd = Free(same_as="controller.pd.lHip.kp")
    scene.ground.height = Free(-1e-7, -0.1, 0.0)
    assert round_trip(tmp_path, scene) == scene


def test_stages_of_a_search_are_read_back_equal_and_their_errors_know_the_line(tmp_path):
    scene = sound_scene()
    scene.stages = [
        SearchStage("survive", {"torque": 0.0, "metabolic_model": "bhargava"}, {"body_contact": True}, 3.0, target=0.0),
        SearchStage('walk "on"', {"speed": 1.5}, {"com_height": 1}, free=["controller.*", "*.kp"], candidates=0.25),
        SearchStage("save", strategy="cma", population=7, sigma=0.1, restarts="ipop", searches=2, until=60.0),
    ]
    assert round_trip(tmp_path, scene) == scene
    scene.stages = scene.stages[2:]
    assert round_trip(tmp_path, scene) == scene
    text = 'name = "s"\ncharacter = "leg.toml"\n[[stages]]\nname = "a"\n[[stages]]\nname = "b"\n[stages.objective]\n'
    with pytest.raises(
        SceneError, match=r"scene\.toml:8: stages\.1\.objective\.sped: unknown key; did you mean 'speed'"
    ):
        toml.read(write(tmp_path, f"{text}sped = 1\n"))
    with pytest.raises(SceneError, match=r"scene\.toml:8: stages\.1\.objective\.speed: expected .*, got a table"):
        toml.read(write(tmp_path, f"{text}speed = {{ value = 1, min = 0, max = 2 }}\n"))
    assert toml.read(write(tmp_path, f"{text}speed = 1\n")).stages[1] == SearchStage("b", {"speed": 1.0})


def test_phase_up_to_which_a_state_waits_is_read_back_equal_and_refused_where_the_file_cannot_say_it(tmp_path):
    scene = sound_scene()
    scene.controller.states[0].longest = Free(1.3, 1.0, 1.5)
    assert round_trip(tmp_path, scene) == scene
    scene.controller.states[0].longest, scene.controller.pd = 1.3, {}
    with pytest.raises(SceneError, match=r"states\.0\.longest: this format has no states that last beyond"):
        sbc_text(scene.controller)


def test_trajectories_bodies_and_joints_keep_their_order(tmp_path):
    scene = sound_scene()
    moving = scene.controller.states[0].trajectories.pop("SWING_Hip")
    scene.controller.states.append(MachineState(0.1, {"rHip": Trajectory(), "SWING_Hip": moving, "lHip": Trajectory()}))
    again = round_trip(tmp_path, scene)
    assert list(again.controller.states[1].trajectories) == ["rHip", "SWING_Hip", "lHip"]
    assert again == scene


def test_text_is_read_like_a_file():
    assert toml.loads(toml.dumps(sound_scene())) == sound_scene()
    with pytest.raises(SceneError, match=r"^<text>:2: gravity: expected a number, got text"):
        toml.loads('name = "x"\ngravity = "g"\n[character]\nroot = "a"\nbodies = {a = {mass = 1, inertia = [1, 1, 1]}}')


def test_nesting_of_any_depth_is_borne_or_refused():
    for depth in (*range(100, 1000, 37), 10000, 100000):
        for nested in ("[" * depth + "]" * depth, "{a = " * depth + "1" + "}" * depth):
            with pytest.raises(SceneError, match=r"the limit `nesting`|too deeply"):
                toml.loads(f"name = 'x'\nx = {nested}\n")


def test_numbers_are_written_without_noise():
    text = toml.dumps(sound_scene())
    assert "inertia = [0.1, 0.1, 0.1]" in text
    assert "mass = 10\n" in text or "mass = 10," in text
    assert "stance_hip_max_velocity" not in text  # a default


@settings(max_examples=60, deadline=None)
@given(
    text=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12),
    name=st.text(st.characters(exclude_categories=["Cs"]), max_size=6).filter(
        lambda name: name != "lHip" and "\0" not in name
    ),
    number=st.floats(-GREATEST_NUMBER, GREATEST_NUMBER),
)
def test_any_text_name_and_number_is_read_back_equal(tmp_path_factory, text, name, number):
    scene = sound_scene()
    scene.description, scene.gravity = text, number
    scene.character.joints = {name if key == "rHip" else key: j for key, j in scene.character.joints.items()}
    scene.controller = None
    if name != "root":
        assert round_trip(tmp_path_factory.getbasetemp(), scene) == scene


def test_character_may_be_another_file_beside_the_scene(tmp_path):
    scene = toml.read(write(tmp_path, 'name = "x"\ncharacter = "leg.toml"\n'))
    assert list(scene.character.bodies) == ["pelvis", "leg"]


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ('name = "x"\nname = "y"\n', "scene.toml:2: not valid TOML: "),
        ('name = "x"\ncharacter = "leg.toml"\n[ground\n', "scene.toml:3: not valid TOML: "),
        (
            'name = "x"\ncharacter = "leg.toml"\n[ground]\nheigth = 1\n',
            "scene.toml:4: ground.heigth: unknown key; did",
        ),
        ('name = "x"\ncharacter = "leg.toml"\ngravity = "9.8"\n', "scene.toml:3: gravity: expected a number, got text"),
        ('name = "x"\n', "scene.toml: missing key 'character'"),
        ('name = "x"\ncharacter = 3\n', "scene.toml:2: character: expected a table, got a whole number"),
        ('name = "x"\ncharacter = "nose.toml"\n', "nose.toml: there is no such file"),
        (
            'name = "x"\ncharacter = "leg.toml"\ngravity = { value = 3, min = 4, max = 5 }\n',
            "toml:3: gravity: value 3 is",
        ),
        (
            'name = "x"\ncharacter = "leg.toml"\ntime_step = inf\n',
            "scene.toml:3: time_step: inf is not",
        ),
        ('name = "x"\ncharacter = "leg.toml"\nduration = 9' + "9" * 400, "duration: "),
        ('name = "x"\ncharacter = "leg.toml"\nduration = 9' + "9" * 5000, "scene.toml: not valid TOML"),
        ('name = "x"\ncharacter = "leg.toml"\nx = ' + "[" * 5000 + "]" * 5000, "nested too deeply"),
        (
            'name = "x"\ncharacter = "leg.toml"\n[initial_state.joints."hip"]\norientation = [\n 0,\n 0, "a", 1]\n',
            "scene.toml:6: initial_state.joints.hip.orientation.2: expected a number, got text",
        ),
    ],
)
def test_errors_in_a_scene_name_file_line_and_key(tmp_path, scene, message):
    with pytest.raises(SceneError) as caught:
        toml.read(write(tmp_path, scene))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '"hinge"',
            '"hing"',
            "leg.toml:7: character.joints.hip.type: 'hing' is none of 'ball', 'coupled', 'fixed', 'hinge'",
        ),
        ('parent = "pelvis"', 'parent = "pelvs"', "leg.toml:8: character.joints.hip.parent: no body is called 'pelvs'"),
        ("[1, 0, 0],\n]", "[0, 0, 0],\n]", "leg.toml:13: character.joints.hip.axes.0: axis has no length"),
        ("mass = 1,", "", "leg.toml:4: character.bodies.leg: missing key 'mass'"),
        ('root = "pelvis"', "", "leg.toml: character: missing key 'root'"),
    ],
)
def test_errors_in_a_character_name_its_own_file(tmp_path, old, new, message):
    assert old in CHARACTER
    with pytest.raises(SceneError) as caught:
        toml.read(write(tmp_path, 'name = "x"\ncharacter = "leg.toml"\n', CHARACTER.replace(old, new)))
    assert message in str(caught.value)


def test_unreadable_files_are_scene_errors(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"name = 1\n# caf\xe9\n")
    cases = ((tmp_path, "this is a folder"), (tmp_path / "no.toml", "no such"), (Path("a\0.toml"), "cannot be opened"))
    for path, message in cases:
        with pytest.raises(SceneError, match=message):
            toml.read(path)
    with pytest.raises(SceneError, match=r"latin\.toml:2: not UTF-8 text"):
        toml.read(tmp_path / "latin.toml")


def test_an_unsound_scene_is_not_written_over_an_old_file(tmp_path):
    toml.write(sound_scene(), tmp_path / "a.toml")
    before = (tmp_path / "a.toml").read_text()
    broken = sound_scene()
    broken.duration = -1.0
    with pytest.raises(SceneError):
        toml.write(broken, tmp_path / "a.toml")
    assert (tmp_path / "a.toml").read_text() == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


def test_lines_of_keys_of_every_kind_are_found():
    text = "\n".join([
        "# comment [x]", "a.b = 1", "[t.'q q']", '"c\\u0041" = { d = [1,', " { e = '''", "]'''}], f = 2 }", "[[l]]",
        "m = 1", "[[l]]", "[l.n]", 'o = """x"""" # c',
    ])  # fmt: skip
    lines = key_lines(text)
    assert lines[("a",)] == lines[("a", "b")] == 2
    assert lines[("t", "q q", "cA", "d", "0")] == 4
    assert lines[("t", "q q", "cA", "d", "1", "e")] == 5
    assert lines[("t", "q q", "cA", "f")] == 6
    assert lines[("l", "0", "m")] == 8
    assert lines[("l", "1", "n", "o")] == 11


def test_lines_of_long_lists_are_counted_once():
    """From the start for each item, those of a list of some megabytes would take hours."""

    class Counted(str):
        looked_at = 0

        def replace(self, *_: object) -> "Counted":
            return self

        def count(self, what: str, start: int, end: int) -> int:
            Counted.looked_at += end - start
            return super().count(what, start, end)

    text = Counted("a = [\n" + "1,\n" * 1000 + "]\nb = 2\n")
    lines = key_lines(text)
    assert (lines["a", "999"], lines["b",]) == (1001, 1003)
    assert Counted.looked_at <= len(text)


def test_a_scene_anywhere_may_be_based_on_a_shipped_one(tmp_path):
    for base in ("fwalk", "fwalk.toml"):
        (tmp_path / "mine.toml").write_text(f'name = "mine"\nbase = "{base}"\ncharacter = ["biped.toml"]\n')
        assert toml.read(tmp_path / "mine.toml").character == load("fwalk").character


def test_a_file_beside_the_scene_goes_before_a_shipped_one(tmp_path):
    (tmp_path / "fwalk.toml").write_text(toml.dumps(load("iwalk")))
    (tmp_path / "mine.toml").write_text('name = "mine"\nbase = "fwalk.toml"\n')
    assert toml.read(tmp_path / "mine.toml").controller == load("iwalk").controller


def test_numbers_that_go_through_points_are_written_as_they_are_read(tmp_path):
    scene = sound_scene()
    scene.controller.pd["root"] = PD(Free(same_as="controller.pd.lHip.kp", through=((5.0, 1.0), (20.0, 3.5))), 1.0)
    toml.write(scene, tmp_path / "a.toml")
    assert toml.read(tmp_path / "a.toml") == scene
