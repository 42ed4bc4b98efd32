"""Muscles with values of their own in the fused step: OpenSim's over time, mixed tendons, least activation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from opensim_bench import MODELS, Bench, as_ours
from probes import evaluate
from test_shaped_muscles import ours, pull

from muscle_arm import ZERO, X, constant
from warpmuscle.kernels.curve.curve_sets import LEE
from warpmuscle.kernels.curve.millard import CURVES, sampled
from warpmuscle.kernels.muscle.muscle import compliant_force, fibre_force
from warpmuscle.results.recording import Recording
from warpmuscle.scene import (
    Actuation,
    Body,
    Character,
    DeGrooteCurves,
    Excitation,
    Failure,
    Joint,
    MillardCurves,
    Motion,
    Muscle,
    MuscleModel,
    Pulley,
    Scene,
    ThelenCurves,
)
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout

NUMBERS = {"f_max": 1000.0, "l_opt": 0.1, "l_slack": 0.2, "pennation": 0.2}
TURNING = 0.3  # rad, by which the joint that muscles are stretched by turns to and fro


PULLED = {"forced": "turned", "pulled": "pulled"}  # children by joint
KINDS: dict[str, dict[str, Any]] = {  # so that all scenes run the same kernel
    "rigid": {"tendon": "rigid", "curve_shape": MillardCurves()},
    "groote": {"tendon": "rigid", "curve_shape": DeGrooteCurves()},
    "thelen": {"tendon": "compliant", "curve_shape": ThelenCurves()},
    "compliant": {"tendon": "compliant", "minimum_activation": 0.02},
}


def muscle(**own: Any) -> Muscle:
    return Muscle(**{**NUMBERS, "excitation": constant(0.6), **own})


def forced(muscles: dict[str, Muscle], rate: float = 2000.0, duration: float = 0.3, **model: Any) -> Scene:
    """Muscles that a joint stretches, by 0.1 m/rad; they pull on another one without a moment arm."""
    bodies = {name: Body(1.0, (1.0, 1.0, 1.0)) for name in ("base", "turned", "pulled")}
    joints = {name: Joint("hinge", "base", child, ZERO, ZERO, [X]) for name, child in PULLED.items()}
    time = np.linspace(0.0, duration, 61)
    motion = {"forced": Motion(time.tolist(), value=(TURNING * np.sin(12.0 * time)).tolist())}
    for own in muscles.values():
        own.pulleys = own.pulleys or [Pulley("forced", -0.1), Pulley("pulled", 0.0)]
        own.rest_length = own.rest_length or 0.3
    return Scene(
        "forced", Character("base", bodies, joints, "fixed", muscles), failure=Failure(0.0, 0.0), motion=motion,
        actuation={"forced": Actuation("kinematic"), "pulled": Actuation("muscle")}, duration=duration,
        time_step=1.0 / rate, muscle_model=MuscleModel(**{"curves": "millard", "activation": "scaled", **model}),
    )  # fmt: skip


def of_all_kinds(muscles: dict[str, Muscle], rate: float = 2000.0, **model: Any) -> Scene:
    """The same with muscles of all kinds behind these."""
    return forced(muscles | {name: muscle(**own) for name, own in KINDS.items()}, rate, **model)


def recorded(scene: Scene) -> Recording:
    """Every step of a simulation."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    return rollout.recording()


def test_muscles_of_one_scene_have_tendons_and_curves_of_their_own() -> None:
    """The force of each follows from what it does: of the tendon if compliant, of the fibre if rigid."""
    scene = of_all_kinds({})
    motion, muscles = recorded(scene), list(scene.character.muscles.values())
    path, fibre = motion.muscle_path_length.astype(float), motion.muscle_fibre_length.astype(float)
    along = np.sqrt(np.maximum(fibre**2 - (0.1 * np.sin(0.2)) ** 2, 0.0))
    rate = motion.muscle_fibre_velocity.astype(float) * fibre / along  # of the path, if rigid
    rigid = ours(pull, muscles, np.stack([motion.muscle_activation, path, rate], axis=-1))[..., 0]
    strain = (path - along) / 0.2 - 1.0
    theirs = [rigid[:, 0], rigid[:, 1], thelen_force(strain[:, 2]), millard_force(strain[:, 3])]
    for k, force in enumerate(theirs):
        assert np.ptp(force) > 0.2
        np.testing.assert_allclose(motion.muscle_force[:, k] / 1000.0, force, atol=1e-3)


