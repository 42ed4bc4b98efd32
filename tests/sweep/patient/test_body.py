"""A scene's body gets the sizes and the mass of a patient's model."""

import msgspec
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about
from warpmuscle.formats import load
from warpmuscle.formats.overrides import with_values
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.sweep.patient.body import AREA, changes_to_size, sizes_of


def numeric(name: str, **changes: object) -> Scene:
    scene = with_values(load(name), {key.replace("__", "."): value for key, value in changes.items()})
    return substitute(scene, start_values(scene))


@pytest.fixture(scope="module")
def walker() -> Scene:
    return numeric("reflex_planar")


@pytest.fixture(scope="module")
def patient() -> Scene:
    shorter = {"scale.?Upperleg": 0.9, "scale.?Lowerleg": 0.95}
    scene = with_values(load("reflex_planar"), shorter | {"character.bodies.*.mass": {"factor": 1.2}})
    return substitute(scene, start_values(scene))


def test_thighs_shanks_and_mass_become_the_patients(walker: Scene, patient: Scene):
    changes = changes_to_size(walker, patient)
    found = with_values(walker, changes)
    assert sizes_of(found) == pytest.approx(sizes_of(patient), rel=1e-6)
    assert body_mass(found.character) == pytest.approx(body_mass(patient.character), rel=1e-6)
    ratio = body_mass(patient.character) / body_mass(walker.character)
    muscle = "lSOL"
    stronger = found.character.muscles[muscle].f_max / walker.character.muscles[muscle].f_max
    assert stronger == pytest.approx(ratio**AREA, rel=1e-6)


def test_both_sides_stay_alike_where_the_scene_begins_in_a_stride(patient: Scene):
    bent = numeric("reflex_planar")
    bent.initial_state.joints["lKnee"].orientation = tuple(about([1.0, 0.0, 0.0], 1.0))
    bent.initial_state.joints["rKnee"].orientation = (0.0, 0.0, 0.0, 1.0)
    muscles = with_values(bent, changes_to_size(bent, patient)).character.muscles
    for name in [name[1:] for name in muscles if name.startswith("l")]:
        for field in ("l_opt", "l_slack"):
            left, right = (getattr(muscles[side + name], field) for side in "lr")
            assert left == pytest.approx(right, rel=1e-9), name


def test_a_model_of_the_patient_stays_as_it_is(walker: Scene):
    assert changes_to_size(walker, walker) == {}


def test_what_has_no_legs_is_refused(walker: Scene):
    legless = msgspec.structs.replace(numeric("throw18"))
    with pytest.raises(Error, match="has no hip, knee and ankle"):
        changes_to_size(legless, walker)
