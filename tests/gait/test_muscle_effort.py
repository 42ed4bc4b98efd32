"""Power, passive share and trembling of muscles whose state is made up, against the published formulas by hand."""

import math

import msgspec
import numpy as np
import pytest

from metabolic_powers import bhargava, margaria, umberger, wang
from small_result import walk_result, walk_scene, with_arrays
from warpmuscle.gait.muscle_effort import fibre_powers, muscle_power, spent, trembling
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.accounting import FORMULAS
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout

BASAL = 1.51  # W/kg
SHAPE, LONGEST = 0.3, 1.8  # of the hyperbolas of force and velocity, the force of a fast lengthening fibre


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The walk on 56 muscles."""
    return substitute(walk_scene(), start_values(walk_scene()))


def state(scene: Scene, length: float, level: float, force: float) -> Recording:
    """All muscles at rest at a length over l_opt, an activation and excitation, and a force over f_max."""
    motion = walk_result().replays[0].window(0.0, 0.1)
    muscles = [scene.character.muscles[name] for name in motion.muscle_names]
    f_max, l_opt = (np.array([getattr(m, name) for m in muscles], dtype=float) for name in ("f_max", "l_opt"))
    full = np.ones_like(motion.muscle_force)
    return with_arrays(
        motion, muscle_fibre_length=full * l_opt * length, muscle_fibre_velocity=0.0 * full,
        muscle_activation=full * level, muscle_excitation=full * level, muscle_force=full * f_max * force,
    )  # fmt: skip


def test_passive_share_is_the_passive_curve_over_the_tension(scene: Scene):
    passive = (math.exp(4.0 * 0.3 / 0.6) - 1.0) / (math.exp(4.0) - 1.0)  # Lee 2014, 1.3 l_opt
    found = spent(state(scene, 1.3, 0.0, 2.0 * passive), scene)
    assert found is not None
    assert found.passive_share == pytest.approx(0.5, rel=1e-4)
    assert found.power == pytest.approx(BASAL, rel=1e-6)


def test_power_at_rest_is_the_heat_of_activation_and_maintenance(scene: Scene):
    level, slow = 0.4, 0.5
    recruited = (slow * math.sin(0.5 * math.pi * level), (1.0 - slow) * (1.0 - math.cos(0.5 * math.pi * level)))
    heat = (40.0 + 74.0) * recruited[0] + (133.0 + 111.0) * recruited[1]  # W/kg of muscle at l_opt (Wang 2012)
    mass = sum(float(m.f_max) * float(m.l_opt) for m in scene.character.muscles.values()) * 1059.7 / 6e5
    found = spent(state(scene, 1.0, level, 0.4), scene)
    assert found is not None
    muscles = heat * mass / body_mass(scene.character)
    assert found.power == pytest.approx(BASAL + muscles, rel=1e-4)
    assert found.common_power == pytest.approx(BASAL + muscles * 0.6 / 0.25, rel=1e-4)
    assert found.passive_share == 0.0


def by_hand(motion: Recording, scene: Scene, formula, net: bool) -> np.ndarray:
    """Powers (F, M), W, in float64, with the curves of Lee 2014 (Bergmann 2017, eq. 4 and 5)."""
    muscles = [scene.character.muscles[name] for name in motion.muscle_names]
    f_max, l_opt = (np.array([float(getattr(m, name)) for m in muscles]) for name in ("f_max", "l_opt"))
    activation, excitation, fibre, speed = (
        np.asarray(motion[f"muscle_{name}"], dtype=np.float64)
        for name in ("activation", "excitation", "fibre_length", "fibre_velocity")
    )
    v_max = scene.muscle_model.v_max
    length, v = fibre / l_opt, speed / (l_opt * v_max)
    iso = np.exp(-((length - 1.0) ** 2) / 0.5)
    slower, longer = np.minimum(v, 0.0), (2.0 + 2.0 / SHAPE) / (LONGEST - 1.0) * np.maximum(v, 0.0)
    moving = np.where(v <= 0.0, (1.0 + slower) / (1.0 - slower / SHAPE), (1.0 + LONGEST * longer) / (1.0 + longer))
    force = f_max * activation * iso * moving
    further = {"v_max": v_max, "l_opt": l_opt} if formula is umberger else {}
    mass = f_max * l_opt * 1059.7 / 6e5
    return formula(activation, excitation, length, speed, force, iso, np.full_like(mass, 0.5), mass, net, **further)


@pytest.mark.parametrize(
    ("model", "formula", "net"),
    [
        ("wang", wang, False),
        ("umberger", umberger, True),
        ("bhargava", bhargava, True),
        ("margaria", margaria, False),
    ],
)
def test_energy_of_a_walk_is_that_of_the_published_formulas_by_hand(scene: Scene, model: str, formula, net: bool):
    short = msgspec.structs.replace(scene, duration=0.5, objective=Objective())
    batch = Rollout(short, 1, "cpu", record=[0], record_rate=200.0)
    batch.run()
    motion = batch.recording()
    expected = by_hand(motion, scene, formula, net)
    np.testing.assert_allclose(
        muscle_power(motion, counted(scene, metabolic_model=model)), expected, rtol=1e-3, atol=0.02
    )
    found = spent(motion, counted(scene, metabolic_model=model, basal_rate=0.0))
    assert found.power * body_mass(scene.character) == pytest.approx(expected.sum(axis=1).mean(), rel=1e-3)
    assert expected.std() > 1.0


def test_parts_of_a_fibre_have_the_powers_of_their_forces(scene: Scene):
    """By hand: of the contractile element -F v, of the passive fibre by Lee's curve, and the rest of the tension's."""
    still = state(scene, 1.3, 0.4, 0.7)
    muscles = [scene.character.muscles[name] for name in still.muscle_names]
    f_max, l_opt = (np.array([float(getattr(one, name)) for one in muscles]) for name in ("f_max", "l_opt"))
    rates = np.where(np.arange(len(muscles)) % 2, -1.5, 0.8) * l_opt  # m/s, of every second one shortening
    motion = with_arrays(still, muscle_fibre_velocity=np.broadcast_to(rates, still.muscle_force.shape).copy())
    found = fibre_powers(motion, scene)
    assert found is not None
    work = by_hand(motion, scene, lambda *state: -state[4] * state[3], net=True)
    cosine = np.cos(np.arcsin([math.sin(float(one.pennation)) / 1.3 for one in muscles]))
    passive = f_max * (math.exp(4.0 * 0.3 / 0.6) - 1.0) / (math.exp(4.0) - 1.0)
    np.testing.assert_allclose(found.active, work, rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(found.passive, np.broadcast_to(-passive * rates, work.shape), rtol=1e-4)
    np.testing.assert_allclose(sum(found), -motion.muscle_force * rates / cosine, rtol=1e-6)
    assert (found.active > 0.0).any()
    assert (found.active < 0.0).any()


def counted(scene: Scene, **objective) -> Scene:
    """The scene with another way of counting."""
    return msgspec.structs.replace(scene, objective=msgspec.structs.replace(scene.objective, **objective))


def test_other_metabolic_models_are_those_of_the_objective(scene: Scene):
    motion = state(scene, 1.0, 0.4, 0.4)
    powers = {model: spent(motion, counted(scene, metabolic_model=model)).power for model in FORMULAS}
    muscles = {model: spent(motion, counted(scene, metabolic_model=model, basal_rate=0.0)).power for model in FORMULAS}
    basal = {model: powers[model] - muscles[model] for model in FORMULAS}
    assert basal == pytest.approx({"wang": 1.51, "umberger": 1.2, "bhargava": 1.2, "margaria": 1.2}, rel=1e-5)
    assert muscles["wang"] == pytest.approx(muscles["bhargava"], rel=1e-6)  # they are the same at rest
    assert muscles["umberger"] > 1.2 * muscles["wang"]


@pytest.mark.parametrize(("model", "net"), [("wang", False), ("umberger", True), ("bhargava", True)])
def test_lengthening_fibres_give_back_their_work_where_net_work_counts(scene: Scene, model: str, net: bool):
    still = state(scene, 1.0, 0.4, 0.4)
    speeds = 0.2 * np.ones_like(still.muscle_fibre_velocity)
    motion = with_arrays(still, muscle_fibre_velocity=speeds)
    powers = {
        work: spent(motion, counted(scene, metabolic_model=model, metabolic_work=work)).power
        for work in ("net", "positive", None)
    }
    held = sum(0.4 * float(m.f_max) * 0.2 for m in scene.character.muscles.values()) / body_mass(scene.character)
    assert held < powers["positive"] - powers["net"] < 2.0 * held  # a lengthening fibre bears more than one held still
    assert powers[None] == powers["net" if net else "positive"]


def test_nothing_is_said_where_there_are_no_muscles_or_none_of_ours(scene: Scene):
    motion = state(scene, 1.0, 0.4, 0.4)
    ideal = msgspec.structs.replace(scene, muscle_model=msgspec.structs.replace(scene.muscle_model, ideal=True))
    assert spent(motion, ideal) is None
    assert spent(walk_result("fwalk").replays[0], walk_scene("fwalk")) is None


def test_trembling_is_the_part_of_the_power_above_the_frequency():
    time = np.linspace(0.0, 10.0, 2001)
    slow, fast = 0.1 * np.sin(2.0 * np.pi * 1.0 * time), 0.05 * np.sin(2.0 * np.pi * 20.0 * time)
    assert trembling(time, (0.5 + slow + fast)[:, None]) == pytest.approx(0.2, abs=1e-3)
    assert trembling(time, (0.5 + slow)[:, None]) == pytest.approx(0.0, abs=1e-6)
    both = np.stack([0.5 + slow + fast, 0.2 + 0.0 * time, slow], axis=1)  # weighted by power: 25/(125 + 100)
    assert trembling(time, both) == pytest.approx(25.0 / 225.0, abs=1e-3)


def test_trembling_cannot_be_told_of_few_frames_or_still_muscles():
    time = np.linspace(0.0, 10.0, 201)  # 20 Hz
    assert trembling(time, np.sin(time)[:, None]) is None
    fine = np.linspace(0.0, 10.0, 2001)
    assert trembling(fine, np.full((2001, 2), 0.3)) is None
    assert trembling(fine, np.zeros((2001, 0))) is None
    assert trembling(fine[:100], np.sin(fine[:100])[:, None]) is None
