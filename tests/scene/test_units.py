"""Every number of a scene has a unit, declared with the structure that has the number."""

import typing
from typing import Any

import pytest

from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Actuation, Balance, Curve, Excitation, Objective, Robustness, Scene
from warpmuscle.scene.controller import Command
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.part import Part
from warpmuscle.scene.terrain.tiles import Rough, Terrain, Waves
from warpmuscle.scene.units import units_of
from warpmuscle.scene.validation.checks import Checks
from warpmuscle.scene.water.part import Water


def parts_of(annotation: Any) -> set[Any]:
    """The types that an annotation is made of."""
    inner = typing.get_args(annotation)
    return {annotation}.union(*(parts_of(one) for one in inner)) if inner else {annotation}


def structures(part: type[Part], found: dict[type[Part], set[str]]) -> dict[type[Part], set[str]]:
    """All structures of a scene, and the fields of each that hold numbers."""
    if part not in found:
        found[part] = set()
        for name, annotation in typing.get_type_hints(part).items():
            made = parts_of(annotation)
            if float in made or Free in made:
                found[part].add(name)
            for other in made:
                if isinstance(other, type) and issubclass(other, Part):
                    structures(other, found)
                    found[part] |= {name} if other is Curve else set()
    return found


def test_every_number_of_every_structure_has_a_unit_and_nothing_else_has():
    for part, fields in structures(Scene, {}).items():
        if part is Command:  # it says its own unit
            continue
        if part is Robustness:
            fields.discard("commands")  # ranges of those
        assert set(units_of(part)) == fields, part.__name__


def free(value: float) -> Free:
    return Free(value, value - 0.01, value + 0.01)


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("actuation.rHip.stiffness", "N m/rad"), ("actuation.rHip.damping", "N m s/rad"),
        ("muscle_model.damping", ""), ("muscle_model.v_max", "l_opt/s"), ("objective.heading", ""),
        ("objective.target_speed", "m/s"), ("ground.stiffness", "N/m"), ("ground.damping", "N s/m"),
        ("failure.heading", "rad"), ("initial_state.heading", "rad"), ("failure.com_height", ""),
        ("controller.states.0.balance.velocity_z.value.0", "m/s"), ("controller.states.0.time", "s"),
        ("controller.states.0.trajectories.SWING_Hip.strength.value.0", ""),
        ("controller.root_predictive_torque_scale", "kg"), ("ground.normal.1", ""),
        ("initial_state.root_velocity.2", "m/s"),
    ],
)  # fmt: skip
def test_a_free_number_has_the_unit_of_its_own_structure(key: str, unit: str):
    scene = muscle_scene()
    scene.actuation["rHip"] = Actuation("passive", 5.0, 1.0)
    scene.initial_state.heading = 0.1
    scene.controller.states[0].balance = Balance(velocity_z=Curve([0.0], [0.1]))
    *path, last = key.split(".")
    owner: Any = scene
    for name in path:
        owner = owner[int(name)] if name.isdigit() else owner[name] if isinstance(owner, dict) else getattr(owner, name)
    if isinstance(owner, list):
        owner[int(last)] = free(owner[int(last)])
    elif isinstance(owner, tuple):
        values = tuple(free(v) if index == int(last) else v for index, v in enumerate(owner))
        setattr(getattr(scene, path[0]), path[1], values)
    else:
        setattr(owner, last, free(getattr(owner, last)))
    assert {p.name: p.unit for p in free_parameters(scene)}[key] == unit


@pytest.mark.parametrize(
    ("part", "key", "message"),
    [
        (Water(density=0.0), "density", "must be greater than 0, is 0"),
        (Water(drag=Free(1.0, -1.0, 2.0)), "drag", "must not be negative, is -1"),
        (Terrain([Waves(), Rough(seed=-1)]), "tiles.1.seed", "must not be negative, is -1"),
        ({"a": Waves(across=None), "b": Waves(across=-2.0)}, "b.across", "must be greater than 0, is -2"),
        (Excitation([0.0, 1.0], [0.5, Free(0.5, 0.0, 1.5)]), "value.1", "must be within 0 and 1, is 1.5"),
        (Objective(torque_by_joint={"lHip": -1.0}), "torque_by_joint.lHip", "must not be negative, is -1"),
        (Objective(head=-0.1), "head", "must not be negative, is -0.1"),
    ],
)  # fmt: skip
def test_numbers_must_be_in_the_ranges_that_their_fields_declare_wherever_they_stand(part, key, message):
    with pytest.raises(SceneError) as caught:
        Checks(muscle_scene()).ranges("part", part)
    assert (caught.value.key, caught.value.message) == (f"part.{key}", message)
