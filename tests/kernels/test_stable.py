"""Stable names of `warpmuscle.kernels` are there, with the arguments that programs of others give them."""

import ast
import importlib
import re
from pathlib import Path
from typing import Any

import pytest
import warp as wp

from warpmuscle.kernels import structs
from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.stable import FIELDS, STABLE

ROOT = Path(__file__).parents[2]
POWER = "activation, excitation, length, speed, force, iso, slow, mass, negative_share"
STEP = "model, activation, mt_length, length, previous_length, l_opt, l_slack, width, v_max, damping, time_step"
SPEED = "model, activation, mt_length, start, reach, guess, l_opt, l_slack, width, damping"
# Typed here, so that a change of arguments is seen: who makes one tells users of it.
ARGUMENTS = {
    "objective.accelerations.centre_acceleration": "instance, body, model, work",
    "objective.accelerations.centre_of_mass": "instance, body, model, work",
    "learning.decision.goal_point": "instance, first, decision",
    "muscle.activation.activation_rate": "activation, excitation, rise_time, fall_time",
    "muscle.activation.activation_relaxed": "activation, excitation, rate, time_step",
    "muscle.activation.activation_step": "activation, excitation, rate, time_step",
    "contact.contact.friction_damping": "normal, slip, damping, friction",
    "contact.contact.normal_force": "depth, speed, stiffness, damping, time_step",
    "contact.terrain.above_surface": "instance, point, model",
    "control.control.CustomController": (
        "effort, excitation, update, parameters, state, shipped, by_joint, by_body, by_muscle, state_a_body, recorded"
    ),
    "curve.curves.active_force_length": "model, length",
    "curve.curves.force_velocity": "model, speed, activation",
    "curve.curves.force_velocity_slope": "model, speed, activation",
    "curve.curves.passive_force_length": "model, length",
    "curve.curves.tendon_force_slope": "model, strain",
    "curve.curves.tendon_force_strain": "model, strain",
    "force.forces.ForceKind": "effort, wrench, pair, parameters, state",
    "contact.hunt_crossley.friction_coefficient": "slip, material",
    "contact.hunt_crossley.hertz_force": "depth, hertz",
    "contact.hunt_crossley.smooth_hertz_force": "depth, hertz, smoothing, constant",
    "control.joint_values.joint_coordinate": "instance, body, k, model, state",
    "control.joint_values.joint_speed": "instance, body, k, model, state",
    "control.joint_values.joint_speeds": "body, model",
    "muscle.metabolics.bhargava_power": POWER,
    "muscle.metabolics.bhargava_strict_power": POWER,
    "muscle.metabolics.margaria_power": POWER,
    "muscle.metabolics.umberger_power": f"{POWER}, v_max, l_opt",
    "muscle.metabolics.wang_power": POWER,
    "muscle.muscle.along_tendon": "length, width",
    "muscle.muscle.bounded_fibre_length": "length, l_opt, width",
    "muscle.muscle.compliant_force": "model, mt_length, length, l_slack, width",
    "muscle.muscle.compliant_step": STEP,
    "muscle.muscle.equilibrium_speed": SPEED,
    "muscle.muscle.fibre_damping": "model, activation, length, speed, damping",
    "muscle.muscle.fibre_equilibrium": "model, activation, mt_length, l_opt, l_slack, width",
    "muscle.muscle.fibre_force": "model, activation, length, speed, damping",
    "muscle.muscle.pennation_cosine": "length, width",
    "muscle.muscle.rigid_fibre_length": "mt_length, l_opt, l_slack, width",
    "muscle.muscle.rigid_fibre_speed": "mt_speed, length, width",
    "muscle.muscle.rigid_force": "model, activation, mt_length, mt_speed, l_opt, l_slack, width, v_max, damping",
    "muscle.muscle.tendon_strain": "mt_length, length, l_slack, width",
    "muscle.muscles.activate": "muscles, excitation, step, time_step, state",
    "muscle.muscles.muscle_force_compliant": "muscles, mt_length, time_step, state",
    "muscle.muscles.muscle_force_rigid": "muscles, mt_length, mt_speed, state",
    "muscle.muscles.settle_fibres": "muscles, mt_length, state",
}
NUMBERS = {"LEE": 0, "THELEN": 1, "MILLARD": 2, "DE_GROOTE": 3, "THELEN_EXPLICIT": 4, "SARSHARI": 5}


def value_of(name: str) -> Any:
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(f"warpmuscle.kernels.{module}"), last)


def arguments(value: Any) -> str:
    if isinstance(value, wp.Function):
        return ", ".join(value.input_types)
    if isinstance(value, wp.Kernel):
        return ", ".join(argument.label for argument in value.adj.args)
    return ", ".join(value._fields)


@pytest.mark.parametrize("name", [f"{module}.{name}" for module, names in STABLE.items() for name in names])
def test_every_stable_name_is_there(name: str) -> None:
    value = value_of(name)
    if isinstance(value, wp.Function):
        assert value.__doc__ or value.func.__doc__, "what it does is said"
        assert name in ARGUMENTS


@pytest.mark.parametrize("name", ARGUMENTS)
def test_its_arguments_are_as_before(name: str) -> None:
    module, _, last = name.rpartition(".")
    assert last in STABLE[module]
    found, expected = arguments(value_of(name)), ARGUMENTS[name]
    assert found == expected or (not isinstance(value_of(name), wp.Function) and found.startswith(expected))


def test_curves_keep_their_numbers() -> None:
    assert {name: value_of(f"curve.curve_sets.{name}") for name in STABLE["curve.curve_sets"]} == NUMBERS


def test_structures_have_the_fields_that_functions_of_others_may_read() -> None:
    kinds = {"Decision": Decision, "MuscleWork": MuscleWork, "Wrench": Wrench}
    for name, fields in FIELDS.items():
        assert set(fields) <= set((kinds.get(name) or getattr(structs, name)).vars)


def test_whatever_the_manual_and_its_examples_import_is_stable() -> None:
    files = [*ROOT.glob("docs/**/*.md"), *ROOT.glob("warpmuscle/examples/files/*.py")]
    found = 0
    for file in files:
        for line in re.findall(r"^from warpmuscle\.kernels\S* import .+$", file.read_text(), re.MULTILINE):
            (statement,) = ast.parse(line).body
            assert isinstance(statement, ast.ImportFrom)
            module = (statement.module or "").removeprefix("warpmuscle.kernels").removeprefix(".")
            for alias in statement.names:
                whole = f"{module}.{alias.name}".removeprefix(".")
                assert alias.name in STABLE.get(module, ()) or whole in STABLE, f"{file}: {line}"
                found += 1
    assert found > 10
