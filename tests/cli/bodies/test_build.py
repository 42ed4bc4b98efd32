"""`creature build` and `scale`: what they write is a scene; a wrong input is one line, and writes nothing."""

import re

import pytest

from command_line import run
from warpmuscle.formats import load
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.sizes.sized import height_of


def test_build_writes_a_scene_with_free_muscles(tmp_path):
    assert run("example", "creatures", folder=tmp_path).returncode == 0
    done = run("creature", "build", "kangaroo.toml", "-o", "hop.toml", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    scene = load(tmp_path / "hop.toml")
    assert scene.name == "hop"
    assert "8 bodies, 16 muscles" in done.stdout
    assert f"{len(free_parameters(scene))} free numbers" in done.stdout


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("mass", "1e-30", "segments.trunk: makes no sound scene: character.bodies.trunk.mass: must be at least"),
        ("radius", "1e-30", "segments.trunk: makes no sound scene: character.bodies.trunk.inertia"),
        ("end", "[0, 1e6, 0]", "segments.trunk: makes no sound scene: character.bodies.trunk.inertia"),
    ],
)
def test_what_makes_no_sound_scene_is_told_at_its_place_in_the_description(tmp_path, key, value, said):
    assert run("example", "creatures", folder=tmp_path).returncode == 0
    text = (tmp_path / "kangaroo.toml").read_text()
    (tmp_path / "wrong.toml").write_text(re.sub(rf"(?m)^{key} = .*", f"{key} = {value}", text, count=1))
    line = text[: text.index("[segments.trunk]")].count("\n") + 1
    done = run("creature", "build", "wrong.toml", "-o", "out.toml", folder=tmp_path)
    assert done.returncode == 2
    assert f"wrong.toml:{line}: {said}" in done.stderr
    assert not (tmp_path / "out.toml").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name = 3", "bad.toml:1: name"),
        ("not toml", "bad.toml:1"),
        ("name = 'a'\nwings = 2", "bad.toml:2: wings"),
        ("", "bad.toml"),
    ],
)
def test_a_bad_description_is_a_line_with_its_place_and_writes_nothing(tmp_path, text, words):
    (tmp_path / "bad.toml").write_text(text)
    done = run("creature", "build", "bad.toml", "-o", "out.toml", folder=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out.toml").exists()


@pytest.mark.parametrize(
    ("output", "words"), [("bad.toml", "is the description itself"), ("scene.h5", "is written as .toml")]
)
def test_what_is_written_is_another_toml_file(tmp_path, output, words):
    (tmp_path / "bad.toml").write_text("name = 'a'")
    done = run("creature", "build", "bad.toml", "-o", output, folder=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert (tmp_path / "bad.toml").read_text() == "name = 'a'"


def test_scale_writes_a_child_with_longer_arms(tmp_path):
    words = ("--height", 1.2, "--mass", 22, "--length", "*arm=1.1", "-o", "child.toml")
    done = run("scale", "fwalk", *words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "1.2 m, 22 kg" in done.stdout
    child, own = load(tmp_path / "child.toml"), load("fwalk")
    assert height_of(child) == pytest.approx(1.2, rel=1e-6)
    assert body_mass(substitute(child, start_values(child)).character) == pytest.approx(22.0, rel=1e-6)
    assert child.controller.pd["root"].kp.value < 0.3 * own.controller.pd["root"].kp.value


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--height", 9), "height: must be between 0.3 and 3 m, is 9"),
        (("--length", "arm"), "--length takes BODY=FACTOR"),
        (("--weight", "torso=heavy"), "--weight takes BODY=FACTOR"),
        (("--weight", "wings=2"), "masses.wings: names no body"),
    ],
)
def test_scale_refuses_what_no_body_is(tmp_path, words, said):
    done = run("scale", "fwalk", *words, "-o", "out.toml", folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out.toml").exists()