def thelen_force(strain: np.ndarray) -> np.ndarray:
    """Thelen 2003, eq. 5, with a strain of 0.04 at f_max."""
    toe = 0.99 * 0.04 * np.exp(3.0) / (1.66 * np.exp(3.0) - 0.67)
    foot = 0.33 / np.expm1(3.0) * np.expm1(3.0 / toe * np.maximum(strain, 0.0))
    return np.where(strain > toe, 0.33 + 0.67 / (0.04 - toe) * (strain - toe), foot)


def millard_force(strain: np.ndarray) -> np.ndarray:
    """The tendon of Millard 2013 with OpenSim's defaults, in float64."""
    x = np.linspace(0.0, 0.049 + (2.0 / 3.0 - 1.0) * 0.049 / 1.375, 2001)
    value = sampled(CURVES["tendon"][0], [0.5] * 2, x)[0]
    return np.where(strain > x[-1], 2.0 / 3.0 + 1.375 / 0.049 * (strain - x[-1]), np.interp(strain, x, value))


def test_tendons_may_differ_without_shapes() -> None:
    motion = recorded(forced({"rigid": muscle(tendon="rigid"), "compliant": muscle(tendon="compliant")}, curves="lee"))
    fibre, width = motion.muscle_fibre_length, np.full(len(motion.time), 0.1 * np.sin(0.2))
    speed = motion.muscle_fibre_velocity[:, 0]
    own = evaluate(fibre_force, LEE, motion.muscle_activation[:, 0], fibre[:, 0] / 0.1, speed, 0.1)
    tendon = evaluate(compliant_force, LEE, motion.muscle_path_length[:, 1], fibre[:, 1], 0.2, width)
    expected = np.stack([own * np.sqrt(1.0 - (width / fibre[:, 0]) ** 2), tendon], axis=1)
    np.testing.assert_allclose(motion.muscle_force / 1000.0, expected, atol=1e-3)
    assert np.abs(np.diff(motion.muscle_force, axis=1)).max() > 50.0


def test_activation_never_falls_below_its_least_and_follows_a_greater_excitation() -> None:
    off = Excitation([0.0, 0.1, 0.1001], [0.5, 0.5, 0.0])
    one = recorded(
        of_all_kinds({"low": muscle(excitation=off, minimum_activation=0.07), "none": muscle(excitation=off)})
    )
    assert 0.07 <= one.muscle_activation[:, 0].min() < 0.0701
    assert one.muscle_activation[:, 1].min() < 0.01
    np.testing.assert_allclose(one.muscle_activation[180, 0], 0.5, atol=0.01)


def test_activation_falls_towards_an_excitation_below_its_least_as_fast_as_in_opensim() -> None:
    """OpenSim 4.6's Millard2012EquilibriumMuscle without control, from 0.05, with time constants of 0.01 and 0.04 s."""
    off = muscle(excitation=constant(0.0), minimum_activation=0.01, fall_time=0.04)
    one = recorded(of_all_kinds({"off": off}, activation="scaled", initial_activation=0.05))
    at = [np.argmin(np.abs(one.time - time)) for time in (0.01, 0.02, 0.05, 0.1)]
    expected = [0.04336059, 0.03768951, 0.02501898, 0.01294031]
    np.testing.assert_allclose(one.muscle_activation[at, 0], expected, rtol=0.012)


def test_own_rates_and_speeds_act() -> None:
    """A rise with the time constant of the muscle: 1 - exp(-t/tau) with linear rates."""
    ones = {
        "slow": muscle(rise_time=0.05, excitation=constant(1.0)), "fast": muscle(excitation=constant(1.0)),
        "damped": muscle(damping=2.0, excitation=constant(1.0)), "quick": muscle(v_max=30.0, excitation=constant(1.0)),
    }  # fmt: skip
    one = recorded(of_all_kinds(ones, activation="linear", initial_activation=0.0))
    time = np.arange(1, 41) / 2000.0
    np.testing.assert_allclose(one.muscle_activation[:40, 0], 1.0 - np.exp(-time / 0.05), atol=1e-5)
    np.testing.assert_allclose(one.muscle_activation[:40, 1], 1.0 - np.exp(-time / 0.01), atol=1e-5)
    speed, force = one.muscle_fibre_velocity[300:], one.muscle_force[300:]
    lengthening = speed[:, 1] > 0.05
    assert np.all(force[lengthening, 2] > force[lengthening, 1])  # against the pull
    shortening = speed[:, 1] < -0.05
    assert np.all(force[shortening, 3] > force[shortening, 1])  # less slowed


