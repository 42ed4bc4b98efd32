"""Bodies of other heights and masses: their sizes, muscles, and errors."""

import msgspec
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.scaling import path_lengths
from warpmuscle.scene.sizes.sized import height_of, sized


@pytest.fixture(scope="module")
def walker():
    return load("walk56")


def numeric(scene):
    return substitute(scene, start_values(scene))


@pytest.mark.parametrize(("height", "mass"), [(1.2, 18.0), (2.0, 130.0)])
def test_a_body_gets_its_height_and_mass(walker, height, mass):
    made = sized(walker, height, mass)
    assert height_of(made) == pytest.approx(height, rel=1e-9)
    assert body_mass(numeric(made).character) == pytest.approx(mass, rel=1e-9)


def test_inertia_grows_with_mass_and_the_square_of_length(walker):
    old, made = numeric(walker).character, numeric(sized(walker, 1.2, 18.0)).character
    length, mass = 1.2 / height_of(walker), 18.0 / body_mass(old)
    for name, body in made.bodies.items():
        assert body.inertia == pytest.approx([mass * length**2 * one for one in old.bodies[name].inertia])


def test_without_a_mass_the_build_stays(walker):
    own = height_of(walker)
    made = sized(walker, 1.1 * own)
    assert body_mass(numeric(made).character) == pytest.approx(1.331 * body_mass(numeric(walker).character))


def test_muscles_grow_with_their_paths_and_the_mass(walker):
    made = sized(walker, 1.2, 18.0)
    before, after = path_lengths(walker), path_lengths(made)
    mass = 18.0 / body_mass(numeric(walker).character)
    for name, muscle in numeric(made).character.muscles.items():
        old = numeric(walker).character.muscles[name]
        assert muscle.l_opt / old.l_opt == pytest.approx(after[name] / before[name])
        assert muscle.l_slack / old.l_slack == pytest.approx(after[name] / before[name])
        assert muscle.f_max / old.f_max == pytest.approx(mass)


def test_longer_arms_and_a_heavier_trunk(walker):
    made = sized(walker, lengths={"*arm": 1.2}, masses={"torso": 1.5})
    old, new = numeric(walker).character, numeric(made).character
    assert new.bodies["lUpperarm"].shapes[0].radius == pytest.approx(1.2 * old.bodies["lUpperarm"].shapes[0].radius)
    assert new.bodies["lUpperleg"].shapes == old.bodies["lUpperleg"].shapes
    share = new.bodies["torso"].mass / new.bodies["head"].mass
    assert share == pytest.approx(1.5 * old.bodies["torso"].mass / old.bodies["head"].mass)
    assert body_mass(new) == pytest.approx(body_mass(old))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"height": 5.0}, "height: must be between 0.3 and 3 m, is 5"),
        ({"mass": float("nan")}, "mass: must be between"),
        ({"lengths": {"*wing": 2.0}}, "lengths.*wing: names no body; there are pelvis"),
        ({"masses": {"torso": -1.0}}, "masses.torso: must be a positive factor, is -1"),
    ],
)
def test_what_no_body_has_is_refused(walker, given, words):
    with pytest.raises(SceneError) as caught:
        sized(walker, **given)
    assert words in str(caught.value)


def test_a_body_without_shapes_has_no_height(walker):
    character = msgspec.structs.replace(
        walker.character,
        bodies={name: msgspec.structs.replace(one, shapes=[]) for name, one in walker.character.bodies.items()},
    )
    with pytest.raises(SceneError, match="has no shapes"):
        height_of(msgspec.structs.replace(walker, character=character))
