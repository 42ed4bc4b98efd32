"""Descriptions of creatures become scenes; what is wrong with one is a line with file, line and key."""

import numpy as np
import pytest

from small_creature import small_creature
from warpmuscle.core.errors import SceneError
from warpmuscle.creatures.build import creature_scene, read_creature
from warpmuscle.creatures.gait import weight_height
from warpmuscle.examples import EXAMPLES
from warpmuscle.formats import toml
from warpmuscle.formats.toml_layout import layout
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.parameters import free_parameters, start_values, substitute

TEXT = layout(small_creature())
FILES = dict(EXAMPLES["creatures"].make())
FOUND = [name for name in FILES if name.endswith("_found.toml")]
DESCRIBED = [(name, text) for name, text in FILES.items() if name not in FOUND]


def test_a_description_is_read_as_it_was_written(tmp_path):
    (tmp_path / "small.toml").write_text(TEXT)
    assert read_creature(tmp_path / "small.toml") == small_creature()


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ('parent = "trunk"', 'parent = "trank"', "segments.Leg.parent", "did you mean 'trunk'?"),
        ('parent = "trunk"', "", "segments", "one segment alone has no parent"),
        ('parent = "trunk"', 'parent = "Foot"', "segments.Leg.parent", "hangs on itself"),
        ("range = [-0.8, 0.6]", "range = [0.2, 0.6]", "segments.Leg.range", "the standing pose, 0"),
        ("range = [-0.8, 0.6]", "range = [0.6, -0.8]", "segments.Leg.range", "low 0.6 is greater than high -0.8"),
        ("radius = 0.1\n", "radius = nan\n", "segments.trunk.radius", "greater than 0"),
        ("mass = 30", "mass = 0", "segments.trunk.mass", "greater than 0"),
        ("f_max = [1000, 1000]", "f_max = [0, 1000]", "muscles.Long.f_max", "greater than 0"),
        ("f_max = [1000, 1000]", "f_max = [1000]", "muscles.Long.f_max", "2"),
        ("start = [0.1, 0.65, -0.02]", "start = [0.1, 0.85, -0.02]", "muscles.Back.path.1.start.1", "outside of its"),
        ('joint = "Hip", side', 'joint = "Hop", side', "muscles.Back.over.0.joint", "did you mean 'Hip'?"),
        ("radius = [0.02, 0.06]", "radius = [0.02, 0.2]", "muscles.Back.path.0.low", "comes within 0.112 m of"),
        ('hips = "Hip"', 'hips = "trunk"', "gait.hips", "no pair of joints"),
        ("speed = 1", "speed = -1", "gait.speed", "greater than 0"),
        ('kind = "walk"', 'kind = "fly"', "gait.kind", "hop"),
        ("Hip = [-0.1, -0.4]", "Hip = []", "gait.swing.Hip", "at least one angle"),
        ("lHip = -0.2", "lHup = -0.2", "gait.start.lHup", "did you mean 'lHip'?"),
        ("[segments.trunk]", '[segments.lLeg]\nparent = "trunk"\nstart = [0, 1, 0]\nend = [0, 1.1, 0]\nradius = 0.1\n\n'
         "[segments.trunk]", "segments.Leg", "the body would be called 'lLeg', as that of segments.lLeg is"),
        ('joint = "Ankle"', 'joint = "hip"', "segments.Foot.joint", "called 'lHip', as that of segments.Leg is"),
        ("[muscles.Front]", "[muscles.long]", "muscles.Long", "would be called 'lLong', as that of muscles.long"),
        ("density = 1000", "density = 1000\nwings = 2", "wings", "wings"),
    ],
)  # fmt: skip
def test_what_is_wrong_has_its_line_and_key(tmp_path, old, new, key, words):
    file = tmp_path / "small.toml"
    assert old in TEXT
    file.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(SceneError) as caught:
        read_creature(file)
    assert words in str(caught.value)
    assert caught.value.key == key
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_low_root_is_refused_where_the_controller_would_have_no_strength():
    creature = small_creature()
    creature.segments["trunk"].start, creature.segments["trunk"].end = (0, 0.3, 0), (0, 0.4, 0)
    with pytest.raises(SceneError, match=r"at least 0\.45 m high"):
        creature_scene(creature)


@pytest.mark.parametrize(("file", "text"), DESCRIBED, ids=[name for name, _ in DESCRIBED])
def test_shipped_descriptions_make_scenes_that_start_on_the_ground(tmp_path, file, text):
    (tmp_path / file).write_text(text)
    scene = creature_scene(read_creature(tmp_path / file))
    read = toml.loads(toml.dumps(scene))
    assert read == scene
    numeric = substitute(scene, start_values(scene))
    assert lowest_point(numeric.character, world_poses(numeric)) == pytest.approx(0.001, abs=1e-8)
    kinds = {"position", "radius", "f_max", "l_opt", "l_slack", "kp", "angle"}
    assert kinds <= {part for p in free_parameters(scene) for part in p.name.split(".")}
    assert scene.muscle_model.sharing == "least_effort"


@pytest.mark.parametrize("file", FOUND)
def test_what_searches_found_are_scenes_of_the_creatures_described(tmp_path, file):
    described = file.replace("_found", "")
    (tmp_path / described).write_text(FILES[described])
    built, found = creature_scene(read_creature(tmp_path / described)), toml.loads(FILES[file])
    assert list(found.character.bodies) == list(built.character.bodies)
    assert list(found.character.muscles) == list(built.character.muscles)


def test_stiffness_grows_with_weight_and_height():
    creature = small_creature()
    leg = 1000 * np.pi * 0.05**2 * (0.8 + 4 / 3 * 0.05)
    assert weight_height(creature) == pytest.approx(9.8 * 0.9 * (30 + 2 * leg + 2 * 1), rel=1e-6)
    gains = creature_scene(creature).controller.pd
    assert gains["root"].kp.value == pytest.approx(10 * gains["lHip"].kp.value)
