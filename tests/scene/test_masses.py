"""Masses of muscles: from their specific tension, in words, against published models, and too great for a body."""

import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import msgspec
import numpy as np
import pytest

from muscle_arm import arm, constant
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, scene_names, toml
from warpmuscle.scene import Muscle, MuscleModel, Objective, Scene
from warpmuscle.scene.masses import (
    COMMON_TENSION,
    at_common_tension,
    center_of_mass,
    common_mass,
    mass_warnings,
    muscle_mass,
    muscle_mass_text,
    total_mass,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout


def muscle(f_max: float, l_opt: float, **further) -> Muscle:
    return Muscle(f_max=f_max, l_opt=l_opt, l_slack=0.1, **further)


def human() -> Scene:
    scene = load("walk56_human")
    return substitute(scene, start_values(scene))


def test_mass_is_that_of_a_column_that_bears_the_force():
    assert muscle_mass(muscle(2500.0, 0.1), 2.5e5) == pytest.approx(0.01 * 0.1 * 1059.7)
    each = muscle_mass(muscle(np.array([2500.0, 5000.0]), 0.1), 2.5e5)
    np.testing.assert_allclose(each, [1.0597, 2.1194])


def test_a_muscles_own_tension_overrides_that_of_the_model():
    muscles = [muscle(2500.0, 0.1), muscle(2500.0, 0.1, specific_tension=2.5e5)]
    assert total_mass(muscles, MuscleModel(specific_tension=5e5)) == pytest.approx(1.5 * 1.0597)
    assert common_mass(muscles) == pytest.approx(2.0 * 1.0597)
    text = muscle_mass_text(muscles, MuscleModel(specific_tension=5e5))
    assert text == "1.59 kg of muscle at 0.25 MPa to 0.5 MPa, 0.333 MPa in the mean (2.12 kg at 0.25 MPa)"


def test_the_default_is_said_beside_what_other_programs_take():
    muscles = list(human().character.muscles.values())
    assert sum(float(m.f_max) * float(m.l_opt) for m in muscles) == pytest.approx(15570.0, rel=1e-3)
    assert muscle_mass_text(muscles, MuscleModel()) == "27.5 kg of muscle at 0.6 MPa (66 kg at 0.25 MPa)"
    assert muscle_mass_text(muscles, MuscleModel(specific_tension=COMMON_TENSION)) == "66 kg of muscle at 0.25 MPa"


def test_muscles_of_a_published_model_of_legs_weigh_what_those_of_people_do(reference_data: Path):
    """Volumes of both legs by MRI, regression of Handsfield 2014: 47 cm^3/(kg m) mass height + 1285 cm^3 each."""
    path = reference_data / "opensim_models" / "Rajagopal2016.osim"
    root = ET.parse(path).getroot()
    found = [
        muscle(float(force.text), float(length.text))
        for element in root.iter()
        if (force := element.find("max_isometric_force")) is not None
        and (length := element.find("optimal_fiber_length")) is not None
        and element.get("name") != "default"
    ]
    people = 2.0 * (47.0 * 75.3 * 1.70 + 1285.0) * 1e-6 * 1059.7
    assert len(found) == 80
    assert total_mass(found, MuscleModel()) == pytest.approx(people, rel=0.1)
    assert common_mass(found) > 2.0 * people


def test_no_shipped_scene_has_more_muscle_than_a_body_has_room_for():
    for name in scene_names():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = load(name)
        assert mass_warnings(scene) == [], name


def test_too_much_muscle_is_a_warning_with_its_place(tmp_path: Path):
    light = 'name = "light"\nbase = "walk56_human"\n[muscle_model]\nspecific_tension = {}\n'
    file = tmp_path / "light.toml"
    file.write_text(light.format("0.52e6"))  # 45.1 %
    with pytest.warns(SceneWarning) as caught:
        scene = load(file)
    (warning,) = caught
    assert str(warning.message).startswith(f"{file}:4: muscle_model.specific_tension: 31.7 kg of muscle are 45.1 % of")
    assert len(mass_warnings(scene)) == 1
    file.write_text(light.format("0.53e6"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load(file)


@pytest.mark.parametrize("tension", [0.0, -6e5, 0.6, 1e9, Free(6e5, 0.0, 1e6)])
@pytest.mark.parametrize("own", [False, True])
def test_a_tension_that_no_muscle_has_is_named(own: bool, tension):
    scene = arm("hinge", {})
    owner = scene.character.muscles["extensor"] if own else scene.muscle_model
    owner.specific_tension = tension
    with pytest.raises(SceneError, match="must be within 1000 and 1e\\+08 Pa") as caught:
        check_scene(scene)
    assert caught.value.key == f"{'character.muscles.extensor' if own else 'muscle_model'}.specific_tension"


@pytest.mark.usefixtures("unoptimized_test")
def test_tension_may_be_free_and_changes_the_energy_of_each_instance_but_no_motion():
    pulling = {"excitation": constant(0.6)}
    scene = arm("hinge", pulling, duration=0.2, objective=Objective(metabolic=1.0, basal_rate=0.0))
    scene.muscle_model = MuscleModel(initial_activation=0.5, specific_tension=Free(6e5, 2e5, 1e6))
    (parameter,) = free_parameters(scene)
    assert (parameter.name, parameter.unit) == ("muscle_model.specific_tension", "Pa")
    check_scene(scene)
    rollout = Rollout(scene, 3, "cpu", record=[0, 1, 2])
    rollout.set_parameters(np.array([[3e5], [6e5], [6e5]]))
    rollout.run()
    heavy, light, same = rollout.terms()["metabolic"]
    assert light == same
    assert light < heavy < 2.0 * light  # heats grow with the mass, work does not
    np.testing.assert_array_equal(rollout.recording(0).joint_orientation, rollout.recording(1).joint_orientation)


def test_tensions_are_kept_by_a_scene_file():
    scene = arm("hinge", {})
    scene.muscle_model.specific_tension = 5e5
    scene.character.muscles["extensor"].specific_tension = 7e5
    scene.objective = Objective(metabolic_model="bhargava", metabolic_work="positive", basal_rate=1.1)
    again = toml.loads(toml.dumps(scene))
    assert again.muscle_model.specific_tension == 5e5
    assert [m.specific_tension for m in again.character.muscles.values()].count(7e5) == 1
    assert again.objective == scene.objective
    common = at_common_tension(again)
    assert total_mass(list(common.character.muscles.values()), common.muscle_model) == pytest.approx(
        common_mass(list(again.character.muscles.values()))
    )
    assert msgspec.structs.asdict(again.muscle_model)["specific_tension"] == 5e5  # which is left as it was


def test_centre_of_mass_is_the_mean_of_bodies_weighed_by_their_masses():
    character = human().character
    heavy = {
        name: msgspec.structs.replace(body, mass=1.0 + k) for k, (name, body) in enumerate(character.bodies.items())
    }
    character = msgspec.structs.replace(character, bodies=heavy)
    places = {name: np.array([float(k), 0.0, 2.0]) for k, name in enumerate(heavy)}
    count = np.arange(len(heavy))
    expected = [np.average(count, weights=1.0 + count), 0.0, 2.0]
    np.testing.assert_allclose(center_of_mass(character, places), expected)
    nothing = {name: msgspec.structs.replace(body, mass=0.0) for name, body in heavy.items()}
    character = msgspec.structs.replace(character, bodies=nothing)
    np.testing.assert_array_equal(center_of_mass(character, places), 0.0)