def test_strain_of_a_tendon_may_be_free() -> None:
    """Each instance has its own, the same as alone."""
    scene = of_all_kinds({"one": muscle(tendon="compliant", tendon_strain=Free(0.05, 0.02, 0.1))})
    strains = [0.02, 0.05, 0.1]
    rollout = Rollout(scene, 3, "cpu", record=range(3), record_rate=2000.0)
    rollout.set_parameters(np.array(strains)[:, None])
    rollout.run()
    for k, strain in enumerate(strains):
        alone = of_all_kinds({"one": muscle(tendon="compliant", tendon_strain=strain)})
        np.testing.assert_array_equal(rollout.recording(k).muscle_force, recorded(alone).muscle_force)
    assert np.abs(rollout.recording(0).muscle_force - rollout.recording(2).muscle_force)[:, 0].max() > 20.0


@pytest.mark.long
def test_metabolic_power_is_that_of_the_shaped_curves() -> None:
    """What the terms of a step add up is what the recorded motion gives; other than with the default curves."""
    from warpmuscle.gait.muscle_effort import spent

    spends = []
    for shape in (
        MillardCurves(),
        MillardCurves(active_from=0.25, active_bend=0.77, active_until=1.9, active_slope=0.75),
    ):
        scene = forced({"one": muscle(curve_shape=shape, rest_length=0.27)}, tendon="rigid")
        scene.objective = msgspec.structs.replace(scene.objective, metabolic=1.0)
        rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0)
        rollout.run()
        found = spent(rollout.recording(), scene)
        assert found is not None
        spends.append(found.power)
    assert abs(spends[0] - spends[1]) > 0.01 * spends[0]


# OpenSim's muscles over time.

STRETCHED = ("soleus_r", "tibant_r", "tib_ant_r", "recfem_r", "rect_fem_r")


@pytest.mark.parametrize("name", ["Rajagopal2016", "gait2392_thelen"])
@pytest.mark.parametrize("rate", [2000.0, 500.0])
def test_stretched_muscles_have_the_forces_of_opensim(name: str, rate: float, reference_data: Path) -> None:
    """Three muscles of a model, stretched to and fro with steps of excitation: within 1 % of f_max rms."""
    osim = pytest.importorskip("opensim")
    file = reference_data / MODELS[name]
    if not file.is_file():
        pytest.skip(f"no {file}")
    bench = Bench(file, osim)
    theirs = [
        one for one in bench.muscles if one.getName() in ("soleus_r", "tibant_r", "tib_ant_r", "recfem_r", "rect_fem_r")
    ]
    muscles = {}
    for one in theirs:
        rest = one.get_tendon_slack_length() * 1.01 + one.get_optimal_fiber_length()
        own = as_ours(one, rest)
        own.pulleys = [Pulley("forced", -one.get_optimal_fiber_length()), Pulley("pulled", 0.0)]  # 0.3 of its length
        own.excitation = Excitation([0.0, 0.1, 0.1001, 0.2, 0.2001], [0.8, 0.8, 0.05, 0.05, 0.5])
        muscles[one.getName()] = own
    motion = recorded(of_all_kinds(muscles, rate))
    force = np.array([integrated(bench, one, motion, k, rate) for k, one in enumerate(theirs)]).T
    error = motion.muscle_force[1:, : len(muscles)] / [own.f_max for own in muscles.values()] - force
    assert force.max() > 0.6
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.01


def integrated(bench: Any, one: Any, motion: Recording, k: int, rate: float) -> np.ndarray:
    """Tendon force over f_max by OpenSim's fibre speeds in fine steps, at our activations and path lengths."""
    fine = 20 if rate < 1000.0 else 5
    path, activation = motion.muscle_path_length[:, k].astype(float), motion.muscle_activation[:, k].astype(float)
    time = np.arange(len(path)) / rate
    l_opt, f_max = one.get_optimal_fiber_length(), one.get_max_isometric_force()
    bench.put(one, activation[0], path[0])
    fibre, force = one.getFiberLength(bench.state), []
    h = 1.0 / (fine * rate)
    for step in range(1, fine * (len(path) - 1) + 1):
        speed = 0.0
        for part in (0.0, 0.5):  # the midpoint rule
            at = (step - 1 + part) * h
            a, length = np.interp(at, time, activation), np.interp(at, time, path)
            bench.put(one, a, length, fibre + part * h * speed)
            speed = one.getFiberVelocity(bench.state)
        fibre = max(fibre + h * speed, 0.01 * l_opt)
        if step % fine == 0:
            bench.put(one, activation[step // fine], path[step // fine], fibre)
            force.append(one.getTendonForce(bench.state) / f_max)
    return np.array(force)
